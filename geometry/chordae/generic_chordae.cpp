// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/generic_chordae.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr int struts = 2;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// One leaflet end of a chorda, before it becomes points and weights.
struct End {
  Vec2 centre_uv;  // middle of the influence sphere
  Vec2 end_uv;     // where the chorda ends
  double radius;
};

struct Chorda {
  ChordaKind kind;
  std::vector<End> ends;  // two when bifurcated
  bool is_at_junction = false;
};

// Border arc lengths of the primaries: one at each junction, the others one after another to the arcs whose chordae are furthest
// apart.
std::vector<double> primary_arcs(const LeafletChart& chart, int count) {
  const auto& junctions = chart.junctions();
  const int arcs = static_cast<int>(junctions.size());
  if (count == 0) return {};
  if (count < arcs)
    throw ConfigError("chordae.primary = " + std::to_string(count) + ": the valve has " + std::to_string(arcs) +
                      " commissures and notches, and each needs a chorda of its own; use 0 or at least " + std::to_string(arcs));
  std::vector<double> begin, length;
  for (int k = 0; k < arcs; ++k) {
    begin.push_back(chart.border()[at(junctions[at(k)].border_index)].arc);
    const double end = k + 1 < arcs ? chart.border()[at(junctions[at(k + 1)].border_index)].arc : chart.border_length();
    length.push_back(end - begin.back());
  }
  // Mirror images within a leaflet get their chordae together, so that the valve stays symmetric; a single one left goes to a
  // middle arc.
  struct Unit {
    std::vector<int> members;
    double length;
  };
  std::vector<Unit> units;
  std::vector<int> commissures;
  for (int k = 0; k < arcs; ++k)
    if (junctions[at(k)].is_commissure) commissures.push_back(k);
  commissures.push_back(arcs);
  for (std::size_t c = 0; c + 1 < commissures.size(); ++c)
    for (int low = commissures[c], high = commissures[c + 1] - 1; low <= high; ++low, --high) {
      if (low == high)
        units.push_back({{low}, length[at(low)]});
      else
        units.push_back({{low, high}, 0.5 * (length[at(low)] + length[at(high)])});
    }
  std::vector<int> inner(at(arcs), 0);
  for (int left = count - arcs; left > 0;) {
    const Unit* best = nullptr;
    double longest = 0;
    for (const Unit& u : units) {
      const double spacing = u.length / (inner[at(u.members[0])] + 1);
      if (static_cast<int>(u.members.size()) <= left && spacing > longest) {
        longest = spacing;
        best = &u;
      }
    }
    if (!best) {  // one left and every arc has a mirror image
      ++inner[at(units[0].members[0])];
      break;
    }
    for (int k : best->members)
      ++inner[at(k)];
    left -= static_cast<int>(best->members.size());
  }
  std::vector<double> sites;
  for (int k = 0; k < arcs; ++k)
    for (int i = 0; i <= inner[at(k)]; ++i)
      sites.push_back(begin[at(k)] + length[at(k)] * i / (inner[at(k)] + 1));
  return sites;
}

// The end lies `inset` mm inside the border, perpendicular to it on the pattern.
End border_end(const LeafletChart& chart, double arc, double radius_scale, const ChordaeOptions& options) {
  End end;
  end.centre_uv = chart.border_uv(arc);
  end.radius =
      radius_scale * options.radius.value_or(influence_radius(chart.border_length(), options.primary, end.centre_uv.y()));
  const double step = 0.25 * end.radius;
  Vec2 after = chart.border_uv(arc + step), before = chart.border_uv(arc - step);
  after.x() += chart.period() * std::round((end.centre_uv.x() - after.x()) / chart.period());
  before.x() += chart.period() * std::round((end.centre_uv.x() - before.x()) / chart.period());
  const Vec2 along = (after - before).normalized();
  end.end_uv = end.centre_uv + options.end_inset * end.radius * Vec2(along.y(), -along.x());
  return end;
}

