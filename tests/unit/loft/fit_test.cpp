// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "geometry/core/errors.h"
#include "geometry/loft/hinge_annulus.h"
#include "geometry/loft/open_curve.h"
#include "geometry/loft/spline_surface.h"
#include "geometry/loft/surface_distance.h"
#include "support/cone_valve.h"

using namespace mv;
using mv_test::Noise;
using std::numbers::pi;

namespace {

double evaluate(const SplineBasis& basis, const Eigen::VectorXd& c, double x, int derivative = 0) {
  const SplineValues v = basis.at(x, derivative);
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) sum += v.value[k] * c(v.index[k]);
  return sum;
}

/// Fit of noisy samples of sin on a circle.
FitReport fit_sine(double noise, const Smoothing& smoothing, double* error = nullptr) {
  const SplineBasis basis(40, 2 * pi, true);
  const int n = 200;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, basis.size()), Y(n, 1);
  Noise random(7);
  for (int i = 0; i < n; ++i) {
    const double x = 2 * pi * i / n;
    const SplineValues v = basis.at(x);
    for (std::size_t k = 0; k < 4; ++k) B(i, v.index[k]) += v.value[k];
    Y(i, 0) = std::sin(2 * x) + 0.4 * std::cos(5 * x) + noise * std::sqrt(3.0) * random();
  }
  FitReport report;
  const Eigen::VectorXd c = penalized_fit(B, Eigen::VectorXd::Ones(n), Y, basis.gram({0, 0, 1, 0}), smoothing, &report);
  if (error) {
    *error = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = 2 * pi * i / 1000;
      *error += std::pow(evaluate(basis, c, x) - std::sin(2 * x) - 0.4 * std::cos(5 * x), 2) / 1000;
    }
    *error = std::sqrt(*error);
  }
  return report;
}

std::vector<Vec3> ellipse_points(double from_degrees, double to_degrees, int n, double noise, std::uint64_t seed = 3) {
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.6, Vec3(1, 2, 0).normalized()) * Eigen::AngleAxisd(0.4, Vec3::UnitZ())).toRotationMatrix();
  Noise random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < n; ++i) {
    const double a = (from_degrees + (to_degrees - from_degrees) * i / (n - 1)) * pi / 180;
    points.push_back(turn * Vec3(19 * std::cos(a), 14 * std::sin(a), 0) + Vec3(30, -400, 80) + noise * random.vector());
  }
  return points;
}

}  // namespace

TEST(SplineBasis, sums_to_one_and_has_the_derivatives_of_its_values) {
  for (const bool periodic : {true, false}) {
    const SplineBasis basis(9, 7.0, periodic);
    for (double x = 0.01; x < 7; x += 0.237) {
      double sum = 0;
      for (const double v : basis.at(x).value) sum += v;
      EXPECT_NEAR(sum, 1, 1e-14);
      Eigen::VectorXd c = Eigen::VectorXd::LinSpaced(basis.size(), 0, 3).array().sin();
      const double h = 1e-5;
      for (int d = 1; d <= 3; ++d) {
        if (std::floor((x - h) * 9 / 7) != std::floor((x + h) * 9 / 7)) continue;
        const double difference = (evaluate(basis, c, x + h, d - 1) - evaluate(basis, c, x - h, d - 1)) / (2 * h);
        EXPECT_NEAR(evaluate(basis, c, x, d), difference, 1e-6) << "derivative " << d << " at " << x;
      }
    }
  }
}

TEST(SplineBasis, gram_matrix_is_the_integral_of_the_squared_operator) {
  const SplineBasis basis(11, 2 * pi, true);
  const Eigen::VectorXd c = Eigen::VectorXd::LinSpaced(basis.size(), 0, 3).array().sin();
  const double quadratic = c.dot(basis.gram({0.3, 1, 0, 1}) * c);
  double sum = 0;
  const int n = 22000;  // a multiple of the segments: the third derivative jumps at knots
  for (int i = 0; i < n; ++i) {
    const double x = 2 * pi * (i + 0.5) / n;
    sum += std::pow(0.3 * evaluate(basis, c, x) + evaluate(basis, c, x, 1) + evaluate(basis, c, x, 3), 2) * 2 * pi / n;
  }
  EXPECT_NEAR(quadratic / sum, 1, 1e-6);
}

