// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/flat_pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double largest_anterior_share = 0.9;

/// Right half of a half-ellipse with semi-axes a (along u) and b, its right end at the origin; angle 0 at that end, pi/2 at the
/// top.
struct QuarterEllipse {
  double a, b;
  Vec2 point(double angle) const { return {-a * (1 - std::cos(angle)), b * std::sin(angle)}; }
  Vec2 normal(double angle) const { return Vec2(std::cos(angle) / a, std::sin(angle) / b).normalized(); }
  Vec2 offset(double angle, double r) const { return point(angle) + r * normal(angle); }
  /// Angle at which the offset curve reaches height v; the height grows with the angle.
  double angle_at_height(double v, double r) const {
    double lower = 0, upper = std::numbers::pi / 2;
    for (int i = 0; i < 80; ++i) {
      const double middle = 0.5 * (lower + upper);
      (offset(middle, r).y() < v ? lower : upper) = middle;
    }
    return 0.5 * (lower + upper);
  }
};

void require(bool condition, const std::string& key, double value, const std::string& expected) {
  if (condition) return;
  std::ostringstream message;
  message << "generic." << key << " = " << value << ": " << expected;
  throw ConfigError(message.str());
}

}  // namespace

FlatPattern::FlatPattern(const PatternParameters& p) : parameters_(p) {
  require(p.perimeter > 0, "perimeter", p.perimeter, "must be positive (mm)");
  require(p.strip_height > 0, "strip_height", p.strip_height,
          "must be positive (mm): the strip gives the commissures their height");
  require(p.anterior_radius > 0, "anterior_radius", p.anterior_radius, "must be positive (mm)");
  require(p.anterior_height > 0, "anterior_height", p.anterior_height, "must be positive");
  require(p.posterior_height > 0, "posterior_height", p.posterior_height, "must be positive");
  require(p.posterior_scallops >= 1, "posterior_scallops", p.posterior_scallops, "at least one scallop");
  require(2 * p.anterior_radius <= largest_anterior_share * p.perimeter, "anterior_radius", p.anterior_radius,
          "twice the radius must stay below 90 % of the annulus perimeter of " + std::to_string(p.perimeter) + " mm");
  const double posterior_radius = (p.perimeter - 2 * p.anterior_radius) / (2 * p.posterior_scallops);
  scallops_.push_back({p.anterior_radius, p.anterior_radius, p.anterior_height});
  notches_.push_back(0);
  for (int i = 0; i < p.posterior_scallops; ++i) {
    notches_.push_back(2 * p.anterior_radius + 2 * posterior_radius * i);
    scallops_.push_back({notches_.back() + posterior_radius, posterior_radius, p.posterior_height});
  }
  const double r = p.notch_radius;
  require(r > 0 && r < 0.5 * std::min(posterior_radius, p.anterior_radius), "notch_radius", r,
          "must be positive and below half the smallest scallop radius of " +
              std::to_string(std::min(posterior_radius, p.anterior_radius)) + " mm");
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const Scallop& before = scallops_[(i + scallops_.size() - 1) % scallops_.size()];
    const Scallop& after = scallops_[i];
    const QuarterEllipse left{before.radius, before.factor * before.radius}, right{after.radius, after.factor * after.radius};
    // The fillet's centre is where the two curves offset by r cross.
    double lower = 0, upper = std::min(left.b, right.b) + r;
    double angle_left = 0, angle_right = 0;
    for (int k = 0; k < 80; ++k) {
      const double v = 0.5 * (lower + upper);
      angle_left = left.angle_at_height(v, r);
      angle_right = right.angle_at_height(v, r);
      (left.offset(angle_left, r).x() + right.offset(angle_right, r).x() > 0 ? lower : upper) = v;
    }
    fillets_.push_back({notches_[i] + left.offset(angle_left, r).x(), p.strip_height + lower,
                        notches_[i] + left.point(angle_left).x(), notches_[i] - right.point(angle_right).x()});
  }
}

double FlatPattern::wrap(double u) const {
  u = std::fmod(u, perimeter());
  return u < 0 ? u + perimeter() : u;
}

int FlatPattern::scallop(double u) const {
  u = wrap(u);
  const auto next = std::upper_bound(notches_.begin(), notches_.end(), u);
  return static_cast<int>(next - notches_.begin()) - 1;
}

Region FlatPattern::region(double u) const { return scallop(u) == 0 ? anterior : posterior; }

double FlatPattern::height(double u) const {
  u = wrap(u);
  for (const Fillet& f : fillets_)
    for (const double shift : {0.0, perimeter()}) {
      const double x = u - shift;
      if (x < f.u_begin || x > f.u_end) continue;
      const double d = x - f.centre_u;
      return f.centre_v - std::sqrt(std::max(0.0, parameters_.notch_radius * parameters_.notch_radius - d * d));
    }
  const Scallop& s = scallops_[static_cast<std::size_t>(scallop(u))];
  const double d = u - s.centre;
  return parameters_.strip_height + s.factor * std::sqrt(std::max(0.0, s.radius * s.radius - d * d));
}

double FlatPattern::notch_height(int i) const {
  return fillets_[static_cast<std::size_t>(i)].centre_v - parameters_.notch_radius;
}

std::vector<Vec2> FlatPattern::free_edge(double step) const {
  using std::numbers::pi;
  std::vector<Vec2> edge;
  auto append_arc = [&](double a, double b, double angle_begin, double angle_end, const Vec2& centre) {
    const double length = std::abs(angle_end - angle_begin) * std::max(a, b);
    const int n = std::max(2, static_cast<int>(std::ceil(length / step)));
    for (int i = 0; i < n; ++i) {
      const double angle = angle_begin + (angle_end - angle_begin) * i / n;
      edge.push_back(centre + Vec2(a * std::cos(angle), b * std::sin(angle)));
    }
  };
  auto fillet_angle = [&](const Fillet& f, double u) {
    return -std::acos(std::clamp((u - f.centre_u) / parameters_.notch_radius, -1.0, 1.0));
  };
  auto ellipse_angle = [](const Scallop& s, double u) { return std::acos(std::clamp((u - s.centre) / s.radius, -1.0, 1.0)); };
  const double r = parameters_.notch_radius;
  for (std::size_t i = 0; i < scallops_.size(); ++i) {
    const Fillet& first = fillets_[i];
    Fillet last = fillets_[(i + 1) % fillets_.size()];
    const double end = i + 1 < notches_.size() ? notches_[i + 1] : perimeter();
    if (i + 1 == notches_.size()) {
      last.centre_u += perimeter();
      last.u_begin += perimeter();
    }
    const Scallop& s = scallops_[i];
    append_arc(r, r, fillet_angle(first, notches_[i]), fillet_angle(first, first.u_end), {first.centre_u, first.centre_v});
    append_arc(s.radius, s.factor * s.radius, ellipse_angle(s, first.u_end), ellipse_angle(s, last.u_begin),
               {s.centre, parameters_.strip_height});
    append_arc(r, r, fillet_angle(last, last.u_begin), fillet_angle(last, end), {last.centre_u, last.centre_v});
  }
  return edge;
}

double FlatPattern::area() const {
  std::vector<Vec2> edge = free_edge(1e-3 * perimeter());
  edge.push_back({edge.front().x() + perimeter(), edge.front().y()});
  double sum = 0;
  for (std::size_t i = 0; i + 1 < edge.size(); ++i)
    sum += 0.5 * (edge[i].y() + edge[i + 1].y()) * (edge[i + 1].x() - edge[i].x());
  return sum;
}

}  // namespace mv
