// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/layout_rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace mv {
namespace {

constexpr double least_change = 0.05;  // mm
constexpr double place_grid = 4.0;     // mm of border: changes nearer than this count as the same
// A segmented valve is half open and at rest in no state of the living one: its closed border may lie nearer to the papillary muscle than where it was
// segmented. A chorda may therefore start stretched by up to this share.
constexpr double stretch_most = 0.15;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// One leaflet as seen from a hole.
struct Flank {
  int leaflet = 0;
  bool has_border = false;
  double depth = 0;                       // mm below the annulus plane, mean of the border near the hole
  double arc = 0;                         // of the border point nearest to the hole
  std::vector<int> segments;              // whose ends lie near the hole
  double tension = 0;                     // N, largest of them
  double nearest = std::numeric_limits<double>::max();  // mm along the border from `arc` to the nearest chorda end
};

class View {
 public:
  View(const LeafletMesh& mesh, const LeafletChart& chart, const Annulus& annulus, const Chordae& chordae, const LayoutObservation& seen, const LayoutHole& hole,
       const LayoutRules& rules)
      : mesh_(mesh), chart_(chart), annulus_(annulus), chordae_(chordae), seen_(seen), hole_(hole), reach_(std::max(rules.reach, 1.5 * std::sqrt(hole.area))) {
    for (int leaflet : {static_cast<int>(anterior), static_cast<int>(posterior)}) sides_[leaflet] = look(leaflet);
  }
  const Flank& side(int leaflet) const { return sides_.at(leaflet); }

 private:
  // Distance across the annulus plane: a hole has no depth of its own.
  double across(const Vec3& x) const {
    const Vec3 d = x - hole_.place;
    return (d - annulus_.normal * annulus_.normal.dot(d)).norm();
  }
  double arc_of(const Vec3& rest) const {
    double best = std::numeric_limits<double>::max(), arc = 0;
    for (const auto& p : chart_.border())
      if (const double d = (p.position - rest).squaredNorm(); d < best) {
        best = d;
        arc = p.arc;
      }
    return arc;
  }
  double along_border(double a, double b) const {
    const double d = std::abs(a - b);
    return std::min(d, chart_.border_length() - d);
  }

  Flank look(int leaflet) const {
    Flank side;
    side.leaflet = leaflet;
    std::vector<char> is_there(mesh_.points.size(), 0);
    for (std::size_t e = 0; e < mesh_.tets.size(); ++e)
      if (mesh_.region[e] == leaflet)
        for (std::size_t k = 0; k < 4; ++k) is_there[at(mesh_.tets[e][k])] = 1;
    double closest = std::numeric_limits<double>::max(), sum = 0;
    int count = 0, nearest_node = -1;
    for (std::size_t i = 0; i < mesh_.points.size(); ++i) {
      if (!is_there[i] || !mesh_.on_free_edge[i] || mesh_.side[i] != atrial) continue;
      const double d = across(seen_.points[i]);
      if (const double whole = (seen_.points[i] - hole_.place).norm(); whole < closest) {
        closest = whole;
        nearest_node = static_cast<int>(i);
      }
      if (d > reach_) continue;
      sum += annulus_.normal.dot(seen_.points[i] - annulus_.origin);
      ++count;
    }
    if (nearest_node < 0) return side;
    side.has_border = count > 0;
    side.depth = count > 0 ? sum / count : annulus_.normal.dot(seen_.points[at(nearest_node)] - annulus_.origin);
    side.arc = arc_of(mesh_.points[at(nearest_node)]);
    find_segments(side);
    return side;
  }

  void find_segments(Flank& side) const {
    std::map<int, Vec3> moved, rest;
    for (const Insertion& i : chordae_.insertions) {
      moved.try_emplace(i.point, Vec3::Zero()).first->second += i.weight * seen_.points[at(i.node)];
      rest.try_emplace(i.point, Vec3::Zero()).first->second += i.weight * mesh_.points[at(i.node)];
    }
    for (std::size_t s = 0; s < chordae_.segments.size(); ++s) {
      const ChordaSegment& segment = chordae_.segments[s];
      const auto end = moved.find(segment.b);
      if (end == moved.end() || segment.leaflet != side.leaflet) continue;
      const bool is_border = segment.kind == ChordaKind::primary || segment.kind == ChordaKind::marginal;
      if (is_border) side.nearest = std::min(side.nearest, along_border(arc_of(rest.at(segment.b)), side.arc));
      if (across(end->second) > reach_) continue;
      side.segments.push_back(static_cast<int>(s));
      side.tension = std::max(side.tension, seen_.tension[s]);
    }
  }