std::vector<Chorda> place_primaries(const LeafletChart& chart, const ChordaeOptions& options) {
  const std::vector<double> arcs = primary_arcs(chart, options.primary);
  std::vector<Chorda> placed;
  const double share = chart.border_length() / std::max(options.primary, 1);
  std::set<double> junctions;
  for (const auto& j : chart.junctions())
    junctions.insert(chart.border()[at(j.border_index)].arc);
  for (double arc : arcs) {
    Chorda c{ChordaKind::primary, {}, junctions.count(arc) > 0};
    if (options.bifurcated) {
      c.ends = {border_end(chart, arc - 0.25 * share, 0.5, options), border_end(chart, arc + 0.25 * share, 0.5, options)};
    } else {
      c.ends = {border_end(chart, arc, 1.0, options)};
    }
    placed.push_back(c);
  }
  return placed;
}

End belly_end(const LeafletChart& chart, double u, double height_share, const ChordaeOptions& options) {
  const Vec2 uv(u, height_share * chart.height(u));
  return {uv, uv, options.radius.value_or(influence_radius(chart.border_length(), std::max(options.primary, 1), uv.y()))};
}

std::vector<Chorda> place_secondaries(const LeafletChart& chart, const ClosedShape& closed, const ChordaeOptions& options) {
  std::vector<Chorda> placed;
  const int in_anterior = std::min(struts, options.secondary);
  const double width = closed.commissure_u(1) - closed.commissure_u(0), middle = closed.commissure_u(0) + 0.5 * width;
  for (int i = 0; i < in_anterior; ++i) {
    const double offset = in_anterior == 1 ? 0.0 : (i == 0 ? -1.0 : 1.0) * options.strut_spread * width;
    placed.push_back({ChordaKind::secondary, {belly_end(chart, middle + offset, options.strut_height, options)}, false});
  }
  std::vector<double> cuts;  // u of the junctions along the posterior leaflet
  for (const auto& j : chart.junctions())
    if (chart.border()[at(j.border_index)].region != anterior) cuts.push_back(chart.border()[at(j.border_index)].uv.x());
  cuts.push_back(closed.commissure_u(0) + chart.period());
  const int scallops = static_cast<int>(cuts.size()) - 1, in_posterior = options.secondary - in_anterior;
  // An odd surplus goes to the middle scallop first, the rest in pairs from the outside, so that the valve stays symmetric.
  std::vector<int> count(at(scallops), in_posterior / scallops);
  int surplus = in_posterior % scallops;
  if (surplus % 2 == 1) {
    ++count[at(scallops / 2)];
    --surplus;
  }
  for (int k = 0; surplus > 0; ++k, surplus -= 2) {
    ++count[at(k)];
    ++count[at(scallops - 1 - k)];
  }
  for (int k = 0; k < scallops; ++k)
    for (int i = 0; i < count[at(k)]; ++i) {
      const double u = cuts[at(k)] + (cuts[at(k + 1)] - cuts[at(k)]) * (i + 0.5) / count[at(k)];
      placed.push_back({ChordaKind::secondary, {belly_end(chart, u, options.posterior_height, options)}, false});
    }
  return placed;
}

// Which half of the valve (0: near the first commissure, 1: near the second) each tip belongs to.
std::vector<int> halves_of_tips(const LeafletChart& chart, const ClosedShape& closed, const Papillary& papillary) {
  const Vec3 first = chart.at({closed.commissure_u(0), 0}).position, second = chart.at({closed.commissure_u(1), 0}).position;
  const Vec3 axis = (second - first).normalized();
  std::vector<double> along;
  for (const Vec3& tip : papillary.tips)
    along.push_back((tip - first).dot(axis));
  const double middle = 0.5 * (*std::min_element(along.begin(), along.end()) + *std::max_element(along.begin(), along.end()));
  std::vector<int> half;
  for (double a : along)
    half.push_back(a > middle ? 1 : 0);
  if (*std::max_element(along.begin(), along.end()) - *std::min_element(along.begin(), along.end()) < 1e-3)
    throw InputError(
        "chordae: the papillary tips do not lie on different sides of the valve (along the line between the commissures)");
  return half;
}

