// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/motion_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/core/case_files.h"
#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr long most_points = 1'000'000;
constexpr double annulus_reach = 3, tip_reach = 10;  // mm
constexpr double fastest = 20;  // m/s
constexpr double at_start = 0.1;  // mm

/// Slopes of a monotone cubic, zero at both ends.
std::vector<double> slopes_of(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::vector<double> slope(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
    const double d0 = (y[i] - y[i - 1]) / h0, d1 = (y[i + 1] - y[i]) / h1;
    if (d0 * d1 > 0) slope[i] = 3 * (h0 + h1) / ((2 * h1 + h0) / d0 + (h1 + 2 * h0) / d1);
  }
  return slope;
}

}  // namespace

MotionTable::MotionTable(std::vector<double> times, std::vector<Vec3> rest, std::vector<std::vector<Vec3>> displacements)
    : times_(std::move(times)), rest_(std::move(rest)), displacements_(std::move(displacements)) {
  slopes_.assign(displacements_.size(), std::vector<Vec3>(times_.size(), Vec3::Zero()));
  std::vector<double> y(times_.size());
  for (std::size_t p = 0; p < displacements_.size(); ++p)
    for (Eigen::Index k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < y.size(); ++i) y[i] = displacements_[p][i][k];
      const std::vector<double> slope = slopes_of(times_, y);
      for (std::size_t i = 0; i < y.size(); ++i) slopes_[p][i][k] = slope[i];
    }
}

Vec3 MotionTable::displacement(int point, double time) const {
  const auto& u = displacements_[static_cast<std::size_t>(point)];
  if (time <= times_.front()) return u.front();
  if (time >= times_.back()) return u.back();
  const auto& m = slopes_[static_cast<std::size_t>(point)];
  const auto i = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) - times_.begin());
  const double h = times_[i] - times_[i - 1], s = (time - times_[i - 1]) / h;
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * u[i - 1] + (s3 - 2 * s2 + s) * h * m[i - 1] + (3 * s2 - 2 * s3) * u[i] + (s3 - s2) * h * m[i];
}

MotionTable::Place MotionTable::nearest(const Vec3& x, double* distance) const {
  Place best;
  double least = 1e300;
  for (int a = 0; a < points(); ++a) {
    const int b = (a + 1) % points();
    const Vec3 &from = rest_[static_cast<std::size_t>(a)], along = rest_[static_cast<std::size_t>(b)] - from, to = x - from;
    const double length2 = along.squaredNorm();
    const double share = length2 > 0 ? std::clamp(to.dot(along) / length2, 0.0, 1.0) : 0.0;
    const double d = (to - share * along).norm();
    if (d < least) least = d, best = {a, b, share};
  }
  if (distance) *distance = least;
  return best;
}

std::vector<MotionTable::Place> MotionTable::places_of_annulus(const LeafletMesh& mesh, const std::string& name) const {
  std::vector<Place> places;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!mesh.on_annulus[i]) continue;
    double distance = 0;
    places.push_back(nearest(mesh.points[i], &distance));
    if (!(distance <= annulus_reach))
      throw InputError(fmt::format("{}: annulus node {} at ({:.2f}, {:.2f}, {:.2f}) mm lies {:.2f} mm from the curve through the file's points, at most {:.2f} mm is expected; is the "
                                   "file of this valve, in mm and in the same frame, with its points in order round the annulus?",
                                   name, i, mesh.points[i].x(), mesh.points[i].y(), mesh.points[i].z(), distance, annulus_reach));
  }
  return places;
}

void MotionTable::check_tips(const std::vector<Vec3>& tips, const std::string& name) const {
  if (rest_.size() != tips.size()) throw InputError(fmt::format("{}: holds {} points, the case has {} papillary tips", name, rest_.size(), tips.size()));
  for (std::size_t t = 0; t < tips.size(); ++t)
    if (const double off = (rest_[t] - tips[t]).norm(); off > tip_reach)
      throw InputError(fmt::format("{}: point {} starts at ({:.1f}, {:.1f}, {:.1f}) mm, {:.1f} mm from papillary tip {} at ({:.1f}, {:.1f}, {:.1f}) mm, at most {:.0f} mm is expected; is the file of this valve, in "
                                   "mm and in the same frame, with its points numbered as in papillary.vtp?",
                                   name, t, rest_[t].x(), rest_[t].y(), rest_[t].z(), off, t, tips[t].x(), tips[t].y(), tips[t].z(), tip_reach));
}

