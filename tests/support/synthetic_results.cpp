// SPDX-License-Identifier: BSD-3-Clause
#include "support/synthetic_results.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <numbers>

#include "geometry/core/case_files.h"
#include "solver/output/frame_writer.h"
#include "solver/output/series.h"
#include "solver/output/summary.h"

namespace mv::test {

namespace fs = std::filesystem;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double semi_major = 19, semi_minor = 15, strip = 6, anterior_radius = 18, thickness = 1, slope = 0.35;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Ellipse by arc length, counter-clockwise from +z, parameterised so that [0, 2 anterior_radius] is centred on +y.
struct Ring {
  std::vector<Vec2> points;
  std::vector<double> length;
  double perimeter = 0;
  Ring() {
    constexpr int n = 4000;
    for (int i = 0; i <= n; ++i) {
      const double phi = pi / 2 + 2 * pi * i / n;
      points.emplace_back(semi_major * std::cos(phi), semi_minor * std::sin(phi));
      length.push_back(
          i == 0 ? 0 : length.back() + (points[static_cast<std::size_t>(i)] - points[static_cast<std::size_t>(i) - 1]).norm());
    }
    perimeter = length.back();
  }
  Vec2 at(double u) const {
    double s = std::fmod(u - anterior_radius, perimeter);
    if (s < 0) s += perimeter;
    const auto k = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(length.begin(), length.end(), s) - length.begin()), 1, points.size() - 1);
    const double w = (s - length[k - 1]) / (length[k] - length[k - 1]);
    return (1 - w) * points[k - 1] + w * points[k];
  }
};

double leaflet_height(double u, double perimeter) {
  const double scallop = (perimeter - 2 * anterior_radius) / 3;
  const bool is_anterior = u < 2 * anterior_radius;
  const double radius = is_anterior ? anterior_radius : scallop / 2;
  const double centre = is_anterior
                            ? anterior_radius
                            : 2 * anterior_radius + scallop * (std::floor((u - 2 * anterior_radius) / scallop - 1e-9) + 0.5);
  return strip + (is_anterior ? 0.9 : 0.75) * std::sqrt(std::max(0.0, radius * radius - (u - centre) * (u - centre)));
}

/// Where the column u meets the other leaflet: a smile-shaped line from commissure to commissure.
Vec3 coaptation_point(const Ring& ring, double u) {
  const Vec2 right = ring.at(0), left = ring.at(2 * anterior_radius);
  const double s =
      u < 2 * anterior_radius ? u / (2 * anterior_radius) : (ring.perimeter - u) / (ring.perimeter - 2 * anterior_radius);
  const Vec2 p = (1 - s) * right + s * left;
  return {p.x(), p.y() - 9.0 * std::sin(pi * s), -2.5 * std::sin(pi * s)};
}

Vec3 open_position(const Ring& ring, double u, double v) {
  const Vec2 p = ring.at(u);
  const double along = 1 / std::sqrt(1 + slope * slope);
  const Vec2 inward = -p.normalized();
  return {p.x() + slope * along * v * inward.x(), p.y() + slope * along * v * inward.y(), -along * v};
}

struct ClosedPoint {
  Vec3 position;
  double below = 0;  // mm below the line where the leaflets meet, negative above it
};

ClosedPoint closed_position(const Ring& ring, double u, double v) {
  const Vec2 p = ring.at(u);
  const bool is_anterior = u < 2 * anterior_radius;
  Vec3 target = coaptation_point(ring, u);
  target.y() += is_anterior ? 0.55 : -0.55;
  const Vec3 start(p.x(), p.y(), 0);
  const double distance = std::max(1.0, (target - start).norm());
  const double reach = std::min(1.0, v / distance);
  Vec3 x = start + reach * (target - start) + Vec3(0, 0, 0.16 * distance * std::sin(pi * reach));
  if (v > distance) x.z() -= v - distance;
  return {x, v - distance};
}

