// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "geometry/chordae/generic_chordae.h"
#include "geometry/core/unfolded.h"

namespace mv {

ClosedShape::ClosedShape(const LeafletChart& chart, const Vec3& normal, double coaptation_depth)
    : chart_(&chart), normal_(normal.normalized()), depth_(coaptation_depth) {
  double height_anterior = 0, height_posterior = 0;
  for (const auto& p : chart.border()) {
    double& height = p.region == anterior ? height_anterior : height_posterior;
    height = std::max(height, p.uv.y());
  }
  share_ = height_anterior / (height_anterior + height_posterior);
  for (const auto& j : chart.junctions())
    if (j.is_commissure)
      (j.border_index == 0 ? u_first_ : u_second_) = chart.border()[static_cast<std::size_t>(j.border_index)].uv.x();
}

bool ClosedShape::is_anterior(double u) const {
  const double along = u - u_first_ - chart_->period() * std::floor((u - u_first_) / chart_->period());
  return along <= u_second_ - u_first_;
}

double ClosedShape::fraction(double u) const {
  const double width = u_second_ - u_first_;
  const double along = u - u_first_ - chart_->period() * std::floor((u - u_first_) / chart_->period());
  return along <= width ? along / width : (chart_->period() - along) / (chart_->period() - width);
}

double ClosedShape::u_at(bool on_anterior, double s) const {
  const double width = u_second_ - u_first_;
  return on_anterior ? u_first_ + s * width : u_first_ + chart_->period() - s * (chart_->period() - width);
}

Vec3 ClosedShape::at(const Vec2& uv) const {
  const double s = fraction(uv.x());
  const Vec3 on_anterior = chart_->at({u_at(true, s), 0}).position, on_posterior = chart_->at({u_at(false, s), 0}).position;
  const Vec3 start = is_anterior(uv.x()) ? on_anterior : on_posterior;
  const Vec3 top = on_anterior + share_ * (on_posterior - on_anterior) + depth_ * normal_;
  const double roof = (top - start).norm();
  if (uv.y() <= roof) return start + (top - start) * (uv.y() / roof);
  return top + (uv.y() - roof) * normal_;
}

}  // namespace mv
