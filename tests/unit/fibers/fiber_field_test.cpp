// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/fiber_field.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "geometry/core/errors.h"
#include "support/grid_leaflet.h"

namespace {

using namespace mv;
constexpr double degree = std::numbers::pi / 180;

const LeafletMesh& valve() {
  static const LeafletMesh mesh = test::ring_valve();
  return mesh;
}

double between_directions(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))); }

Vec3 centroid(const LeafletMesh& m, std::size_t e) {
  Vec3 x = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    x += 0.25 * m.points[static_cast<std::size_t>(m.tets[e][i])];
  return x;
}

// Mean (u, v) of an element; the fixture's seam lies at the commissure u = 0.
Vec2 pattern_place(const LeafletMesh& m, std::size_t e) {
  Vec2 p = Vec2::Zero();
  const double first = m.unfolded[static_cast<std::size_t>(m.tets[e][0])].x();
  for (std::size_t i = 0; i < 4; ++i) {
    Vec2 q = m.unfolded[static_cast<std::size_t>(m.tets[e][i])];
    q.x() -= 107.2 * std::round((q.x() - first) / 107.2);
    p += 0.25 * q;
  }
  return p;
}

// Angle of the fibre to the annulus direction, positive when it leads away from the annulus as u grows; (-90, 90] degrees.
double fibre_angle(const LeafletMesh& m, const Vec3& f, std::size_t e) {
  const Vec3 x = centroid(m, e), along = Vec3(-x.y(), x.x(), 0).normalized();
  const Vec3 away = m.sheet_normal[e].cross(along).dot(-Vec3::UnitZ()) > 0 ? Vec3(m.sheet_normal[e].cross(along))
                                                                           : Vec3(-m.sheet_normal[e].cross(along));
  double angle = std::atan2(f.dot(away), f.dot(along)) / degree;
  while (angle <= -90)
    angle += 180;
  while (angle > 90)
    angle -= 180;
  return angle;
}

TEST(ParallelFibers, lie_in_the_annulus_plane_and_on_the_leaflet) {
  LeafletMesh mesh = valve();
  assign_fibers(mesh, test::ring_annulus(), {FiberModel::parallel});
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    EXPECT_NEAR(mesh.fibre[e].z(), 0, 1e-12);
    EXPECT_LT(std::abs(fibre_angle(mesh, mesh.fibre[e], e)), 2);
  }
  const FiberReport report = check_fibers(mesh, FiberModel::parallel);
  EXPECT_TRUE(report.passed) << report.message;
  EXPECT_LT(report.unit_error_max, 1e-12);
  EXPECT_LT(report.tangent_error_max, 1e-12);
}

TEST(ParallelFibers, sign_of_the_annulus_normal_does_not_matter) {
  const auto a = parallel_fibers(valve(), Vec3::UnitZ()), b = parallel_fibers(valve(), Vec3(0, 0, -3));
  for (std::size_t e = 0; e < a.size(); ++e)
    EXPECT_EQ(a[e], -b[e]);
}

TEST(ParallelFibers, where_the_leaflet_is_flat_the_neighbours_decide) {
  // A wall that bends over into the annulus plane: u along x, first 6 mm upright, then flat.
  test::GridSpec g;
  g.columns = 20;
  g.rows = 24;
  const double bend = 4, upright = 6;
  g.pattern = [](int i, int j) { return Vec2(i * 0.5, j * 0.75); };
  const auto angle = [=](Vec2 p) { return std::clamp((p.y() - upright) / bend, 0.0, std::numbers::pi / 2); };
  g.normal = [=](Vec2 p) { return Vec3(0, std::cos(angle(p)), -std::sin(angle(p))); };
  g.place = [=](Vec2 p, double w) {
    const double a = angle(p), flat = std::max(p.y() - upright - bend * std::numbers::pi / 2, 0.0);
    const Vec3 mid(p.x(), bend * (1 - std::cos(a)) + flat, std::min(p.y(), upright) + bend * std::sin(a));
    return Vec3(mid + w * Vec3(0, std::cos(a), -std::sin(a)));
  };
  const LeafletMesh mesh = test::grid_leaflet(g);
  for (const Vec3& f : parallel_fibers(mesh, Vec3::UnitZ()))
    EXPECT_LT(between_directions(f, Vec3::UnitX()), 1e-6);
  EXPECT_THROW(parallel_fibers(test::flat_patch(5, 5, 1), Vec3::UnitZ()), InputError);
}

