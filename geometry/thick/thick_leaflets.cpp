// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/thick/thick_leaflets.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "geometry/core/errors.h"
#include "geometry/surface/surface_query.h"
#include "geometry/thick/relocate.h"
#include "geometry/volume/gates.h"

namespace mv {
namespace {

constexpr std::array volume_shares{0.45, 0.36, 0.28, 0.22};  // of a regular tetrahedron's of the wanted edge, one after the other until all is well
constexpr double long_step = 1.25;   // spacings
constexpr double long_share = 5e-4;  // of the tetrahedra that may have longer ones
constexpr double angle_reserve = 2;  // degrees above the limit up to which inner points are relocated
constexpr double reach_share = 0.6;  // of the largest thickness: how far a face may lie from where the mid-surface puts it

std::size_t at(long i) { return static_cast<std::size_t>(i); }

TetTrial judge(TetMesher mesher, const TetFill& fill, double limit, double longest_step) {
  TetTrial trial{mesher, fill.points.size(), fill.tets.size(), 180, 0, 0, 0, ""};
  for (const auto& t : fill.tets) {
    const auto angles = dihedral_angles(fill.points[at(t[0])], fill.points[at(t[1])], fill.points[at(t[2])], fill.points[at(t[3])]);
    const auto [least, most] = std::minmax_element(angles.begin(), angles.end());
    trial.dihedral_min = std::min(trial.dihedral_min, *least);
    trial.dihedral_max = std::max(trial.dihedral_max, *most);
    trial.below_limit += *least < limit;
    trial.too_long += spanning_step({fill.points[at(t[0])], fill.points[at(t[1])], fill.points[at(t[2])], fill.points[at(t[3])]}) > longest_step;
  }
  return trial;
}

bool is_better(const TetTrial& a, const TetTrial& b) {
  if (a.below_limit != b.below_limit) return a.below_limit < b.below_limit;
  const auto has_long = [](const TetTrial& t) { return static_cast<double>(t.too_long) > long_share * static_cast<double>(t.tets); };
  if (has_long(a) != has_long(b)) return has_long(b);
  return a.dihedral_min > b.dihedral_min;
}

/// What the mid-surface says about a place in the tissue.
class Place {
 public:
  explicit Place(const MidSurface& s) : surface_(s), query_(s.points, s.triangles) {}

  struct Answer {
    Vec2 unfolded;
    Vec3 normal;
    int region;
    double height;  // mm above the mid-surface, towards the atrium
    double thickness;
  };
  Answer at_point(const Vec3& x, double uniform_thickness) const {
    const auto hit = query_.nearest(x);
    const auto& t = surface_.triangles[at(hit.triangle)];
    const auto uv = unfolded_triangle(surface_, hit.triangle);
    Answer a{Vec2::Zero(), Vec3::Zero(), surface_.region[at(hit.triangle)], 0, 0};
    for (int k = 0; k < 3; ++k) {
      a.unfolded += hit.weights[k] * uv[at(k)];
      a.normal += hit.weights[k] * surface_.normals[at(t[at(k)])];
      a.thickness += hit.weights[k] * (surface_.thickness.empty() ? uniform_thickness : surface_.thickness[at(t[at(k)])]);
    }
    if (surface_.perimeter > 0) a.unfolded.x() -= surface_.perimeter * std::floor(a.unfolded.x() / surface_.perimeter);
    a.normal.normalize();
    a.height = (x - hit.point).dot(a.normal);
    return a;
  }