/// Point of the solid `w` mm along the surface normal, by differences of the mid-surface.
template <class Surface>
Vec3 offset(Surface&& surface, double u, double v, double w) {
  const double e = 0.2;
  const Vec3 du = surface(u + e, v) - surface(u - e, v), dv = surface(u, v + e) - surface(u, std::max(0.0, v - e));
  return surface(u, v) + w * dv.cross(du).stableNormalized();
}

void add_quadratic_nodes(SyntheticValve& valve) {
  constexpr int ends[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  LeafletMesh& m = valve.mesh;
  m.order = 2;
  std::map<std::pair<int, int>, int> middle;
  for (auto& tet : m.tets)
    for (std::size_t k = 0; k < 6; ++k) {
      const int a = tet[static_cast<std::size_t>(ends[k][0])], b = tet[static_cast<std::size_t>(ends[k][1])];
      const auto [at, is_new] = middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(m.points.size()));
      if (is_new) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        m.points.push_back((m.points[i] + m.points[j]) / 2);
        valve.closed.push_back((valve.closed[i] + valve.closed[j]) / 2);
        m.on_annulus.push_back(m.on_annulus[i] != 0 && m.on_annulus[j] != 0);
        m.on_free_edge.push_back(m.on_free_edge[i] != 0 && m.on_free_edge[j] != 0);
        m.side.push_back(m.side[i] == m.side[j] ? m.side[i] : 0);
        Vec2 ua = m.unfolded[i], ub = m.unfolded[j];
        if (std::abs(ua.x() - ub.x()) > valve.perimeter / 2) (ua.x() < ub.x() ? ua : ub).x() += valve.perimeter;
        m.unfolded.push_back((ua + ub) / 2);
        valve.contact_pressure.push_back((valve.contact_pressure[i] + valve.contact_pressure[j]) / 2);
        valve.gap.push_back((valve.gap[i] + valve.gap[j]) / 2);
      }
      tet[4 + k] = at->second;
    }
}

std::vector<double> flat(const std::vector<Vec3>& v, double scale) {
  std::vector<double> out;
  for (const Vec3& x : v)
    for (int c = 0; c < 3; ++c) out.push_back(scale * x[c]);
  return out;
}

double closure(double t) { return 1 / (1 + std::exp(-(t - 0.042) / 0.0035)); }
double pressure(double t) { return 120 * (t < 0.06 ? 0.5 - 0.5 * std::cos(pi * t / 0.06) : 1.0); }
double flow(double t, bool is_sealed) {
  const double swing = t > 0.048 ? 55 * std::exp(-(t - 0.048) / 0.02) * std::sin(2 * pi * (t - 0.048) / 0.018) : 0;
  return 40 * std::exp(-t / 0.008) - 520 * std::exp(-std::pow((t - 0.036) / 0.012, 2)) + swing -
         (is_sealed ? 0.2 : 24.0) * closure(t);
}