void MotionTable::check_course(const std::string& name) const {
  constexpr double metres_per_mm = 1e-3;
  for (int p = 0; p < points(); ++p)
    if (const double moved = displacement(p, 0).norm(); moved > at_start)
      throw InputError(fmt::format("{}: at 0 s point {} has moved by {:.2f} mm from its first row, at {:.4g} s; the run starts at 0 s with the valve at rest: expected the first row there", name, p, moved, times_.front()));
  for (std::size_t p = 0; p < displacements_.size(); ++p)
    for (std::size_t i = 1; i < times_.size(); ++i)
      if (const double speed = metres_per_mm * (displacements_[p][i] - displacements_[p][i - 1]).norm() / (times_[i] - times_[i - 1]); speed > fastest)
        throw InputError(fmt::format("{}: point {} moves at {:.3g} m/s between {:.6g} and {:.6g} s, more than {:.0f} m/s; in life it is 0.1 to 0.3 m/s: are the times in seconds and the places in mm?", name, p, speed,
                                     times_[i - 1], times_[i], fastest));
}

Vec3 MotionTable::displacement(const Place& p, double time) const {
  return (1 - p.share) * displacement(p.a, time) + (p.share > 0 ? p.share : 0.0) * displacement(p.b, time);
}

double MotionTable::largest() const {
  double largest = 0;
  for (const auto& u : displacements_)
    for (const Vec3& d : u) largest = std::max(largest, d.norm());
  return largest;
}

MotionTable MotionTable::read(const std::filesystem::path& file) {
  const CsvTable table(file, "point,time_s,x_mm,y_mm,z_mm");
  const std::string& name = table.file();
  const std::size_t of_point = table.column("point"), of_time = table.column("time_s"), x = table.column("x_mm"), y = table.column("y_mm"), z = table.column("z_mm");
  struct Row {
    double time;
    Vec3 x;
    std::size_t row;
  };
  std::map<long, std::vector<Row>> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double number = table.number(row, of_point), time = table.number(row, of_time);
    if (!(number >= 0 && number <= most_points && number == std::floor(number))) throw InputError(fmt::format("{}: point {} is no number 0, 1, 2 ...", table.where(row), table.text(row, of_point)));
    const long point = std::lround(number);
    auto& own = rows[point];
    if (!own.empty() && !(time > own.back().time)) throw InputError(fmt::format("{}: time {} s of point {} does not grow", table.where(row), time, point));
    own.push_back({time, Vec3(table.number(row, x), table.number(row, y), table.number(row, z)), row});
  }
  if (rows.empty()) throw InputError(name + ": no rows below the header");
  std::vector<double> times;
  for (const Row& r : rows.begin()->second) times.push_back(r.time);
  if (times.size() < 2) throw InputError(fmt::format("{}: point {} has one row; a motion needs two or more", name, rows.begin()->first));
  if (times.front() > 0) throw InputError(fmt::format("{}: starts at {} s; the first row must give the place at rest, at 0 s or before", name, times.front()));
  std::vector<Vec3> rest;
  std::vector<std::vector<Vec3>> displacements;
  for (const auto& [point, own] : rows) {
    if (point != static_cast<long>(rest.size())) throw InputError(fmt::format("{}: point {} is missing; points are numbered 0, 1, 2 ...", name, rest.size()));
    if (own.size() != times.size()) throw InputError(fmt::format("{}: point {} has {} rows, point 0 has {}; all points need the same times", name, point, own.size(), times.size()));
    rest.push_back(own.front().x);
    auto& u = displacements.emplace_back();
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (own[i].time != times[i]) throw InputError(fmt::format("{}: time {} s differs from point 0's {} s", table.where(own[i].row), own[i].time, times[i]));
      u.push_back(own[i].x - own.front().x);
    }
  }
  return MotionTable(std::move(times), std::move(rest), std::move(displacements));
}

void write_motion(const std::filesystem::path& file, const std::vector<double>& times, const std::vector<Vec3>& rest,
                  const std::vector<std::vector<Vec3>>& displacements) {
  std::string text = "point,time_s,x_mm,y_mm,z_mm\n";
  for (std::size_t p = 0; p < rest.size(); ++p)
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Vec3 x = rest[p] + displacements[p][i];
      text += fmt::format("{},{:.9g},{:.9g},{:.9g},{:.9g}\n", p, times[i], x.x(), x.y(), x.z());
    }
  write_text_atomically(file, text);
}

}  // namespace mv
