// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/preflight.h"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/log.h"
#include "geometry/core/tube_ends.h"
#include "solver/contact/intersection.h"
#include "solver/output/contact_map.h"
#include "solver/time/structure.h"

namespace mv {
namespace {

constexpr double degrees = 180.0 / M_PI;
constexpr double pascal_per_mmHg = 133.322387415;
// Immersed leaflets move with the blood's density; beyond this ratio the difference would show.
constexpr double density_ratio_allowed = 1.25;
constexpr double pressure_allowed = 500 * pascal_per_mmHg;   // as pressure.peak; more is a wrong unit
constexpr double steps_allowed = 5e7;                        // some days of the coarsest valve
// Bytes a run holds: what the arrays add up to roughly, on the low side (not measured), since refusing must be certain.
constexpr double bytes_per_cell = 400, bytes_per_tet = 400;
// Without chordae leaflets turn inside out and stretch towards the atrium; held ones bulge, and what lies off the nearest chorda flails.
constexpr double reach_without_chordae = 1.1, reach_with_chordae = 0.25;
// Tissue in blood keeps its volume as far as its volumetric stiffness exceeds the pressure: on a grid of 3 mm 2 MPa at 16 kPa drifts by about 1 %, 75 kPa by 23 %.
constexpr double bulk_over_pressure = 10;
constexpr double chorda_stress_allowed = 100e6;   // Pa, no tissue bears it; the order of magnitude is meant
constexpr double sudden = 5e-3;                   // s, leaflets do not follow tips that move faster

double poisson_ratio(double bulk, double shear) { return (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear); }

void check_tissue(const Scene& scene, double largest_pressure) {
  const Config& config = scene.config;
  for (const auto& [region, leaflet] : leaflet_names) {
    if (region == septal && !has_other_leaflets(scene.mesh)) continue;
    const Material material = material_of(config, leaflet);
    const double shear = ground_shear_modulus(material);
    const double nu = poisson_ratio(material.bulk, shear);
    if (!(nu >= -1e-9))
      throw ConfigError(fmt::format("leaflet.bulk: {:.4g} Pa with the {} leaflet's shear modulus of {:.4g} Pa is a Poisson's ratio of {:.2f}; at least {:.4g} Pa (ratio 0) "
                                    "is needed, or set leaflet.poisson_ratio",
                                    material.bulk, leaflet, shear, nu, 2 * shear / 3));
    if (scene.has_fluid() && material.bulk < bulk_over_pressure * largest_pressure)
      throw ConfigError(fmt::format("leaflet.bulk: {:.4g} Pa (Poisson's ratio {:.3f}) under {:.4g} Pa: tissue in blood keeps its volume only when its volumetric stiffness is {:.0f} times the "
                                    "pressure or more; raise leaflet.bulk or leaflet.poisson_ratio, or leave the blood out (fluid.enabled = false)",
                                    material.bulk, nu, largest_pressure, bulk_over_pressure));
  }
  if (!scene.has_fluid()) return;
  const double tissue = config.number("leaflet.density"), blood = config.number("fluid.density");
  if (std::max(tissue / blood, blood / tissue) > density_ratio_allowed)
    throw ConfigError(fmt::format("leaflet.density: {:.4g} kg/m3 in blood of {:.4g} kg/m3: immersed leaflets move with the blood's density, so their own must be within "
                                  "{:.0f} % of it; set it nearer, or leave the blood out (fluid.enabled = false)",
                                  tissue, blood, 100 * (density_ratio_allowed - 1)));
}

void check_length(const Scene& scene, const Waveform& waveform) {
  const Config& config = scene.config;
  if (!(waveform.largest() <= pressure_allowed))
    throw ConfigError(fmt::format("pressure: the largest difference is {:.4g} mmHg, at most {:.0f} mmHg is allowed; check pressure.csv_pressure_unit",
                                  waveform.largest() / pascal_per_mmHg, pressure_allowed / pascal_per_mmHg));
  double step = config.number("time.step_max");
  const char* key = "time.step_max";
  if (!config.is_auto("time.step_fixed")) {
    step = config.number("time.step_fixed");
    key = "time.step_fixed";
  }
  if (config.number("time.end") / step > steps_allowed)
    throw ConfigError(fmt::format("{}: {:.3g} us would need {:.2g} steps to time.end = {:.4g} s, more than {:.0g} are refused; the adaptive step is some 10 to 50 us", key,
                                  1e6 * step, config.number("time.end") / step, config.number("time.end"), steps_allowed));
}

void check_memory(const Scene& scene) {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGE_SIZE);
  if (pages <= 0 || page <= 0) return;
  double cells = 0;
  if (scene.has_fluid()) {
    cells = 1;
    for (int n : scene.tube.grid_cells) cells *= n;
  }
  const double need = bytes_per_cell * cells + bytes_per_tet * static_cast<double>(scene.mesh.tets.size());
  const double have = static_cast<double>(pages) * static_cast<double>(page);
  if (need > have)
    throw ConfigError(fmt::format("tube.spacing: {:.3g} fluid cells and {} tetrahedra need {:.0f} GB of memory or more, this machine has {:.0f} GB; raise tube.spacing "
                                  "(and mesh.spacing), or shorten the tube",
                                  cells, scene.mesh.tets.size(), need / 1e9, have / 1e9));
}

void check_elements(const Scene& scene) {
  const LeafletMesh& mesh = scene.mesh;
  const double bound = scene.config.number_in("gates.min_dihedral", "deg");
  double worst = 180;
  std::size_t worst_element = 0;
  long below = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    auto corner = [&](std::size_t c) -> const Vec3& { return mesh.points[static_cast<std::size_t>(mesh.tets[e][c])]; };
    const double angle = smallest_dihedral(corner(0), corner(1), corner(2), corner(3));
    below += !(angle >= bound);
    if (!(angle >= worst)) {
      worst = angle;
      worst_element = e;
    }
  }
  // What mvprep's gate let pass at its limit may be a rounding below it here.
  constexpr double rounding = 1e-6;
  if (worst > 0 && worst >= bound - rounding) return;
  const Vec2 uv = mesh.unfolded[static_cast<std::size_t>(mesh.tets[worst_element][0])];
  throw GateError(fmt::format("leaflets: {} elements have a dihedral angle below gates.min_dihedral = {:.3g} deg, the worst is element {} with {:.3g} deg{} (at u {:.1f} mm, "
                              "v {:.1f} mm of the flat pattern); mend the mesh, or lower gates.min_dihedral",
                              below, bound, worst_element, worst, worst > 0 ? "" : ", flat or inverted", uv.x(), uv.y()));
}