void write_frames(const fs::path& results, const SyntheticValve& valve, const SyntheticOptions& options) {
  const Eigen::Matrix3d tilt =
      Eigen::AngleAxisd(options.tilt_degrees * pi / 180, Vec3(1, 0.3, 0).normalized()).toRotationMatrix();
  SolverFrame frame;
  frame.origin = options.tilt_degrees != 0 ? Vec3(12, -30, 55) : Vec3::Zero();
  frame.axes = tilt.transpose();
  LeafletMesh mesh = valve.mesh;
  for (Vec3& x : mesh.points) x = frame.origin + tilt * x;
  Annulus annulus = valve.annulus;
  annulus.origin = frame.origin;
  annulus.normal = tilt * valve.annulus.normal;
  FrameWriter writer(results, mesh, valve.chordae, annulus, frame);
  const std::size_t np = valve.mesh.points.size();
  for (double t : {0.0, 0.02, 0.04, 0.05, 0.1, 0.25}) {
    const double c = t < 0.25 ? closure(t) - closure(0) : 1.0;
    std::vector<Vec3> x(np), force(np, Vec3::Zero());
    std::vector<double> p(np);
    for (std::size_t i = 0; i < np; ++i) {
      x[i] = (1 - c) * valve.mesh.points[i] + c * valve.closed[i];
      p[i] = c > 0.9 ? valve.contact_pressure[i] : 0;
      force[i] = Vec3(0, (valve.mesh.unfolded[i].x() < 36 ? 1 : -1) * p[i] * 0.4e-6, 0);
    }
    std::vector<double> stress, J;
    for (std::size_t e = 0; e < valve.mesh.tets.size(); ++e) {
      const double v = valve.mesh.unfolded[static_cast<std::size_t>(valve.mesh.tets[e][0])].y();
      stress.push_back(c * 3e5 * std::exp(-v / 8) + 2e3);
      J.push_back(1 + 0.01 * std::sin(static_cast<double>(e)));
    }
    const auto positions = flat(x, 1e-3), forces = flat(force, 1), velocities = std::vector<double>(3 * np, 0.01);
    writer.write_leaflets({t, positions, velocities, forces, p, stress, stress, J, J});
    if (options.has_chordae) {
      std::vector<Vec3> ends = valve.chordae.points;
      for (const Insertion& in : valve.chordae.insertions)
        ends[static_cast<std::size_t>(in.point)] = x[static_cast<std::size_t>(in.node)];
      const auto chorda_points = flat(ends, 1e-3);
      std::vector<double> tension;
      for (const ChordaSegment& s : valve.chordae.segments) tension.push_back(c * (s.kind == ChordaKind::primary ? 0.18 : 0.42));
      writer.write_chordae({t, chorda_points, tension});
    }
  }
  if (options.has_fluid) {
    FluidState fluid;
    fluid.time = 0.25;
    fluid.grid = {Vec3(-0.022, -0.018, -0.04), {22, 18, 30}, 0.002};
    fluid.velocity = [](int i, int j, int k) { return Vec3(0.01 * i, -0.02 * j, 0.3 * std::sin(0.2 * k)); };
    fluid.pressure = [](int, int, int k) { return k < 18 ? 16000.0 : 0.0; };
    fluid.is_blood = [](int i, int j, int) { return std::pow((i - 10.5) / 9.5, 2) + std::pow((j - 8.5) / 7.5, 2) < 1; };
    writer.write_fluid(fluid);
  }
}

void write_series(const fs::path& results, const SyntheticValve& valve, const SyntheticOptions& options) {
  SeriesWriter series(results);
  ChordaeSeriesWriter chordae(results, valve.chordae);
  double volume = 0;
  for (int i = 0; i <= 500; ++i) {
    const double t = 5e-4 * i, c = closure(t), p = pressure(t);
    SeriesRow row;
    row.time_s = t;
    row.dt_s = 2.5e-5 * (1 - 0.45 * c) * (1 + 0.05 * std::sin(900 * t));
    row.limiter = t < 0.02 ? "maximum step" : c < 0.5 ? "fibre stiffness" : i % 7 == 0 ? "contact" : "chordae";
    row.pressure_difference_mmHg = p;
    row.contact_force_N = c * p * 0.03;
    row.contact_penalty_N = 0.93 * row.contact_force_N;
    row.contact_film_N = 0.07 * row.contact_force_N;
    row.contact_area_mm2 = 290 * c;
    row.penetration_max_mm = 0.06 * c;
    if (options.has_chordae) {
      std::vector<double> tension;
      row.chordae_primary_N = row.chordae_secondary_N = row.papillary_force_0_N = row.papillary_force_1_N = 0;
      for (std::size_t s = 0; s < valve.chordae.segments.size(); ++s) {
        const ChordaSegment& segment = valve.chordae.segments[s];
        const bool is_primary = segment.kind == ChordaKind::primary;
        const double f = c * p / 120 * (is_primary ? 0.18 : 0.42) * (1 + 0.35 * std::sin(2.0 * static_cast<double>(s)));
        tension.push_back(f);
        (is_primary ? row.chordae_primary_N : row.chordae_secondary_N) += f;
        (segment.muscle == 0 ? row.papillary_force_0_N : row.papillary_force_1_N) += 0.95 * f;
      }
      chordae.append(t, tension);
    }
    if (options.has_fluid) {
      row.flow_ml_s = flow(t, options.is_sealed);
      volume += row.flow_ml_s * 5e-4;
      row.volume_ml = volume;
      row.leak_net_ml_s = -row.flow_ml_s;
      row.peak_velocity_m_s = 0.4 + 1.1 * std::exp(-std::pow((t - 0.036) / 0.012, 2));
      row.divergence_max = 3e-11;
      row.kinetic_J = 0.004 * std::exp(-std::pow((t - 0.036) / 0.014, 2)) + 2e-4;
      row.viscous_loss_J = 0.002 * c * (0.5 + t);
      row.advection_loss_J = 0.003 * c * (0.5 + t);
    }
    row.elastic_J = 0.012 * c * p / 120;
    row.chordae_elastic_J = 0.004 * c * p / 120;
    row.friction_loss_J = 4e-4 * c;
    row.damping_loss_J = 9e-4 * c;
    row.boundary_kinetic_J = 0;
    row.work_pressure_J = row.elastic_J + row.chordae_elastic_J + row.friction_loss_J + row.damping_loss_J +
                          (options.has_fluid ? row.kinetic_J + row.viscous_loss_J + row.advection_loss_J : 0) + 2e-4 * c;
    row.energy_residual_relative = 0.012 * c;
    row.J_min = 1 - 0.22 * c;
    row.J_max = 1 + 0.25 * c;
    row.distortion_controlled_fraction = 0.003 * c;
    row.solid_volume_drift = -0.0011 * c;
    series.append(row);
  }
}