 private:
  const MidSurface& surface_;
  SurfaceQuery query_;
};

Vec3 parallel_to_annulus(const Vec3& axis, const Vec3& normal) {
  Vec3 tangent = axis.cross(normal);
  if (tangent.norm() < 1e-6) tangent = normal.unitOrthogonal();
  return (tangent - tangent.dot(normal) * normal).normalized();
}

LeafletMesh mesh_of(const MidSurface& surface, const LeafletBoundary& boundary, const TetFill& fill, const ThickOptions& o) {
  const Place place(surface);
  LeafletMesh m;
  m.points = fill.points;
  m.on_annulus = boundary.on_annulus;
  m.on_free_edge = boundary.on_free_edge;
  m.side = boundary.side;
  m.unfolded = boundary.unfolded;
  for (std::size_t i = boundary.points.size(); i < fill.points.size(); ++i) {
    m.on_annulus.push_back(0);
    m.on_free_edge.push_back(0);
    m.side.push_back(between);
    m.unfolded.push_back(place.at_point(fill.points[i], o.thickness).unfolded);
  }
  std::map<std::array<int, 3>, int> region_of;  // of the boundary's triangles: the leaflets meet along the same lines as in the layers
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
    std::array<int, 3> key = boundary.triangles[t];
    std::sort(key.begin(), key.end());
    region_of[key] = boundary.region[t];
  }
  for (const auto& t : fill.tets) {
    const Vec3 middle = 0.25 * (fill.points[at(t[0])] + fill.points[at(t[1])] + fill.points[at(t[2])] + fill.points[at(t[3])]);
    const Place::Answer here = place.at_point(middle, o.thickness);
    int region = here.region;
    for (std::array<int, 3> face : {std::array{t[0], t[1], t[2]}, std::array{t[0], t[1], t[3]}, std::array{t[0], t[2], t[3]}, std::array{t[1], t[2], t[3]}}) {
      std::sort(face.begin(), face.end());
      if (const auto found = region_of.find(face); found != region_of.end()) {
        region = found->second;
        break;
      }
    }
    m.tets.push_back({t[0], t[1], t[2], t[3], -1, -1, -1, -1, -1, -1});
    m.region.push_back(region);
    m.layer.push_back(std::clamp(static_cast<int>(std::floor((0.5 - here.height / here.thickness) * o.layers)), 0, o.layers - 1));
    m.sheet_normal.push_back(here.normal);
    m.fibre.push_back(parallel_to_annulus(surface.axis, here.normal));
  }
  return m;
}

}  // namespace

LeafletMesh fill_leaflets(const MidSurface& surface, const SolidSurface& measured, const ThickOptions& o, ThickReport* report) {
  ThickReport local;
  ThickReport& r = report ? *report : local;
  const double thickest = surface.thickness.empty() ? o.thickness : *std::max_element(surface.thickness.begin(), surface.thickness.end());
  const int across = std::clamp(static_cast<int>(std::ceil(thickest / o.spacing)), o.layers, 16);  // triangles on the rims no longer than elsewhere
  LeafletBoundary boundary = boundary_of(thicken(surface, {o.thickness, across, 1}));
  r.fit = move_to_faces(boundary, measured, reach_share * thickest);
  const double volume = std::pow(o.spacing, 3) / (6 * std::sqrt(2.0));  // a regular tetrahedron's
  std::optional<TetFill> best;
  TetTrial best_trial;
  std::string failures;
  bool is_any_installed = false;
  for (const TetMesher mesher : o.meshers) {
    std::optional<TetTrial> own;  // the mesher's best
    for (const double share : volume_shares) {
      try {
        TetFill fill = fill_surface(mesher, boundary.points, boundary.triangles, share * volume, o.seconds, o.directory);
        split_long_steps(fill, boundary.points.size(), boundary.triangles, long_step * o.spacing);
        relocate_points(fill, boundary.on_annulus, o.dihedral_limit + angle_reserve);
        const TetTrial trial = judge(mesher, fill, o.dihedral_limit, long_step * o.spacing);
        is_any_installed = true;
        if (!own || !own->failure.empty() || is_better(trial, *own)) own = trial;
        if (!best || is_better(trial, best_trial)) {
          best = std::move(fill);
          best_trial = trial;
          r.kept = mesher;
        }
        if (trial.below_limit == 0 && static_cast<double>(trial.too_long) <= long_share * static_cast<double>(trial.tets)) break;
      } catch (const Error& e) {
        if (e.code() == ExitCode::interrupted) throw;
        is_any_installed = is_any_installed || e.code() != ExitCode::io;
        if (!own) own = TetTrial{mesher, 0, 0, 0, 0, 0, 0, e.what()};
        if (e.code() == ExitCode::io) break;
      }
    }
    r.trials.push_back(*own);
    if (!own->failure.empty()) failures += (failures.empty() ? "" : "; ") + own->failure;
  }
  if (!best) {
    const std::string text = "mesh.path = \"thick\": neither TetGen nor gmsh fills the leaflets: " + failures + "; mesh.path = \"mid\" needs neither";
    if (is_any_installed) throw InputError(text);
    throw IoError(text);
  }
  return mesh_of(surface, boundary, *best, o);
}

}  // namespace mv
