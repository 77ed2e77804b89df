// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/unfold/ring.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double island_share = 0.05;  // of the largest part's area
constexpr double hole_share = 0.2;     // of the whole area
/// The free edge of a ring is never shorter than this share of the annulus (0.4 of a fully closed funnel, 0.9 open); a hole in one leaflet is.
constexpr double second_border_share = 0.3;
constexpr double ring_edge = 1.0;  // mm, edges of the ring that is unfolded

std::size_t at(long i) { return static_cast<std::size_t>(i); }
std::string place(const Vec3& x) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", x.x(), x.y(), x.z()); }

Vec3 centre_of(const RawMesh& mesh, const std::vector<int>& loop) {
  Vec3 sum = Vec3::Zero();
  double weights = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec3 &a = mesh.points[at(loop[i])], &b = mesh.points[at(loop[(i + 1) % loop.size()])];
    sum += (b - a).norm() * 0.5 * (a + b);
    weights += (b - a).norm();
  }
  return sum / weights;
}

/// Mean over points of the distance to a closed polygon.
double mean_distance(const RawMesh& mesh, const std::vector<int>& loop, const std::vector<Vec3>& curve) {
  double sum = 0;
  for (int v : loop) {
    double nearest = 1e300;
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Vec3 &a = curve[i], d = curve[(i + 1) % curve.size()] - a, p = mesh.points[at(v)];
      const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
      nearest = std::min(nearest, (a + t * d - p).norm());
    }
    sum += nearest;
  }
  return sum / static_cast<double>(loop.size());
}

struct LoopShape {
  double planarity = 0;  // rms distance from its plane over its mean radius
  double area = 0;       // projected on its plane, mm2
};

LoopShape shape_of(const RawMesh& mesh, const std::vector<int>& loop) {
  const Vec3 centre = centre_of(mesh, loop);
  Mat3 covariance = Mat3::Zero();
  for (int v : loop) covariance += (mesh.points[at(v)] - centre) * (mesh.points[at(v)] - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(covariance / static_cast<double>(loop.size()));
  const Vec3 normal = solver.eigenvectors().col(0);
  LoopShape shape;
  shape.planarity = std::sqrt(std::max(0.0, solver.eigenvalues()[0]) / solver.eigenvalues()[2]);
  for (std::size_t i = 0; i < loop.size(); ++i)
    shape.area += 0.5 * normal.dot((mesh.points[at(loop[i])] - centre).cross(mesh.points[at(loop[(i + 1) % loop.size()])] - centre));
  shape.area = std::abs(shape.area);
  return shape;
}

/// true: `first` is the annulus.
bool first_is_annulus(const RawMesh& mesh, const std::vector<int>& first, const std::vector<int>& second, const RawLeaflets& raw,
                      std::string& rule) {
  if (!raw.annulus_curve.empty()) {
    const double a = mean_distance(mesh, first, raw.annulus_curve), b = mean_distance(mesh, second, raw.annulus_curve);
    if (std::min(a, b) > 6)
      throw InputError(fmt::format("leaflets: the annulus curve lies {:.1f} and {:.1f} mm (mean) away from the two borders of the leaflets; expected "
                                   "one of them on it. Is the curve of this valve, in mm and RAS?",
                                   a, b));
    rule = fmt::format("the annulus curve ({:.1f} mm from this border, {:.1f} mm from the other)", std::min(a, b), std::max(a, b));
    return a < b;
  }
  const Vec3 ca = centre_of(mesh, first), cb = centre_of(mesh, second);
  std::optional<Vec3> down = raw.ventricle_direction;
  rule = "the given direction to the ventricle";
  if (!down && !raw.papillary_points.empty()) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : raw.papillary_points) mean += p / static_cast<double>(raw.papillary_points.size());
    down = mean - 0.5 * (ca + cb);
    rule = "the papillary points";
  }
  if (down && down->norm() > 0) {
    const double apart = (cb - ca).dot(down->normalized());
    if (std::abs(apart) > 1.0) {
      rule += fmt::format(" (the free edge hangs {:.1f} mm lower)", std::abs(apart));
      return apart > 0;
    }
  }
  // Three votes: the annulus is flatter, spans more area, and is not longer than a wavy free edge would be for its area.
  const LoopShape a = shape_of(mesh, first), b = shape_of(mesh, second);
  const double la = loop_length(mesh, first), lb = loop_length(mesh, second);
  int votes = 0;
  votes += a.planarity < b.planarity ? 1 : -1;
  votes += a.area > b.area ? 1 : -1;
  votes += la * la / a.area < lb * lb / b.area ? 1 : -1;
  const bool close_call = std::abs(a.area - b.area) < 0.05 * std::max(a.area, b.area) && std::abs(a.planarity - b.planarity) < 0.02;
  if (close_call)
    throw InputError(
        "leaflets: nothing tells annulus from free edge (both borders are equally large and flat); give papillary points, an annulus curve or "
        "the direction to the ventricle (patient.ventricle_direction)");
  rule = fmt::format("{} of 3: flatter, larger, rounder", votes == 0 ? 0 : (std::abs(votes) + 3) / 2);
  return votes > 0;
}

bool has_both(const RawMesh& mesh) {
  const auto has = [&](int label) { return std::find(mesh.region.begin(), mesh.region.end(), label) != mesh.region.end(); };
  return has(posterior) && has(anterior);
}