  const LeafletMesh& mesh_;
  const LeafletChart& chart_;
  const Annulus& annulus_;
  const Chordae& chordae_;
  const LayoutObservation& seen_;
  const LayoutHole& hole_;
  double reach_;
  std::map<int, Flank> sides_;
};

const char* leaflet_name(int leaflet) { return leaflet == anterior ? "anterior" : leaflet == posterior ? "posterior" : "both"; }

}  // namespace

std::string LayoutChange::name() const {
  return fmt::format("{} {} at {:.0f} mm", action == add ? "add" : action == shorten ? "shorten" : "lengthen", leaflet_name(leaflet), std::round(arc / place_grid) * place_grid);
}

std::vector<LayoutChange> propose_changes(const LeafletMesh& mesh, const LeafletChart& chart, const Annulus& annulus, const Chordae& chordae, const LayoutObservation& seen,
                                          const LayoutHole& hole, const LayoutRules& rules) {
  const View view(mesh, chart, annulus, chordae, seen, hole, rules);
  const Flank &a = view.side(anterior), &p = view.side(posterior);
  std::vector<LayoutChange> out;
  const double by_area = std::clamp(std::sqrt(hole.area), rules.step_least, rules.step_most);
  const auto lengths = [&](LayoutChange::Action action, const Flank& side, double amount, const std::string& why) {
    if (!side.segments.empty()) out.push_back({action, side.leaflet, side.segments, std::clamp(amount, rules.step_least, rules.step_most), side.arc, why});
  };
  const auto both = [&](LayoutChange::Action action, double amount, const std::string& why) {
    LayoutChange change{action, 0, a.segments, std::clamp(amount, rules.step_least, rules.step_most), a.arc, why};
    change.segments.insert(change.segments.end(), p.segments.begin(), p.segments.end());
    if (!a.segments.empty() && !p.segments.empty()) out.push_back(change);
  };
  const auto addition = [&](const Flank& side, const std::string& why) {
    const LayoutChange change{LayoutChange::add, side.leaflet, {}, 0, side.arc, why};
    const bool is_new = std::none_of(out.begin(), out.end(), [&](const LayoutChange& c) { return c.name() == change.name(); });
    if (is_new && side.has_border && side.nearest > 0.5 * rules.far) out.push_back(change);
  };
  const double difference = a.depth - p.depth;
  if (a.has_border && p.has_border && std::abs(difference) > rules.level_difference) {
    const Flank &high = difference < 0 ? a : p, &low = difference < 0 ? p : a;
    const std::string why = fmt::format("{} border {:.1f} mm above the other", leaflet_name(high.leaflet), std::abs(difference));
    if (high.nearest > rules.far) addition(high, why + ", no chorda near");
    lengths(LayoutChange::shorten, high, 0.5 * std::abs(difference), why);
    addition(high, why);
    lengths(LayoutChange::lengthen, low, 0.5 * std::abs(difference), why);
    both(LayoutChange::shorten, by_area, why);
    both(LayoutChange::lengthen, by_area, why);
    return out;
  }
  const std::string why = fmt::format("borders at {:.1f} and {:.1f} mm, {:.2f} and {:.2f} N near", a.depth, p.depth, a.tension, p.tension);
  const Flank &tauter = a.tension > p.tension ? a : p, &slacker = a.tension > p.tension ? p : a;
  if (tauter.tension > rules.taut) {
    lengths(LayoutChange::lengthen, tauter, by_area, why + ": held back");
    both(LayoutChange::lengthen, by_area, why + ": held back");
    addition(slacker, why);
    lengths(LayoutChange::shorten, slacker, by_area, why);
    lengths(LayoutChange::shorten, tauter, by_area, why);
  } else {
    both(LayoutChange::shorten, by_area, why + ": not held");
    addition(slacker, why + ": not held");
    addition(tauter, why + ": not held");
    both(LayoutChange::lengthen, by_area, why);
  }
  return out;
}

bool change_lengths(Chordae& chordae, const LayoutChange& change) {
  bool has_changed = false;
  for (int s : change.segments) {
    ChordaSegment& segment = chordae.segments[at(s)];
    const double initial = (chordae.points[at(segment.a)] - chordae.points[at(segment.b)]).norm();
    const double wanted = segment.rest_length + (change.action == LayoutChange::shorten ? -change.amount : change.amount);
    const double length = std::max(wanted, std::min(initial / (1 + stretch_most), segment.rest_length));
    has_changed |= std::abs(length - segment.rest_length) > least_change;
    segment.rest_length = length;
  }
  return has_changed;
}

}  // namespace mv
