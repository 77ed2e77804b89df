// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/thick/thick_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/surface/surface_query.h"
#include "geometry/volume/gates.h"

namespace mv {
namespace {

constexpr double same_way = 0.5;         // cosine between the normals of a point and of the surface it goes to
constexpr double slender = 15;           // degrees
constexpr double slender_share = 0.5;    // of the angle it had
constexpr int smoothings = 3, attempts = 12;

std::size_t at(long i) { return static_cast<std::size_t>(i); }

Vec3 normal_of(const std::vector<Vec3>& p, const std::array<int, 3>& t) { return (p[at(t[1])] - p[at(t[0])]).cross(p[at(t[2])] - p[at(t[0])]); }

double smallest_angle(const std::vector<Vec3>& p, const std::array<int, 3>& t) {
  double least = 180;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 a = p[at(t[(k + 1) % 3])] - p[at(t[k])], b = p[at(t[(k + 2) % 3])] - p[at(t[k])];
    least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::acos(-1.0));
  }
  return least;
}

}  // namespace

LeafletBoundary boundary_of(const LeafletMesh& layers) {
  const BoundarySurface surface = extract_boundary(layers);
  LeafletBoundary b;
  std::vector<int> index(layers.points.size(), -1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      int& i = index[at(surface.triangles[t][k])];
      if (i < 0) {
        const std::size_t p = at(surface.triangles[t][k]);
        i = static_cast<int>(b.points.size());
        b.points.push_back(layers.points[p]);
        b.on_annulus.push_back(layers.on_annulus[p]);
        b.on_free_edge.push_back(layers.on_free_edge[p]);
        b.side.push_back(layers.side[p]);
        b.unfolded.push_back(layers.unfolded[p]);
      }
      triangle[k] = i;
    }
    b.triangles.push_back(triangle);
    b.region.push_back(layers.region[at(surface.element[t])]);
  }
  return b;
}

FaceFit move_to_faces(LeafletBoundary& b, const SolidSurface& measured, double reach) {
  const SurfaceQuery query(measured.points, measured.triangles);
  const std::size_t n = b.points.size();
  std::vector<Vec3> normal(n, Vec3::Zero());
  std::vector<std::set<int>> neighbours(n);
  for (const auto& t : b.triangles) {
    const Vec3 f = normal_of(b.points, t);
    for (std::size_t k = 0; k < 3; ++k) {
      normal[at(t[k])] += f;
      neighbours[at(t[k])].insert({t[(k + 1) % 3], t[(k + 2) % 3]});
    }
  }
  const auto is_face = [&](std::size_t i) { return b.side[i] != between && !b.on_annulus[i] && !b.on_free_edge[i]; };
  const auto distances = [&](double& mean, double& largest) {
    long count = 0;
    mean = largest = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!is_face(i)) continue;
      const double d = query.nearest(b.points[i]).distance;
      mean += d;
      largest = std::max(largest, d);
      ++count;
    }
    if (count > 0) mean /= static_cast<double>(count);
  };
  FaceFit fit;
  distances(fit.before_mean, fit.before_max);

  std::vector<Vec3> shift(n, Vec3::Zero());
  std::vector<char> is_known(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    if (b.on_annulus[i]) {
      is_known[i] = 1;
      continue;
    }
    const auto hit = query.nearest(b.points[i]);
    const Vec3 there = normal_of(measured.points, measured.triangles[at(hit.triangle)]).normalized();
    if (hit.distance > reach || there.dot(normal[i].normalized()) < same_way) continue;
    shift[i] = hit.point - b.points[i];
    is_known[i] = 1;
  }
  const auto smooth = [&](bool all) {
    const std::vector<Vec3> old = shift;
    for (std::size_t i = 0; i < n; ++i) {
      if (b.on_annulus[i] || (is_known[i] && !all)) continue;
      Vec3 mean = Vec3::Zero();
      for (const int j : neighbours[i]) mean += old[at(j)] / static_cast<double>(neighbours[i].size());
      shift[i] = is_known[i] ? Vec3(0.5 * (old[i] + mean)) : mean;
    }
  };
  for (int k = 0; k < 10 * smoothings; ++k) smooth(false);
  smooth(true);
  // Sideways motion is smoothed further: it only pulls triangles about.
  for (int k = 0; k < smoothings; ++k) {
    const std::vector<Vec3> old = shift;
    for (std::size_t i = 0; i < n; ++i) {
      if (b.on_annulus[i]) continue;
      Vec3 mean = Vec3::Zero();
      for (const int j : neighbours[i]) mean += old[at(j)] / static_cast<double>(neighbours[i].size());
      const Vec3 d = normal[i].normalized();
      shift[i] = d * d.dot(old[i]) + (mean - d * d.dot(mean));
    }
  }

  std::vector<double> share(n, 1.0);
  std::vector<Vec3> moved(n);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    for (std::size_t i = 0; i < n; ++i) moved[i] = b.points[i] + (attempt + 1 == attempts && share[i] < 1 ? 0.0 : share[i]) * shift[i];
    bool is_good = true;
    for (const auto& t : b.triangles) {
      const Vec3 before = normal_of(b.points, t), after = normal_of(moved, t);
      const double had = smallest_angle(b.points, t), angle = smallest_angle(moved, t);
      if (before.dot(after) > same_way * before.norm() * after.norm() && angle > std::min(slender, slender_share * had)) continue;
      is_good = false;
      for (const int i : t) share[at(i)] *= 0.5;
    }
    if (is_good) break;
  }
  fit.held_back = std::count_if(share.begin(), share.end(), [](double s) { return s < 1; });
  b.points = moved;
  distances(fit.after_mean, fit.after_max);
  return fit;
}

}  // namespace mv