void write_summary(const fs::path& results, const SyntheticValve& valve, const SyntheticOptions& options) {
  Summary s;
  s.set("run.end", "finished");
  s.set("run.steps", 14230);
  s.set("run.wall_s", 371.5);
  s.set("run.threads", 2);
  s.set("run.simulated_s", 0.25);
  s.set("run.dt_mean_s", 1.76e-5);
  s.set("run.share.fluid", 0.52);
  s.set("run.share.coupling", 0.24);
  s.set("run.share.solid", 0.16);
  s.set("run.share.contact", 0.08);
  if (options.has_fluid) {
    s.set("fluid.cells", 104880);
    s.set("fluid.spacing_mm", 1.0);
    s.set("flow.closing_volume_ml", 9.8);
    s.set("flow.closing_time_s", 0.05);
    s.set("flow.leak_volume_ml", options.is_sealed ? 0.04 : 4.9);
    s.set("flow.leak_rate_ml_s", options.is_sealed ? 0.2 : 24.1);
    s.set("flow.peak_velocity_m_s", 1.52);
  }
  s.set("solid.tets", valve.mesh.tets.size());
  s.set("solid.J_min", 0.78);
  s.set("solid.distortion_controlled_fraction", 0.003);
  s.set("seal.sealed", options.is_sealed);
  s.set("seal.threshold_mm", 0.6);
  s.set("seal.smallest_sealing_threshold_mm", options.is_sealed ? 0.24 : 2.9);
  s.set("seal.hole_area_mm2", options.is_sealed ? 0.0 : 11.6);
  Json holes = Json::array();
  if (!options.is_sealed) {
    holes.push_back({{"location", "between A2 and P2"}, {"area_mm2", 9.1}, {"width_mm", 2.9}, {"place_mm", {0.4, -8.8, -7.1}}});
    holes.push_back(
        {{"location", "posteromedial commissure"}, {"area_mm2", 2.5}, {"width_mm", 1.1}, {"place_mm", {-14.1, -1.0, -3.0}}});
  }
  s.set("seal.holes", holes);
  s.set("contact.belt_continuous", options.is_sealed);
  if (!options.is_sealed)
    s.set("contact.belt_interruptions",
          Json::array({{{"leaflet", "anterior"}, {"u_from_mm", 14.2}, {"u_to_mm", 21.6}, {"width_mm", 7.4}}}));
  s.set("contact.belt_width_mm_mean", 4.1);
  s.set("contact.area_mm2", 290.4);
  s.set("contact.force_N", 3.61);
  s.set("contact.penetration_max_mm", 0.06);
  s.set("contact.self_intersections", 0);
  s.set("bulging.volume_ml", 0.61);
  s.set("bulging.area_ratio", 0.22);
  s.set("orifice.area_cm2", options.is_sealed ? 0.0 : 0.12);
  if (options.has_chordae) {
    s.set("chordae.force_primary_N", 2.5);
    s.set("chordae.force_secondary_N", 3.4);
    s.set("papillary.force_N", Json{2.9, 2.8});
  }
  s.set("energy.residual_relative", 0.012);
  s.set("mass.solid_volume_drift", -0.0011);
  s.set("trust.passed", true);
  s.set("trust.failed", Json::array());
  s.write(results / "summary.json");

  Summary run;
  run.set("program", "mvsolve");
  run.set("versions.mvsolve", "0.1.0");
  run.set("versions.revision", "synthetic");
  run.set("versions.libraries", Json{"gcc 12.2.0", "Eigen 3.4.0", "VTK 9.1.0"});
  run.set("case.name", "synthetic <valve> & co");
  run.set("hashes.leaflets.vtu", std::string(64, 'a'));
  run.set("settings.threads", 2);
  run.set("settings.coupling.scheme", "interpolation");
  run.write(results / "run.json");
}