int nearest_tip(const Papillary& papillary, const std::vector<int>& half_of_tip, int half, const Vec3& place) {
  int best = -1;
  for (std::size_t t = 0; t < papillary.tips.size(); ++t)
    if (half_of_tip[t] == half && (best < 0 || (papillary.tips[t] - place).norm() < (papillary.tips[at(best)] - place).norm()))
      best = static_cast<int>(t);
  return best;
}

// Adds points, segments and insertions of one chorda after another.
class Builder {
 public:
  Builder(const LeafletMesh& mesh, const LeafletChart& chart, const ClosedShape& closed, const Papillary& papillary,
          const ChordaeOptions& options)
      : graph_(mesh),
        chart_(chart),
        closed_(closed),
        papillary_(papillary),
        options_(options),
        half_of_tip_(halves_of_tips(chart, closed, papillary)) {}

  void add(const Chorda& chorda) {
    std::vector<int> ends;
    std::vector<Vec3> places;
    for (const End& e : chorda.ends) {
      ends.push_back(add_end(e));
      places.push_back(closed_.at(e.end_uv));
    }
    const Vec3 place = places.size() == 1 ? places[0] : Vec3(0.5 * (places[0] + places[1]));
    const double s = closed_.fraction(chorda.ends.size() == 1 ? chorda.ends[0].end_uv.x() : middle_u(chorda));
    std::vector<int> sides{s > 0.5 ? 1 : 0};
    if (std::abs(s - 0.5) < options_.midline_band) sides = {0, 1};
    for (int side : sides) {
      const int tip = nearest_tip(papillary_, half_of_tip_, side, place);
      const double whole_area = chorda.kind == ChordaKind::primary ? options_.area_primary : options_.area_secondary;
      const double area = whole_area / static_cast<double>(sides.size());
      if (ends.size() == 1) {
        add_segment(root(tip), ends[0], chorda, 0, tip, area, papillary_.tips[at(tip)], places[0]);
      } else {
        add_branched(tip, ends, places, chorda, area);
      }
    }
  }

  Chordae take() { return std::move(out_); }

 private:
  // The two ends of a bifurcated chorda may lie on different images of the pattern.
  double middle_u(const Chorda& c) const {
    const double a = c.ends[0].end_uv.x(), period = chart_.period();
    const double b = c.ends[1].end_uv.x() - period * std::round((c.ends[1].end_uv.x() - a) / period);
    return 0.5 * (a + b);
  }

  int add_point(const Vec3& position, int muscle) {
    out_.points.push_back(position);
    out_.muscle_of_point.push_back(muscle);
    return static_cast<int>(out_.points.size()) - 1;
  }

  int root(int tip) {
    const auto [it, is_new] = roots_.try_emplace(tip, -1);
    if (is_new) it->second = add_point(papillary_.tips[at(tip)], tip);
    return it->second;
  }

  // The asked place is kept along the leaflet; through the thickness the end stays at the centroid of the sphere, which on a
  // curved leaflet lies off the mid-surface, so that the correction does not favour one face.
  int add_end(const End& e) {
    const auto centre = chart_.at(e.centre_uv), place = chart_.at(e.end_uv);
    const InfluenceSphere plain = influence_sphere(graph_, centre.position, e.radius);
    const Vec3 end = place.position + place.normal * place.normal.dot(plain.end - place.position);
    const InfluenceSphere sphere = influence_sphere(graph_, centre.position, e.radius, end);
    const int point = add_point(sphere.end, -1);
    for (const auto& [node, weight] : sphere.weights)
      out_.insertions.push_back({point, node, weight});
    return point;
  }

