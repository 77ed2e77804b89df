// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/chordae_grower.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double spared_radii = 1.5;       // the last piece of a chorda may touch the leaflet it holds
constexpr double deepest_branch = 0.6;     // a branch point keeps this share of the way to the head at most
constexpr double least_thicknesses = 0.75; // an influence sphere reaches beyond both faces
constexpr double same_side = 1e-3;         // mm

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

ChordaeGrower::ChordaeGrower(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, const std::vector<Vec3>& heads, const Options& options)
    : mesh_(mesh), graph_(mesh), chart_(mesh), probe_(mesh), closed_(chart_, annulus, options.coaptation_depth), options_(options), tips_(papillary.tips) {
  if (tips_.size() < 2) throw InputError("chordae: two papillary tips are needed, got " + std::to_string(tips_.size()));
  const Vec3 first = chart_.at({closed_.commissure_u(0), 0}).position, second = chart_.at({closed_.commissure_u(1), 0}).position;
  const Vec3 axis = (second - first).normalized();
  std::vector<double> along;
  for (const Vec3& tip : tips_) along.push_back((tip - first).dot(axis));
  const auto [low, high] = std::minmax_element(along.begin(), along.end());
  if (*high - *low < same_side)
    throw InputError("chordae: the papillary tips do not lie on different sides of the valve (along the line between the commissures)");
  const double middle = 0.5 * (*low + *high);
  for (double a : along) half_of_muscle_.push_back(a > middle ? 1 : 0);
  std::vector<char> has_heads(tips_.size(), 0);
  for (const Vec3& h : heads) {
    std::size_t best = 0;
    for (std::size_t t = 1; t < tips_.size(); ++t)
      if ((tips_[t] - h).norm() < (tips_[best] - h).norm()) best = t;
    heads_.push_back(h);
    muscle_of_head_.push_back(static_cast<int>(best));
    has_heads[best] = 1;
  }
  for (std::size_t t = 0; t < tips_.size(); ++t)
    if (!has_heads[t]) {
      heads_.push_back(tips_[t]);
      muscle_of_head_.push_back(static_cast<int>(t));
    }
}

ChordaEnd ChordaeGrower::border_end(double arc, double radius, double inset) const {
  ChordaEnd end;
  end.centre_uv = chart_.border_uv(arc);
  end.radius = radius;
  const double step = 0.5 * radius;
  Vec2 after = chart_.border_uv(arc + step), before = chart_.border_uv(arc - step);
  after.x() += chart_.period() * std::round((end.centre_uv.x() - after.x()) / chart_.period());
  before.x() += chart_.period() * std::round((end.centre_uv.x() - before.x()) / chart_.period());
  const Vec2 along = (after - before).normalized();
  end.end_uv = end.centre_uv + inset * radius * Vec2(along.y(), -along.x());
  return end;
}

int ChordaeGrower::muscle_of(const ChordaEnd& end) const {
  const int half = closed_.fraction(end.end_uv.x()) > 0.5 ? 1 : 0;
  const Vec3 place = closed_.at(end.end_uv);
  int best = -1;
  for (std::size_t t = 0; t < tips_.size(); ++t)
    if (half_of_muscle_[t] == half && (best < 0 || (tips_[t] - place).norm() < (tips_[at(best)] - place).norm())) best = static_cast<int>(t);
  return best;
}

// Branch points of ends[begin, stop) in the closed shape, from the ends up.
int ChordaeGrower::plan(const std::vector<InfluenceSphere>& spheres, const std::vector<Vec3>& closed, std::size_t begin, std::size_t stop, const Vec3& head,
                        std::vector<Node>& nodes) const {
  Node node;
  if (stop - begin == 1) {
    node.closed = closed[begin];
    node.initial = spheres[begin].end;
    node.end = begin;
  } else {
    const std::size_t half = begin + (stop - begin + 1) / 2;
    node.left = plan(spheres, closed, begin, half, head, nodes);
    node.right = plan(spheres, closed, half, stop, head, nodes);
    const Node &l = nodes[at(node.left)], &r = nodes[at(node.right)];
    const Vec3 middle = 0.5 * (l.closed + r.closed), up = head - middle;
    const double span = 0.5 * (l.closed - r.closed).norm(), angle = options_.branch_angle * std::numbers::pi / 180;
    node.closed = middle + up.normalized() * std::min(span / std::tan(0.5 * angle), deepest_branch * up.norm());
    node.leaves = l.leaves + r.leaves;
    node.below = (l.leaves * ((l.closed - node.closed).norm() + l.below) + r.leaves * ((r.closed - node.closed).norm() + r.below)) / node.leaves;
  }
  nodes.push_back(node);
  return static_cast<int>(nodes.size()) - 1;
}