double ring_depth(const RawMesh& mesh, const std::vector<std::vector<int>>& loops) {
  return loops.size() < 2 ? 0 : loop_length(mesh, loops[1]) / loop_length(mesh, loops[0]);
}

void fill_holes(RawMesh& mesh, std::vector<std::vector<int>> loops, std::size_t kept, std::vector<std::string>& notes) {
  const double whole = mesh.area();
  double filled = 0;
  for (std::size_t i = kept; i < loops.size(); ++i) {
    const std::size_t before = mesh.triangles.size();
    fill_hole(mesh, loops[i]);
    double area = 0;
    for (std::size_t t = before; t < mesh.triangles.size(); ++t) area += mesh.area(t);
    filled += area;
    if (filled > hole_share * whole)
      throw InputError(fmt::format("leaflets: holes of {:.0f} mm2 in a surface of {:.0f} mm2, the last near {}; too much is missing to guess it", filled,
                                   whole, place(mesh.points.back())));
    notes.push_back(fmt::format("a hole of {:.1f} mm2 near {} was filled smoothly", area, place(mesh.points.back())));
  }
}

}  // namespace

std::optional<Vec3> downward(const RawMesh& mesh, const RawLeaflets& raw) {
  if (raw.ventricle_direction && raw.ventricle_direction->norm() > 0) return raw.ventricle_direction->normalized();
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : mesh.points) centre += p / static_cast<double>(mesh.points.size());
  if (!raw.papillary_points.empty()) {
    Vec3 mean = Vec3::Zero();
    for (const Vec3& p : raw.papillary_points) mean += p / static_cast<double>(raw.papillary_points.size());
    if ((mean - centre).norm() > 1) return (mean - centre).normalized();
  }
  if (raw.annulus_curve.size() >= 8) {
    const Annulus plane = fit_annulus_plane(raw.annulus_curve);
    const double side = (centre - plane.origin).dot(plane.normal);
    if (std::abs(side) > 0.5) return side > 0 ? plane.normal : Vec3(-plane.normal);
  }
  return std::nullopt;
}

Ring make_ring(const RawMesh& clean, const RawLeaflets& raw, const LeafletSurfaceOptions& options, std::vector<std::string>& notes) {
  std::vector<RawMesh> parts = connected_parts(clean);
  const double largest = parts.front().area();
  std::size_t kept = 1;
  while (kept < parts.size() && parts[kept].area() >= island_share * largest) ++kept;
  if (kept < parts.size()) {
    double area = 0;
    for (std::size_t p = kept; p < parts.size(); ++p) area += parts[p].area();
    notes.push_back(fmt::format("{} loose pieces ({:.1f} mm2 in all) were dropped", parts.size() - kept, area));
    parts.resize(kept);
  }
  int rings = 0;
  for (RawMesh& part : parts) {
    const auto loops = border_loops(part);
    if (loops.empty())
      throw InputError("leaflets: the surface is closed, it has neither annulus nor free edge; a thick valve must be reduced to its mid-surface first");
    if (const int g = handles(part, loops.size()); g > 0)
      throw InputError(fmt::format("leaflets: the surface has {} handles (bridges or tunnels, as where leaflets of a segmentation grow together); separate "
                                   "them in the segmentation",
                                   g));
    const bool is_ring = ring_depth(part, loops) >= second_border_share;
    rings += is_ring;
    fill_holes(part, loops, is_ring ? 2 : 1, notes);
  }
  Ring ring;
  if (parts.size() == 1) {
    if (rings == 0)
      throw InputError(
          "leaflets: one sheet with one border, as of one leaflet only or of a ring that is open at a commissure; expected a ring, or two "
          "leaflets");
    ring.mesh = std::move(parts.front());
  } else if (rings >= 2) {
    throw InputError(fmt::format("leaflets: {} rings, each with an annulus of its own; give the mitral valve alone", rings));
  } else if (rings == 1) {
    throw InputError(fmt::format("leaflets: a ring and {} more pieces of at least {:.0f} % of its size; is a piece of another valve or of the wall "
                                 "left in the surface?",
                                 parts.size() - 1, 100 * island_share));
  } else if (parts.size() > 2) {
    throw InputError(fmt::format("leaflets: {} separate sheets; expected a ring, or two leaflets (join scallops to leaflets first)", parts.size()));
  } else {
    for (std::size_t p = 0; p < 2 && !has_both(clean); ++p)
      std::fill(parts[p].region.begin(), parts[p].region.end(), p == 0 ? posterior : anterior);
    ring.mesh = join_leaflets(std::move(parts[0]), std::move(parts[1]), raw, options.commissure_gap, notes);
  }
  refine(ring.mesh, ring_edge);
  const auto loops = border_loops(ring.mesh);
  if (loops.size() != 2) throw InputError(fmt::format("leaflets: {} borders after joining, expected annulus and free edge", loops.size()));
  const bool first = first_is_annulus(ring.mesh, loops[0], loops[1], raw, ring.annulus_rule);
  ring.annulus = loops[first ? 0 : 1];
  ring.free_edge = loops[first ? 1 : 0];
  ring.has_names = has_both(clean);
  ring.has_regions = has_both(ring.mesh);
  return ring;
}

}  // namespace mv