void check_crossings(const Scene& scene) {
  const auto boundary = boundary_faces(scene.mesh).triangles;
  const auto crossings = self_intersections(scene.mesh.points, boundary);
  if (crossings.empty()) return;
  const auto& triangle = boundary[static_cast<std::size_t>(crossings.front().first)];
  const Vec3 place = scene.mesh.points[static_cast<std::size_t>(triangle[0])];
  throw GateError(fmt::format("leaflets: {} pairs of surface triangles cross at the start, the first at ({:.1f}, {:.1f}, {:.1f}) mm; contact cannot part what has crossed: "
                              "open the leaflets (generic.inward_slope, mesh.thickness) or mend the surface",
                              crossings.size(), place.x(), place.y(), place.z()));
}

bool is_inside(const std::vector<Vec2>& outline, const Vec2& p) {
  bool inside = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const Vec2 &a = outline[i], &b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) inside = !inside;
  }
  return inside;
}

/// Largest distance (mm) of a point of the free border from the nearest chorda's end; 1e300 without chordae. Those that will be cut do not hold.
double longest_flail(const Scene& scene) {
  std::vector<char> holds(scene.chordae.points.size(), 0);
  for (std::size_t s = 0; s < scene.chordae.segments.size(); ++s) {
    const auto& cut = scene.config.numbers("chordae.cut");
    if (std::find(cut.begin(), cut.end(), static_cast<double>(s)) == cut.end()) holds[static_cast<std::size_t>(scene.chordae.segments[s].b)] = 1;
  }
  std::vector<Vec3> ends;
  for (const Insertion& i : scene.chordae.insertions)
    if (holds[static_cast<std::size_t>(i.point)]) ends.push_back(scene.mesh.points[static_cast<std::size_t>(i.node)]);
  double longest = 0;
  for (std::size_t i = 0; i < scene.mesh.points.size(); ++i) {
    if (!scene.mesh.on_free_edge[i]) continue;
    double nearest = 1e300;
    for (const Vec3& end : ends) nearest = std::min(nearest, (end - scene.mesh.points[i]).squaredNorm());
    longest = std::max(longest, std::sqrt(nearest));
  }
  return longest;
}