  void add_segment(int a, int b, const Chorda& chorda, std::size_t end, int tip, double area, const Vec3& closed_a,
                   const Vec3& closed_b) {
    ChordaSegment s;
    s.a = a;
    s.b = b;
    s.kind = chorda.kind;
    s.muscle = tip;
    s.leaflet = closed_.is_anterior(chorda.ends[end].end_uv.x()) ? anterior : posterior;
    s.area = area;
    const double initial = (out_.points[at(a)] - out_.points[at(b)]).norm();
    const double slack = options_.slack * (chorda.is_at_junction ? options_.junction_slack : 1.0);
    s.rest_length = std::max(slack * (closed_a - closed_b).norm(), initial);
    out_.segments.push_back(s);
  }

  void add_branched(int tip, const std::vector<int>& ends, const std::vector<Vec3>& places, const Chorda& chorda, double area) {
    const Vec3& from = papillary_.tips[at(tip)];
    const Vec3 middle = 0.5 * (out_.points[at(ends[0])] + out_.points[at(ends[1])]);
    const Vec3 closed_branch = from + options_.branch_at * (0.5 * (places[0] + places[1]) - from);
    const int branch = add_point(from + options_.branch_at * (middle - from), -1);
    add_segment(root(tip), branch, chorda, 0, tip, area, from, closed_branch);
    for (std::size_t k = 0; k < ends.size(); ++k)
      add_segment(branch, ends[k], chorda, k, tip, area / static_cast<double>(ends.size()), closed_branch, places[k]);
  }

  LeafletGraph graph_;
  const LeafletChart& chart_;
  const ClosedShape& closed_;
  const Papillary& papillary_;
  const ChordaeOptions& options_;
  std::vector<int> half_of_tip_;
  std::map<int, int> roots_;
  Chordae out_;
};

}  // namespace

Chordae generic_chordae(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary,
                        const ChordaeOptions& options) {
  if (options.primary < 0 || options.secondary < 0)
    throw ConfigError("chordae.primary and chordae.secondary must not be negative");
  if (!(options.slack > 0) || !(options.junction_slack > 0))
    throw ConfigError("chordae: slack and junction_slack must be positive, got " + std::to_string(options.slack) + " and " +
                      std::to_string(options.junction_slack));
  if (papillary.tips.size() < 2)
    throw InputError("chordae: two papillary tips are needed, got " + std::to_string(papillary.tips.size()));
  const LeafletChart chart(mesh);
  const ClosedShape closed(chart, annulus.normal, options.coaptation_depth);
  std::vector<Chorda> chordae = place_primaries(chart, options);
  for (Chorda& c : place_secondaries(chart, closed, options))
    chordae.push_back(std::move(c));
  const std::set<int> removed(options.removed.begin(), options.removed.end());
  for (int index : removed)
    if (index < 0 || at(index) >= chordae.size())
      throw ConfigError("chordae.removed: " + std::to_string(index) + " is not one of the " + std::to_string(chordae.size()) +
                        " chordae (0 to " + std::to_string(static_cast<int>(chordae.size()) - 1) + ")");
  Builder builder(mesh, chart, closed, papillary, options);
  for (std::size_t k = 0; k < chordae.size(); ++k)
    if (!removed.count(static_cast<int>(k))) builder.add(chordae[k]);
  return builder.take();
}

double largest_border_gap(const LeafletChart& chart, const Chordae& chordae) {
  std::set<int> ends;
  for (const ChordaSegment& s : chordae.segments)
    if (s.kind == ChordaKind::primary) ends.insert(s.b);
  for (const ChordaSegment& s : chordae.segments)
    ends.erase(s.a);
  std::vector<double> arcs;
  for (int e : ends) {
    double best = std::numeric_limits<double>::max(), arc = 0;
    for (const auto& p : chart.border())
      if (const double d = (p.position - chordae.points[at(e)]).norm(); d < best) {
        best = d;
        arc = p.arc;
      }
    arcs.push_back(arc);
  }
  if (arcs.empty()) return chart.border_length();
  std::sort(arcs.begin(), arcs.end());
  double gap = arcs.front() + chart.border_length() - arcs.back();
  for (std::size_t i = 1; i < arcs.size(); ++i)
    gap = std::max(gap, arcs[i] - arcs[i - 1]);
  return gap;
}

}  // namespace mv