TEST(ArcFibers, are_unit_finite_and_tangent_on_both_leaflets) {
  LeafletMesh mesh = valve();
  assign_fibers(mesh, test::ring_annulus(), {});
  const FiberReport report = check_fibers(mesh, FiberModel::arc);
  EXPECT_TRUE(report.passed) << report.message;
  EXPECT_LT(report.unit_error_max, 1e-12);
  EXPECT_LT(report.tangent_error_max, 1e-12);
  EXPECT_EQ(report.elements, static_cast<int>(mesh.tets.size()));
}

TEST(ArcFibers, run_along_the_annulus_and_the_middle_and_down_to_the_border_on_the_flanks) {
  const auto fibres = arc_fibers(valve(), {});
  for (std::size_t e = 0; e < fibres.size(); ++e) {
    const Vec2 p = pattern_place(valve(), e);
    const double angle = fibre_angle(valve(), fibres[e], e);
    if (p.y() < 0.8) {
      EXPECT_LT(std::abs(angle), 12) << p.transpose();
    }
    if (std::abs(p.x() - 18) < 0.4) {
      EXPECT_LT(std::abs(angle), 6) << p.transpose();
    }
    // Arcs open towards the border: with growing u they climb to the annulus on the left flank and leave it on the right one.
    const double t = (p.x() - 18) / 18, height = test::ring_height({}, p.x());
    if (std::abs(t) > 0.5 && std::abs(t) < 0.75 && p.y() > 0.7 * height && p.x() < 36) {
      EXPECT_GT(t * angle, 0) << p.transpose();
      EXPECT_GT(std::abs(angle), 20) << p.transpose();
    }
  }
}

TEST(ArcFibers, follow_the_slope_of_the_guide) {
  const auto fibres = arc_fibers(valve(), {});
  const double end = 0.7, h_end = test::ring_height({}, 18 + 18 * end), apex = 0.45 * 22.2;
  const double shrink =
      1 - 12.0 * 0.35 / std::hypot(1.0, 0.35) / (107.2 / (2 * std::numbers::pi));  // of lengths along u on the cone, half way
  int checked = 0;
  for (std::size_t e = 0; e < fibres.size(); ++e) {
    const Vec2 p = pattern_place(valve(), e);
    const double t = (p.x() - 18) / 18;
    if (p.x() > 36 || std::abs(t) > 0.65) continue;
    const double guide = apex + (h_end - apex) * std::pow(t / end, 2);
    if (std::abs(p.y() - guide) > 0.2) continue;
    const double slope = 2 * (h_end - apex) * t / (end * end * 18);
    EXPECT_NEAR(fibre_angle(valve(), fibres[e], e), std::atan(slope / shrink) / degree, 5) << p.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 50);
}