void check_room(const Scene& scene) {
  if (!scene.has_fluid()) return;
  const Tube& tube = scene.tube;
  const double margin = tube_end_cells_needed * tube.grid_spacing;
  long outside = 0;
  std::size_t first = 0;
  double annulus_top = -1e300, length = 0;
  for (std::size_t i = 0; i < scene.mesh.points.size(); ++i) {
    const Vec3 x = tube.axes * (scene.mesh.points[i] - tube.origin);
    const bool is_in = is_inside(tube.cross_section, x.head<2>()) && x.z() > tube.z_ventricle + margin && x.z() < tube.z_atrium - margin;
    if (!is_in && outside++ == 0) first = i;
    if (scene.mesh.on_annulus[i]) annulus_top = std::max(annulus_top, x.z());
    length = std::max(length, scene.mesh.unfolded[i].y());
  }
  if (outside > 0) {
    const Vec3& p = scene.mesh.points[first];
    throw GateError(fmt::format("tube: {} leaflet points lie outside the blood tube or within {:.2f} mm of its ends, the first is point {} at ({:.1f}, {:.1f}, {:.1f}) mm; raise "
                                "tube.clearance, tube.length_ventricle or tube.length_atrium",
                                outside, margin, first, p.x(), p.y(), p.z()));
  }
  const double room = tube.z_atrium - margin - annulus_top, need = std::min(reach_without_chordae * length, reach_with_chordae * length + longest_flail(scene));
  if (room < need)
    throw GateError(fmt::format("tube.length_atrium: the leaflets are {:.1f} mm long and may reach {:.1f} mm into the atrium{}, the tube leaves {:.1f} mm there; lengthen it by "
                                "{:.0f} mm",
                                length, need, scene.has_chordae() ? " where no chorda is near" : " without chordae", room, std::ceil(need - room)));
}

/// A sudden movement of the tips is taken up by the chordae alone.
void check_jerk(const Scene& scene) {
  const Vec3 moved = 1e3 * Vec3::Map(scene.config.numbers("papillary.displacement").data());
  if (moved.isZero() || scene.config.number("papillary.move_time") > sudden) return;
  const Chordae& chordae = scene.chordae;
  for (std::size_t s = 0; s < chordae.segments.size(); ++s) {
    const ChordaSegment& segment = chordae.segments[s];
    if (chordae.muscle_of_point[static_cast<std::size_t>(segment.a)] < 0) continue;
    const double length = (chordae.points[static_cast<std::size_t>(segment.b)] - chordae.points[static_cast<std::size_t>(segment.a)] - moved).norm();
    const double stress = scene.config.number("chordae.stiffness") * (length / segment.rest_length - 1);
    if (stress > chorda_stress_allowed)
      throw ConfigError(fmt::format("papillary.displacement: the tips' movement within {:.2g} ms pulls chorda {} to {:.0f} MPa, at most {:.0f} MPa is allowed, which no chorda bears; "
                                    "raise papillary.move_time, or lower the displacement or chordae.stiffness",
                                    1e3 * scene.config.number("papillary.move_time"), s, 1e-6 * stress, 1e-6 * chorda_stress_allowed));
  }
}

void warn_of_leaks(const Scene& scene) {
  if (!scene.has_fluid()) return;
  // Half the fluid spacing is what keeps blood from slipping between solid points; diagonals through the thickness do not count (mvprep's gate).
  std::vector<double> lengths;
  const auto faces = boundary_faces(scene.mesh).triangles;
  for (const auto& t : faces)
    for (std::size_t c = 0; c < 3; ++c)
      lengths.push_back((scene.mesh.points[static_cast<std::size_t>(t[c])] - scene.mesh.points[static_cast<std::size_t>(t[(c + 1) % 3])]).norm());
  if (lengths.empty()) return;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  const double apart = (scene.mesh.order == 2 ? 0.5 : 1.0) * *middle;
  if (apart > 0.5 * scene.tube.grid_spacing * 1.05)
    spdlog::warn("solid points lie {:.2f} mm apart, more than half the fluid spacing of {:.2f} mm: blood leaks between them; lower mesh.spacing or raise tube.spacing", apart,
                 scene.tube.grid_spacing);
}

}  // namespace

double smallest_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<Vec3, 4> p{a, b, c, d};
  const double volume = (b - a).cross(c - a).dot(d - a);
  double smallest = 180;
  constexpr int edges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};
  for (const auto& e : edges) {
    const Vec3 along = (p[static_cast<std::size_t>(e[1])] - p[static_cast<std::size_t>(e[0])]).normalized();
    auto across = [&](int k) {
      const Vec3 r = p[static_cast<std::size_t>(e[k])] - p[static_cast<std::size_t>(e[0])];
      return Vec3(r - r.dot(along) * along);
    };
    const Vec3 u = across(2), v = across(3);
    const double angle = degrees * std::atan2(u.cross(v).norm(), u.dot(v));
    smallest = std::isfinite(angle) ? std::min(smallest, angle) : 0.0;
  }
  return volume > 0 ? smallest : volume < 0 ? -smallest : 0.0;
}

void preflight(const Scene& scene, const Waveform& waveform) {
  check_tissue(scene, waveform.largest());
  check_length(scene, waveform);
  check_memory(scene);
  check_elements(scene);
  check_crossings(scene);
  check_room(scene);
  check_jerk(scene);
  warn_of_leaks(scene);
}

}  // namespace mv