TEST(PenalizedFit, cross_validation_smooths_less_for_less_noise_and_beats_both_extremes) {
  double last = 0;
  for (const double noise : {0.003, 0.03, 0.3}) {
    double error = 0, rough = 0, smooth = 0;
    const FitReport report = fit_sine(noise, {}, &error);
    fit_sine(noise, {SmoothingRule::fixed, 0, report.lambda * 1e-4}, &rough);
    fit_sine(noise, {SmoothingRule::fixed, 0, report.lambda * 1e4}, &smooth);
    std::printf("noise %.3f: lambda %.3g, %.1f degrees of freedom, error %.4f (rougher %.4f, smoother %.4f)\n", noise, report.lambda, report.degrees_of_freedom, error, rough, smooth);
    EXPECT_GT(report.lambda, last);
    EXPECT_LT(error, 0.7 * noise);
    EXPECT_LE(error, rough * 1.02);
    EXPECT_LT(error, smooth);
    EXPECT_FALSE(report.is_at_limit);
    last = report.lambda;
  }
}

TEST(PenalizedFit, discrepancy_principle_leaves_the_stated_residual) {
  const FitReport report = fit_sine(0.05, {SmoothingRule::discrepancy, 0.05, 0});
  EXPECT_NEAR(report.rms, 0.05, 0.0005);
}

TEST(HingeAnnulus, tilted_ellipse_is_closed_exactly_where_no_hinge_is_known) {
  // A third of the ring is missing.
  const HingeAnnulus annulus(ellipse_points(-60, 180, 20, 0));
  double most = 0;
  for (const Vec3& p : ellipse_points(0, 360, 181, 0)) most = std::max(most, annulus.distance(p));
  std::printf("largest distance of the ellipse from the annulus %.2e mm, gap %.0f degrees, %.1f mm\n", most, annulus.report().largest_gap_degrees, annulus.report().largest_gap_mm);
  EXPECT_LT(most, 1e-3);
  EXPECT_NEAR(annulus.report().largest_gap_degrees, 120, 1);
  EXPECT_NEAR(annulus.frame().a, 19, 0.01);
  EXPECT_NEAR(annulus.frame().b, 14, 0.01);
  // Ramanujan's second approximation
  const double h = std::pow(5.0 / 33, 2), perimeter = pi * 33 * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
  EXPECT_NEAR(annulus.length(), perimeter, 0.01);
}

TEST(HingeAnnulus, noise_is_smoothed) {
  const HingeAnnulus annulus(ellipse_points(0, 360 - 360.0 / 28, 28, 0.5));
  double sum = 0, most = 0;
  for (const Vec3& p : ellipse_points(0, 358, 180, 0)) sum += annulus.distance(p) / 180, most = std::max(most, annulus.distance(p));
  std::printf("noise of 0.5 mm per axis: annulus off by %.3f mm on average, %.3f mm at most\n", sum, most);
  EXPECT_LT(sum, 0.25);
  EXPECT_LT(most, 0.6);
}

TEST(HingeAnnulus, saddle_and_straight_anterior_side_are_followed) {
  std::vector<Vec3> points, truth;
  const auto at = [](double a) { return Vec3(18 * std::cos(a), 14 * std::max(-0.75, std::sin(a)), 2 * std::cos(2 * a)); };
  for (int i = 0; i < 40; ++i) points.push_back(at(2 * pi * i / 40));
  for (int i = 0; i < 360; ++i) truth.push_back(at(2 * pi * i / 360));
  const HingeAnnulus annulus(points);
  double sum = 0;
  for (const Vec3& p : truth) sum += annulus.distance(p) / 360;
  EXPECT_LT(sum, 0.2);
}

TEST(HingeAnnulus, does_not_pass_slices_without_leaflet) {
  AnnulusOptions options;
  options.limit_normal = Vec3::UnitX();
  std::vector<Vec3> points;
  for (int k = -4; k <= 4; ++k)
    for (const int side : {-1, 1}) points.emplace_back(3.0 * k, side * 14 * std::sqrt(1 - std::pow(3.0 * k / 17, 2)), 0);
  const auto reach = [](const HingeAnnulus& a) {
    double x = 0;
    for (const Vec3& p : a.points(360)) x = std::max(x, p.x());
    return x;
  };
  const HingeAnnulus open(points);
  options.limits = {Vec3(15, 0, 0), Vec3(-15, 0, 0)};
  const HingeAnnulus closed(points, options);
  EXPECT_NEAR(reach(open), 17, 0.05);
  EXPECT_LT(reach(closed), 15.5);
  EXPECT_NEAR(closed.report().pulled_back, 2, 0.2);
}

TEST(HingeAnnulus, refuses_a_line_few_points_and_half_a_ring) {
  std::vector<Vec3> line;
  for (int i = 0; i < 9; ++i) line.emplace_back(i, 2 * i, 0);
  EXPECT_THROW(HingeAnnulus{line}, InputError);
  EXPECT_THROW(HingeAnnulus{ellipse_points(0, 300, 5, 0)}, InputError);
  EXPECT_THROW(HingeAnnulus{ellipse_points(0, 170, 20, 0)}, InputError);
}

