// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/scene_alteration.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/core/case_files.h"
#include "solver/contact/intersection.h"
#include "solver/output/contact_map.h"
#include "solver/time/preflight.h"

namespace mv {
namespace {

constexpr std::size_t squashed_nodes = 12;
constexpr double bump_width_mm = 7;     // along the commissures
constexpr double touching_slack_mm = 0.05;

double angle_around(const LeafletMesh& mesh, const std::vector<std::size_t>& elements) {
  double smallest = 180;
  for (std::size_t e : elements) {
    auto corner = [&](std::size_t c) -> const Vec3& { return mesh.points[static_cast<std::size_t>(mesh.tets[e][c])]; };
    smallest = std::min(smallest, smallest_dihedral(corner(0), corner(1), corner(2), corner(3)));
  }
  return smallest;
}

bool has_crossings(const LeafletMesh& mesh) { return !self_intersections(mesh.points, boundary_faces(mesh).triangles).empty(); }

}  // namespace

void squash_elements(Scene& scene, double degrees) {
  LeafletMesh& mesh = scene.mesh;
  std::vector<std::vector<std::size_t>> around(mesh.points.size());
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (std::size_t c = 0; c < 4; ++c) around[static_cast<std::size_t>(mesh.tets[e][c])].push_back(e);
  std::vector<std::size_t> inner;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!mesh.on_annulus[i] && !mesh.on_free_edge[i] && !around[i].empty()) inner.push_back(i);
  for (std::size_t k = 0; k < squashed_nodes && !inner.empty(); ++k) {
    const std::size_t node = inner[k * inner.size() / squashed_nodes];
    // Towards the middle of the face opposite to it in its first element, and beyond.
    const auto& tet = mesh.tets[around[node].front()];
    Vec3 target = Vec3::Zero();
    for (std::size_t c = 0; c < 4; ++c)
      if (static_cast<std::size_t>(tet[c]) != node) target += mesh.points[static_cast<std::size_t>(tet[c])] / 3.0;
    const Vec3 from = mesh.points[node];
    double low = 0, high = degrees > 0 ? 1.0 : degrees < 0 ? 1.5 : 1.0;
    for (int i = 0; degrees > 0 && i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      mesh.points[node] = from + middle * (target - from);
      (angle_around(mesh, around[node]) > degrees ? low : high) = middle;
    }
    mesh.points[node] = from + (degrees > 0 ? low : high) * (target - from);
  }
}

void bring_together(Scene& scene, double distance) {
  LeafletMesh& mesh = scene.mesh;
  const Vec3 e3 = -scene.annulus.normal, e1 = scene.annulus.axis_major;
  Vec3 e2 = e3.cross(e1).normalized();
  double length = 0, side = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    if (mesh.region[e] == anterior) side += e2.dot(mesh.points[static_cast<std::size_t>(mesh.tets[e][0])] - scene.annulus.origin);
  if (side < 0) e2 = -e2;
  for (const Vec2& uv : mesh.unfolded) length = std::max(length, uv.y());
  std::vector<char> moves(mesh.points.size(), 0);
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (int c = 0; c < mesh.nodes_per_tet(); ++c)
      if (mesh.region[e] == anterior) moves[static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(c)])] = 1;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!moves[i]) continue;
    const double along = e1.dot(mesh.points[i] - scene.annulus.origin) / bump_width_mm, drop = mesh.unfolded[i].y() / length;
    mesh.points[i] -= distance * drop * drop * std::exp(-along * along) * e2;
  }
}

void bring_to_touch(Scene& scene) {
  const LeafletMesh open = scene.mesh;
  double low = 0, high = 40;
  while (high - low > 0.01) {
    scene.mesh = open;
    const double middle = 0.5 * (low + high);
    bring_together(scene, middle);
    (has_crossings(scene.mesh) ? high : low) = middle;
  }
  scene.mesh = open;
  bring_together(scene, std::max(0.0, low - touching_slack_mm));
}

void keep_one_chorda(Scene& scene) {
  Chordae& chordae = scene.chordae;
  const ChordaSegment* kept = nullptr;
  double nearest = 1e300;
  std::set<int> starts;
  for (const ChordaSegment& s : chordae.segments) starts.insert(s.a);
  for (const ChordaSegment& s : chordae.segments) {
    const double off = std::abs(scene.annulus.axis_major.dot(chordae.points[static_cast<std::size_t>(s.b)] - scene.annulus.origin));
    if (s.kind != ChordaKind::primary || s.leaflet != anterior || starts.count(s.b) || off >= nearest) continue;
    nearest = off;
    kept = &s;
  }
  if (!kept) return;
  std::vector<ChordaSegment> path{*kept};
  // Back to the muscle, where the chorda branches.
  for (int at = kept->a; chordae.muscle_of_point[static_cast<std::size_t>(at)] < 0;) {
    const auto before = std::find_if(chordae.segments.begin(), chordae.segments.end(), [&](const ChordaSegment& s) { return s.b == at; });
    if (before == chordae.segments.end()) break;
    path.insert(path.begin(), *before);
    at = before->a;
  }
  chordae.segments = std::move(path);
}

void set_beats(Scene& scene, int count, double length, double peak_mmHg) {
  // Shares of a beat and mmHg.
  const double beat[][2] = {{0, -5}, {0.05, -5}, {0.3, peak_mmHg}, {0.6, peak_mmHg}, {0.75, -5}};
  std::string csv = "time_s,pressure_mmHg\n";
  for (int b = 0; b < count; ++b)
    for (const auto& [share, pressure] : beat) csv += fmt::format("{:.6f},{}\n", (b + share) * length, pressure);
  csv += fmt::format("{:.6f},-5\n", count * length);
  write_text_atomically(scene.directory / "pressure.csv", csv);
  for (const char* setting : {"pressure.waveform=csv", "pressure.csv=pressure.csv", "pressure.csv_pressure_unit=mmHg", "pressure.csv_time_unit=s"}) scene.config.set(setting);
}

}  // namespace mv