void write_case_copies(const fs::path& results) {
  fs::create_directories(results / "case");
  Json quality;
  quality["passed"] = true;
  const auto gate = [](const char* name, double value, const char* relation, double limit, const char* unit,
                       const char* message) {
    return Json{{"name", name},         {"verdict", "pass"}, {"value", value},      {"limit", limit},
                {"relation", relation}, {"unit", unit},      {"worst_element", -1}, {"message", message}};
  };
  quality["gates"] = Json::array({gate("leaflets.boundary_open_edges", 0, "==", 0, "edges", "closed and oriented boundary"),
                                  gate("leaflets.dihedral_min_deg", 21.7, ">=", 10, "deg", "smallest dihedral angle"),
                                  gate("leaflets.spacing_ratio", 0.48, "<=", 0.5, "1", "solid spacing over fluid spacing")});
  write_json(results / "case" / "quality.json", quality);
  write_text_atomically(results / "case" / "case.toml", "format_version = 1\n[mesh]\nspacing = \"0.5 mm\"  # <spacing>\n");
  Json manifest;
  manifest["program"] = "mvprep";
  manifest["version"] = "0.1.0";
  manifest["outputs"] = Json::object({{"leaflets.vtu", std::string(64, 'a')}, {"chordae.vtp", std::string(64, 'b')}});
  write_json(results / "case" / "manifest.json", manifest);
}

}  // namespace