TEST(OpenCurve, stair_steps_vanish_and_the_ends_stay) {
  std::vector<Vec3> stairs;
  for (int i = 0; i <= 60; ++i) {
    const double x = 0.35 * i, y = 3 * std::sin(x / 7);
    stairs.emplace_back(x, 0.7 * std::round(y / 0.7), 0);
  }
  double most = 0;
  // The ends are kept where they are, here up to half a step off.
  for (const Vec3& p : smooth_open_curve(stairs, 0.25, 0.5))
    if (p.x() > 2 && p.x() < 19) most = std::max(most, std::abs(p.y() - 3 * std::sin(p.x() / 7)));
  EXPECT_LT(most, 0.3);
  EXPECT_LT((smooth_open_curve(stairs, 0.25, 0.5).back() - stairs.back()).norm(), 0.25);
}

TEST(SplineSurface, known_surface_is_reproduced_with_fourth_order) {
  // r = 15 + 2 cos 3u sin 2v on a ring; exact parameters, no noise.
  const double period = 2 * pi * 15;
  const auto truth = [&](double u, double v) {
    const double a = u / 15, r = 15 + 2 * std::cos(3 * a) * std::sin(2 * v) - 5 * v;
    return Vec3(r * std::cos(a), r * std::sin(a), -14 * v + std::sin(2 * a));
  };
  std::vector<double> errors;
  for (const int n : {12, 24, 48}) {
    SplineSurface surface(n, n / 4, period, 15);
    std::vector<SurfaceDatum> data;
    for (int i = 0; i < 4 * n; ++i)
      for (int j = 0; j <= n; ++j) data.push_back({truth(period * i / (4 * n), static_cast<double>(j) / n), period * i / (4 * n), static_cast<double>(j) / n});
    surface.fit(data, {SmoothingRule::fixed, 0, 1e-11});
    double most = 0;
    for (int i = 0; i < 331; ++i)
      for (int j = 0; j < 37; ++j) most = std::max(most, (surface.at(period * i / 331, j / 36.0) - truth(period * i / 331, j / 36.0)).norm());
    errors.push_back(most);
  }
  std::printf("errors %.3g %.3g %.3g mm, orders %.2f %.2f\n", errors[0], errors[1], errors[2], std::log2(errors[0] / errors[1]), std::log2(errors[1] / errors[2]));
  EXPECT_GT(std::log2(errors[0] / errors[1]), 3.5);
  EXPECT_GT(std::log2(errors[1] / errors[2]), 3.5);
}

TEST(SplineSurface, ruled_surface_between_ellipses_needs_no_data_in_between) {
  const double period = 2 * pi * 15;
  const auto truth = [&](double u, double v) {
    const double a = u / 15;
    return Vec3((18 - 6 * v) * std::cos(a) + 2 * v, (13 - 7 * v) * std::sin(a) + 1, -15 * v + 0.3 * std::cos(a));
  };
  SplineSurface surface(24, 5, period, 15);
  std::vector<SurfaceDatum> data;
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j <= 5; ++j) data.push_back({truth(period * i / 10.5, 0.2 * j), period * i / 10.5, 0.2 * j});  // two thirds of the ring
  surface.fit(data, {});
  double most = 0;
  for (int i = 0; i < 100; ++i)
    for (int j = 0; j < 11; ++j) most = std::max(most, (surface.at(period * i / 100, 0.1 * j) - truth(period * i / 100, 0.1 * j)).norm());
  EXPECT_LT(most, 0.01);
}

TEST(SurfaceDistance, planes_and_points_have_known_distances) {
  EXPECT_DOUBLE_EQ(triangle_distance({0.2, 0.2, 3}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 3);
  EXPECT_DOUBLE_EQ(triangle_distance({2, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}), 1);
  EXPECT_NEAR(triangle_distance({1, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}), std::sqrt(0.5), 1e-15);
  const std::vector<Vec3> square = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  std::vector<Vec3> raised = square, wide = square;
  for (Vec3& p : raised) p.z() += 0.7;
  for (Vec3& p : wide) p.x() *= 2;
  const std::vector<std::array<int, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
  const SurfaceDistance parallel = surface_distance(square, triangles, raised, triangles);
  EXPECT_NEAR(parallel.mean, 0.7, 1e-12);
  EXPECT_NEAR(parallel.p95, 0.7, 1e-12);
  // The farther half of the wide square lies 0 .. 4 mm from the other: mean 1 over the whole of it, 0.5 for both directions.
  const SurfaceDistance wider = surface_distance(square, triangles, wide, triangles, 0.2);
  EXPECT_NEAR(wider.mean_a_to_b, 0, 1e-12);
  EXPECT_NEAR(wider.mean_b_to_a, 1, 0.01);
  EXPECT_NEAR(wider.max, 4, 0.2);
}
