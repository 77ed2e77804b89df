// SPDX-License-Identifier: BSD-3-Clause
#include "solver/chordae/chordae_tension.h"

#include <algorithm>
#include <map>

namespace mv {

namespace {
constexpr double metres_per_mm = 1e-3;
constexpr double m2_per_mm2 = 1e-6;
}  // namespace

ChordaeTension::ChordaeTension(const Chordae& chordae, int first_free_node, double youngs_modulus)
    : ChordaeTension(chordae, first_free_node, [youngs_modulus](int) { return ChordaLaw{.youngs_modulus = youngs_modulus}; }) {}

ChordaeTension::ChordaeTension(const Chordae& chordae, int first_free_node, const std::function<ChordaLaw(int leaflet)>& law_of) {
  const std::size_t points = chordae.points.size();
  muscle_ = chordae.muscle_of_point;
  node_.assign(points, -1);
  std::vector<char> is_leaflet_end(points, 0);
  for (const Insertion& i : chordae.insertions) is_leaflet_end[static_cast<std::size_t>(i.point)] = 1;
  int tips = 0;
  for (std::size_t p = 0; p < points; ++p) {
    tips = std::max(tips, muscle_[p] + 1);
    if (muscle_[p] < 0 && !is_leaflet_end[p]) {
      node_[p] = first_free_node + static_cast<int>(free_points_.size());
      free_points_.push_back(static_cast<int>(p));
    }
  }
  std::map<int, int> law_of_leaflet;
  for (const ChordaSegment& s : chordae.segments) {
    const double rest = s.rest_length * metres_per_mm;
    const double area = s.area * m2_per_mm2;
    const auto [law, is_new] = law_of_leaflet.try_emplace(s.leaflet, static_cast<int>(laws_.size()));
    if (is_new) laws_.push_back(law_of(s.leaflet));
    segments_.push_back({s.a, s.b, rest, area, area, law->second});
    tips = std::max(tips, s.muscle + 1);
  }
  insertions_ = chordae.insertions;
  tensions_.assign(segments_.size(), 0.0);
  papillary_forces_.assign(static_cast<std::size_t>(tips), Eigen::Vector3d::Zero());
  positions_.resize(points);
  moved_.resize(points);
  point_forces_.resize(points);
}

void ChordaeTension::gather(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::vector<Eigen::Vector3d>& out) const {
  for (std::size_t p = 0; p < out.size(); ++p) {
    if (muscle_[p] >= 0) {
      out[p] = tips.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : tips[static_cast<std::size_t>(muscle_[p])];
      if (!tips.empty() && !offsets_.empty()) out[p] += offsets_[p];
    }
    else if (node_[p] >= 0) out[p] = Eigen::Vector3d::Map(x.data() + 3 * node_[p]);
    else out[p].setZero();
  }
  for (const Insertion& i : insertions_) out[static_cast<std::size_t>(i.point)] += i.weight * Eigen::Vector3d::Map(x.data() + 3 * i.node);
}

void ChordaeTension::scatter(const std::vector<Eigen::Vector3d>& point_forces, std::span<double> out) const {
  for (std::size_t p = 0; p < point_forces.size(); ++p)
    if (node_[p] >= 0) Eigen::Vector3d::Map(out.data() + 3 * node_[p]) += point_forces[p];
  for (const Insertion& i : insertions_) Eigen::Vector3d::Map(out.data() + 3 * i.node) += i.weight * point_forces[static_cast<std::size_t>(i.point)];
}

double ChordaeTension::forces(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::span<double> forces) {
  gather(x, tips, positions_);
  std::fill(point_forces_.begin(), point_forces_.end(), Eigen::Vector3d::Zero());
  std::fill(papillary_forces_.begin(), papillary_forces_.end(), Eigen::Vector3d::Zero());
  double energy = 0;
  for (std::size_t s = 0; s < segments_.size(); ++s) {
    const Segment& segment = segments_[s];
    const Eigen::Vector3d along = positions_[static_cast<std::size_t>(segment.b)] - positions_[static_cast<std::size_t>(segment.a)];
    const double length = along.norm();
    tensions_[s] = 0;
    if (length <= segment.rest_length) continue;
    const ChordaResponse response = chorda_response(laws_[static_cast<std::size_t>(segment.law)], length / segment.rest_length);
    tensions_[s] = segment.area * response.stress;
    energy += segment.area * segment.rest_length * response.energy;
    const Eigen::Vector3d pull = tensions_[s] / length * along;
    point_forces_[static_cast<std::size_t>(segment.a)] += pull;
    point_forces_[static_cast<std::size_t>(segment.b)] -= pull;
  }
  for (std::size_t p = 0; p < positions_.size(); ++p)
    if (muscle_[p] >= 0) papillary_forces_[static_cast<std::size_t>(muscle_[p])] += point_forces_[p];
  scatter(point_forces_, forces);
  return energy;
}

double ChordaeTension::energy(std::span<const double> x, std::span<const Eigen::Vector3d> tips) {
  gather(x, tips, positions_);
  double energy = 0;
  for (const Segment& segment : segments_) {
    const double length = (positions_[static_cast<std::size_t>(segment.b)] - positions_[static_cast<std::size_t>(segment.a)]).norm();
    if (length > segment.rest_length)
      energy += segment.area * segment.rest_length * chorda_response(laws_[static_cast<std::size_t>(segment.law)], length / segment.rest_length).energy;
  }
  return energy;
}

void ChordaeTension::set_cut(std::span<const int> segments, bool is_cut) {
  for (int s : segments) {
    Segment& segment = segments_[static_cast<std::size_t>(s)];
    segment.area = is_cut ? 0.0 : segment.whole_area;
  }
}

void ChordaeTension::stiffness_times(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::span<const double> v,
                                     std::span<double> out) {
  gather(x, tips, positions_);
  gather(v, {}, moved_);
  std::fill(point_forces_.begin(), point_forces_.end(), Eigen::Vector3d::Zero());
  for (const Segment& segment : segments_) {
    const Eigen::Vector3d along = positions_[static_cast<std::size_t>(segment.b)] - positions_[static_cast<std::size_t>(segment.a)];
    const double length = along.norm();
    if (length <= segment.rest_length) continue;
    const Eigen::Vector3d direction = along / length;
    const Eigen::Vector3d relative = moved_[static_cast<std::size_t>(segment.b)] - moved_[static_cast<std::size_t>(segment.a)];
    const double axial = direction.dot(relative);
    const ChordaResponse response = chorda_response(laws_[static_cast<std::size_t>(segment.law)], length / segment.rest_length);
    const double geometric = segment.area * response.stress / length;
    const Eigen::Vector3d resistance = segment.area * response.tangent / segment.rest_length * axial * direction + geometric * (relative - axial * direction);
    point_forces_[static_cast<std::size_t>(segment.b)] += resistance;
    point_forces_[static_cast<std::size_t>(segment.a)] -= resistance;
  }
  scatter(point_forces_, out);
}

void ChordaeTension::add_rest_stiffness(std::span<double> node_stiffness) const {
  std::vector<double> at_point(muscle_.size(), 0.0);
  for (const Segment& s : segments_) {
    const double k = s.area * chorda_response(laws_[static_cast<std::size_t>(s.law)], 1.0).tangent / s.rest_length;
    at_point[static_cast<std::size_t>(s.a)] += k;
    at_point[static_cast<std::size_t>(s.b)] += k;
  }
  for (std::size_t p = 0; p < at_point.size(); ++p)
    if (node_[p] >= 0) node_stiffness[static_cast<std::size_t>(node_[p])] += at_point[p];
  for (const Insertion& i : insertions_) node_stiffness[static_cast<std::size_t>(i.node)] += i.weight * at_point[static_cast<std::size_t>(i.point)];
}

void ChordaeTension::point_positions(std::span<const double> x, std::span<const Eigen::Vector3d> tips, std::vector<Eigen::Vector3d>& out) const {
  out.resize(muscle_.size());
  gather(x, tips, out);
}

}  // namespace mv