TEST(ArcFibers, meet_the_border_at_right_angles_near_the_commissures) {
  const auto fibres = arc_fibers(valve(), {});
  int checked = 0;
  for (std::size_t e = 0; e < fibres.size(); ++e) {
    const Vec2 p = pattern_place(valve(), e);
    const double t = (p.x() - 18) / 18, height = test::ring_height({}, p.x());
    if (p.x() > 36 || std::abs(t) < 0.72 || std::abs(t) > 0.88 || p.y() < 0.95 * height) continue;
    const double slope = (test::ring_height({}, p.x() + 0.1) - test::ring_height({}, p.x() - 0.1)) / 0.2;
    const double shrink = 1 - p.y() * 0.35 / std::hypot(1.0, 0.35) / (107.2 / (2 * std::numbers::pi));
    const double border = std::atan(slope / shrink) / degree, angle = fibre_angle(valve(), fibres[e], e);
    EXPECT_NEAR(std::abs(std::remainder(border - angle, 180)), 90, 20) << p.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST(ArcFibers, place_of_the_seam_and_sign_of_the_sheet_normal_do_not_matter) {
  const auto reference = arc_fibers(valve(), {});
  LeafletMesh shifted = valve();
  for (Vec2& p : shifted.unfolded)
    p.x() = std::fmod(p.x() + 90, 107.2);
  const auto moved = arc_fibers(shifted, {});
  LeafletMesh turned = valve();
  for (Vec3& n : turned.sheet_normal)
    n = -n;
  const auto opposite = arc_fibers(turned, {});
  for (std::size_t e = 0; e < reference.size(); ++e) {
    EXPECT_LT(between_directions(reference[e], moved[e]), 0.2 * degree);
    EXPECT_LT(between_directions(reference[e], opposite[e]), 1e-6);
  }
}

TEST(ArcFibers, each_leaflet_is_independent_of_the_other) {
  FiberOptions changed;
  changed.posterior = {0.6, 0.2, 2};
  const auto a = arc_fibers(valve(), {}), b = arc_fibers(valve(), changed);
  int different = 0;
  for (std::size_t e = 0; e < a.size(); ++e) {
    if (valve().region[e] == anterior) {
      EXPECT_EQ(a[e], b[e]);
    }
    different += valve().region[e] == posterior && a[e] != b[e];
  }
  EXPECT_GT(different, 1000);
}

TEST(ArcFibers, converge_when_the_mesh_is_refined) {
  // Mean angle over fixed windows of the anterior leaflet away from the guide and the border.
  const auto window_angle = [](int columns, int rows, double u, double v) {
    test::RingSpec spec;
    spec.columns = columns;
    spec.rows = rows;
    const LeafletMesh mesh = test::ring_valve(spec);
    const auto fibres = arc_fibers(mesh, {});
    double sum = 0;
    int count = 0;
    for (std::size_t e = 0; e < fibres.size(); ++e)
      if ((pattern_place(mesh, e) - Vec2(u, v)).norm() < 1) {
        sum += fibre_angle(mesh, fibres[e], e);
        ++count;
      }
    return sum / count;
  };
  for (const Vec2& place : {Vec2(26, 4), Vec2(30, 6), Vec2(22, 16), Vec2(8, 7)}) {
    const double coarse = window_angle(108, 7, place.x(), place.y()), medium = window_angle(216, 14, place.x(), place.y()),
                 fine = window_angle(432, 28, place.x(), place.y());
    EXPECT_LT(std::abs(fine - medium), 2.0) << place.transpose();
    EXPECT_LT(std::abs(fine - medium), 0.9 * std::abs(medium - coarse) + 0.3) << place.transpose();
  }
}

TEST(ArcFibers, shapes_out_of_range_and_missing_arrays_are_refused) {
  FiberOptions o;
  o.anterior.end = 1.2;
  EXPECT_THROW(arc_fibers(valve(), o), ConfigError);
  o = {};
  o.posterior.apex = 0;
  EXPECT_THROW(arc_fibers(valve(), o), ConfigError);
  LeafletMesh mesh = valve();
  mesh.unfolded.clear();
  EXPECT_THROW(arc_fibers(mesh, {}), InputError);
  mesh = valve();
  mesh.sheet_normal.clear();
  EXPECT_THROW(arc_fibers(mesh, {}), InputError);
  EXPECT_THROW(arc_fibers(LeafletMesh{}, {}), InputError);
  EXPECT_THROW(fiber_model_from_name("arcs"), ConfigError);
  EXPECT_EQ(fiber_model_from_name("arc"), FiberModel::arc);
}

TEST(CheckFibers, names_the_first_bad_element_and_why) {
  LeafletMesh mesh = valve();
  assign_fibers(mesh, test::ring_annulus(), {FiberModel::parallel});
  const LeafletMesh good = mesh;
  mesh.fibre[17] *= 1.001;
  FiberReport r = check_fibers(mesh, FiberModel::parallel);
  EXPECT_FALSE(r.passed);
  EXPECT_EQ(r.first_bad_element, 17);
  mesh = good;
  mesh.fibre[23] = (mesh.fibre[23] + 0.01 * mesh.sheet_normal[23]).normalized();
  r = check_fibers(mesh, FiberModel::parallel);
  EXPECT_EQ(r.first_bad_element, 23);
  EXPECT_NEAR(r.tangent_error_max, 0.01, 1e-3);
  mesh = good;
  mesh.fibre[4].x() = std::numeric_limits<double>::quiet_NaN();
  r = check_fibers(mesh, FiberModel::parallel);
  EXPECT_EQ(r.non_finite, 1);
  EXPECT_EQ(r.first_bad_element, 4);
  mesh.fibre.clear();
  EXPECT_FALSE(check_fibers(mesh, FiberModel::parallel).passed);
  mesh = good;
  EXPECT_FALSE(check_fibers(mesh, FiberModel::none).passed);
  assign_fibers(mesh, test::ring_annulus(), {FiberModel::none});
  EXPECT_TRUE(check_fibers(mesh, FiberModel::none).passed);
}

}  // namespace