SyntheticValve make_synthetic_valve(const SyntheticOptions& options) {
  const Ring ring;
  SyntheticValve valve;
  valve.perimeter = ring.perimeter;
  LeafletMesh& m = valve.mesh;
  const int nu = options.columns, nv = options.rows, nw = 2;
  const auto node = [&](int i, int j, int k) { return ((i % nu) * (nv + 1) + j) * (nw + 1) + k; };
  const auto open_mid = [&](double u, double v) { return open_position(ring, u, v); };
  const auto closed_mid = [&](double u, double v) {
    return closed_position(ring, u < 0 ? u + ring.perimeter : std::fmod(u, ring.perimeter), v).position;
  };
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j <= nv; ++j)
      for (int k = 0; k <= nw; ++k) {
        const double u = ring.perimeter * i / nu, height = leaflet_height(u, ring.perimeter), v = height * j / nv;
        const double w = thickness * (0.5 - static_cast<double>(k) / nw);
        m.points.push_back(offset(open_mid, u, v, w));
        valve.closed.push_back(j == 0 ? m.points.back() : offset(closed_mid, u, v, w));
        m.unfolded.emplace_back(u, v);
        m.on_annulus.push_back(j == 0);
        m.on_free_edge.push_back(j == nv);
        m.side.push_back(k == 0 ? atrial : k == nw ? ventricular : between);
        const double below = closed_position(ring, u, v).below;
        const bool is_gap = !options.is_sealed && (std::abs(u - 18) < 3.5 || std::abs(u - 72) < 3.5);
        const bool touches = k == 0 && below > 0 && !is_gap;
        valve.contact_pressure.push_back(touches ? 13000 * std::min(1.0, below / 1.5) * std::exp(-below / 12) : 0);
        valve.gap.push_back(k != 0 ? nan : touches ? 0.1e-3 : below > -6 ? 1e-3 * (is_gap ? 1.5 : -below) : nan);
      }
  constexpr int split[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};
  for (int i = 0; i < nu; ++i)
    for (int j = 0; j < nv; ++j)
      for (int k = 0; k < nw; ++k) {
        int corner[8];
        for (int c = 0; c < 8; ++c) corner[c] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
        for (const auto& s : split) {
          std::array<int, 10> tet;
          tet.fill(-1);
          for (std::size_t q = 0; q < 4; ++q) tet[q] = corner[s[q]];
          const auto x = [&](std::size_t q) -> const Vec3& { return m.points[static_cast<std::size_t>(tet[q])]; };
          if ((x(1) - x(0)).cross(x(2) - x(0)).dot(x(3) - x(0)) < 0) std::swap(tet[2], tet[3]);
          m.tets.push_back(tet);
          m.region.push_back(ring.perimeter * (i + 0.5) / nu < 2 * anterior_radius ? anterior : posterior);
          m.layer.push_back(k);
        }
      }

  valve.annulus.normal = -Vec3::UnitZ();
  for (int i = 0; i < nu; ++i) {
    const Vec2 p = ring.at(ring.perimeter * i / nu);
    valve.annulus.points.emplace_back(p.x(), p.y(), 0);
  }
  if (options.has_chordae) {
    Chordae& c = valve.chordae;
    c.points = {Vec3(10, -2, -32), Vec3(-10, -2, -32)};
    c.muscle_of_point = {0, 1};
    const auto add = [&](double u, int row, ChordaKind kind) {
      const int column = static_cast<int>(std::lround(u / ring.perimeter * nu)) % nu, n = node(column, row, nw);
      const int end = static_cast<int>(c.points.size()), muscle = m.points[static_cast<std::size_t>(n)].x() > 0 ? 0 : 1;
      c.points.push_back(m.points[static_cast<std::size_t>(n)]);
      c.muscle_of_point.push_back(-1);
      const double length = (c.points[static_cast<std::size_t>(muscle)] - c.points.back()).norm();
      c.segments.push_back({muscle, end, kind, muscle, u < 2 * anterior_radius ? anterior : posterior, length,
                            kind == ChordaKind::primary ? 0.4 : 0.8});
      c.insertions.push_back({end, n, 1.0});
    };
    for (int i = 0; i < 14; ++i) add(ring.perimeter * (i + 0.5) / 14, nv, ChordaKind::primary);
    for (int i = 0; i < 8; ++i) add(ring.perimeter * (i + 0.25) / 8, nv / 2, ChordaKind::secondary);
  }
  if (options.order == 2) add_quadratic_nodes(valve);
  return valve;
}

void write_synthetic_results(const fs::path& results, const SyntheticOptions& options) {
  const SyntheticValve valve = make_synthetic_valve(options);
  fs::create_directories(results);
  write_frames(results, valve, options);
  write_series(results, valve, options);
  std::vector<double> force(3 * valve.mesh.points.size(), 0.0);
  for (std::size_t i = 0; i < valve.mesh.points.size(); ++i) force[3 * i + 1] = valve.contact_pressure[i] * 0.4e-6;
  write_contact_map(results / "contact_map.vtp", make_contact_map(valve.mesh, valve.contact_pressure, force, valve.gap));
  write_summary(results, valve, options);
  write_case_copies(results);
}

}  // namespace mv::test