// Branch points in the open valve, from the head down: on the way to the mean of the ends, in the ratio of the closed lengths.
void ChordaeGrower::settle(std::vector<Node>& nodes, int index, const Vec3& parent_closed, const Vec3& parent_initial) const {
  Node& node = nodes[at(index)];
  if (node.left < 0) return;
  Vec3 mean = Vec3::Zero();
  std::vector<int> stack{index};
  while (!stack.empty()) {
    const Node& n = nodes[at(stack.back())];
    stack.pop_back();
    if (n.left < 0) {
      mean += n.initial / node.leaves;
    } else {
      stack.push_back(n.left);
      stack.push_back(n.right);
    }
  }
  const double above = (node.closed - parent_closed).norm();
  node.initial = parent_initial + (mean - parent_initial) * (above / (above + node.below));
  const Vec3 closed = node.closed, initial = node.initial;
  const int left = node.left, right = node.right;
  settle(nodes, left, closed, initial);
  settle(nodes, right, closed, initial);
}

bool ChordaeGrower::is_blocked(const std::vector<Node>& nodes, int index, const Vec3& parent, double spared) const {
  const Node& node = nodes[at(index)];
  if (probe_.crossing(parent, node.initial, node.left < 0 ? spared : 0)) return true;
  return node.left >= 0 && (is_blocked(nodes, node.left, node.initial, spared) || is_blocked(nodes, node.right, node.initial, spared));
}

int ChordaeGrower::add_point(const Vec3& position, int muscle) {
  out_.points.push_back(position);
  out_.muscle_of_point.push_back(muscle);
  return static_cast<int>(out_.points.size()) - 1;
}

void ChordaeGrower::add_subtree(const std::vector<Node>& nodes, int index, int parent_point, const Vec3& parent_closed, const std::vector<int>& end_points, ChordaSegment segment,
                                double area, int leaves) {
  const Node& node = nodes[at(index)];
  segment.a = parent_point;
  segment.b = node.left < 0 ? end_points[node.end] : add_point(node.initial, -1);
  segment.area = area * node.leaves / leaves;
  segment.rest_length = std::max(options_.slack * (node.closed - parent_closed).norm(), (out_.points[at(segment.a)] - out_.points[at(segment.b)]).norm());
  out_.segments.push_back(segment);
  if (node.left < 0) return;
  const int here = segment.b;
  add_subtree(nodes, node.left, here, node.closed, end_points, segment, area, leaves);
  add_subtree(nodes, node.right, here, node.closed, end_points, segment, area, leaves);
}

ChordaeGrower::Outcome ChordaeGrower::grow(const std::vector<ChordaEnd>& ends, ChordaKind kind, double area, bool forced) {
  std::vector<InfluenceSphere> spheres;
  std::vector<Vec3> closed;
  int enlarged = 0;
  double radius = 0;
  Vec3 mean = Vec3::Zero();
  for (const ChordaEnd& e : ends) {
    const auto centre = chart_.at(e.centre_uv), place = chart_.at(e.end_uv);
    GrownSphere grown;
    const double least = std::max(least_thicknesses * probe_.nearest(centre.position).thickness, probe_.mean_edge());
    spheres.push_back(sphere_at(graph_, centre.position, place.position, place.normal, std::max(e.radius, least), &grown));
    enlarged += grown.was_enlarged || e.radius < least;
    radius = std::max(radius, grown.radius);
    closed.push_back(closed_.at(e.end_uv));
    mean += closed.back() / static_cast<double>(ends.size());
  }
  const int muscle = muscle_of(ends[ends.size() / 2]);
  std::vector<int> order;
  for (std::size_t h = 0; h < heads_.size(); ++h)
    if (muscle_of_head_[h] == muscle) order.push_back(static_cast<int>(h));
  std::sort(order.begin(), order.end(), [&](int a, int b) { return (heads_[at(a)] - mean).norm() < (heads_[at(b)] - mean).norm(); });

  int chosen = -1;
  std::vector<Node> nodes;
  int top = -1;
  const auto lay_out = [&](int head) {
    nodes.clear();
    top = plan(spheres, closed, 0, ends.size(), heads_[at(head)], nodes);
    settle(nodes, top, heads_[at(head)], heads_[at(head)]);
  };
  for (int head : order) {
    lay_out(head);
    if (options_.avoids_leaflets && is_blocked(nodes, top, heads_[at(head)], spared_radii * radius)) continue;
    chosen = head;
    break;
  }
  Outcome outcome = chosen == order.front() ? Outcome::grown : Outcome::other_head;
  if (chosen < 0) {
    if (!forced) return Outcome::blocked;
    outcome = Outcome::blocked;
    chosen = order.front();
    lay_out(chosen);
  }
  radius_enlarged_ += enlarged;
  ++trees_;
  std::vector<int> end_points;
  for (const InfluenceSphere& sphere : spheres) {
    end_points.push_back(add_point(sphere.end, -1));
    for (const auto& [node, weight] : sphere.weights) out_.insertions.push_back({end_points.back(), node, weight});
  }
  const auto [root, is_new] = root_points_.try_emplace(chosen, -1);
  if (is_new) root->second = add_point(heads_[at(chosen)], muscle);
  ChordaSegment segment;
  segment.kind = kind;
  segment.muscle = muscle;
  segment.leaflet = closed_.is_anterior(ends[ends.size() / 2].end_uv.x()) ? anterior : posterior;
  add_subtree(nodes, top, root->second, heads_[at(chosen)], end_points, segment, area, static_cast<int>(ends.size()));
  return outcome;
}

}  // namespace mv
