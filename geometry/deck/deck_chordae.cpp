// SPDX-License-Identifier: GPL-3.0-or-later
// Trusses of a deck as trees: oriented from the papillary roots to the leaflet ends, runs without a branch merged.
#include "geometry/deck/deck_chordae.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <deque>
#include <set>

#include "geometry/core/errors.h"

namespace mv {
namespace {

struct Truss {
  int a, b;  // chorda points
  double length, area;
  std::string material;
};

struct Network {
  std::vector<Vec3> points;
  std::vector<int> node, leaflet_point, tip;
  std::vector<Truss> trusses;
  std::vector<std::vector<int>> at;  // trusses at a point
};

/// Roots at one place are one tip.
int tip_at(DeckValve& valve, const Vec3& x, const Vec3& displacement) {
  constexpr double same = 1e-6;
  for (std::size_t t = 0; t < valve.tips.size(); ++t)
    if ((valve.tips[t] - x).norm() < same && (valve.tip_displacement[t] - displacement).norm() < same) return static_cast<int>(t);
  valve.tips.push_back(x);
  valve.tip_displacement.push_back(displacement);
  return static_cast<int>(valve.tips.size()) - 1;
}

Network network_of(const AbaqusDeck& deck, const DeckUnits& units, const std::vector<int>& point_of, const std::vector<int>& section, const std::map<int, Vec3>& held,
                   DeckValve& valve) {
  Network net;
  std::map<int, int> index;
  auto point = [&](int node) {
    const auto [entry, is_new] = index.try_emplace(node, static_cast<int>(net.points.size()));
    if (is_new) {
      net.points.push_back(units.length * deck.nodes[static_cast<std::size_t>(node)]);
      net.node.push_back(node);
      net.leaflet_point.push_back(point_of[static_cast<std::size_t>(node)]);
      const auto h = held.find(node);
      net.tip.push_back(h != held.end() && net.leaflet_point.back() < 0 ? tip_at(valve, net.points.back(), h->second) : -1);
      net.at.emplace_back();
    }
    return entry->second;
  };
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    const DeckElement& element = deck.elements[e];
    const auto kind = deck_element_type(element.type)->kind;
    if (kind == DeckElementType::Kind::connector) {
      valve.notes.push_back(fmt::format("element {} ({}) is not taken over", element.label, element.type));
      continue;
    }
    if (kind != DeckElementType::Kind::truss && kind != DeckElementType::Kind::beam) continue;
    if (section[e] < 0) deck.lines.fail(element.place, fmt::format("{} element {} has no section; expected *SOLID SECTION with its area", element.type, element.label));
    const DeckSection& own = deck.sections[static_cast<std::size_t>(section[e])];
    const double area = own.size * units.length * units.length;
    if (!(area > 0)) deck.lines.fail(own.place, fmt::format("the section of {} element {} has no cross-section", element.type, element.label));
    Truss truss{point(element.nodes.front()), point(element.nodes[1]), 0, area, own.material};
    truss.length = (net.points[static_cast<std::size_t>(truss.b)] - net.points[static_cast<std::size_t>(truss.a)]).norm();
    if (!(truss.length > 0)) deck.lines.fail(element.place, fmt::format("{} element {} has no length", element.type, element.label));
    net.at[static_cast<std::size_t>(truss.a)].push_back(static_cast<int>(net.trusses.size()));
    net.at[static_cast<std::size_t>(truss.b)].push_back(static_cast<int>(net.trusses.size()));
    net.trusses.push_back(truss);
  }
  return net;
}

/// Points where a chorda ends, branches, or changes its section.
bool is_joint(const Network& net, int p) {
  const auto i = static_cast<std::size_t>(p);
  if (net.tip[i] >= 0 || net.leaflet_point[i] >= 0 || net.at[i].size() != 2) return true;
  const Truss &first = net.trusses[static_cast<std::size_t>(net.at[i][0])], &second = net.trusses[static_cast<std::size_t>(net.at[i][1])];
  return first.area != second.area || first.material != second.material;
}

}  // namespace

void collect_chordae(const AbaqusDeck& deck, const DeckValveOptions& options, const DeckUnits& units, const std::vector<int>& point_of, const std::vector<int>& section,
                     const std::map<int, Vec3>& held, DeckValve& valve) {
  const Network net = network_of(deck, units, point_of, section, held, valve);
  if (net.trusses.empty()) return;
  DeckChordae& out = valve.chordae;
  std::vector<int> name(net.points.size(), -1);
  auto point = [&](int p) {
    int& n = name[static_cast<std::size_t>(p)];
    if (n < 0) {
      n = static_cast<int>(out.points.size());
      out.points.push_back(net.points[static_cast<std::size_t>(p)]);
      out.tip_of_point.push_back(net.tip[static_cast<std::size_t>(p)]);
      out.leaflet_point.push_back(net.leaflet_point[static_cast<std::size_t>(p)]);
    }
    return n;
  };
  // Breadth first from the roots, so that every segment starts nearer to its root.
  std::deque<std::pair<int, int>> queue;  // point, tip
  std::vector<char> is_reached(net.points.size(), 0), is_used(net.trusses.size(), 0);
  for (std::size_t p = 0; p < net.points.size(); ++p)
    if (net.tip[p] >= 0) queue.emplace_back(static_cast<int>(p), net.tip[p]), is_reached[p] = 1;
  if (queue.empty())
    throw InputError(deck.lines.files[0].string() + ": no end of a chorda is held; expected the papillary roots to be held by *BOUNDARY (three displacements each)");
  while (!queue.empty()) {
    const auto [start, tip] = queue.front();
    queue.pop_front();
    for (const int first : net.at[static_cast<std::size_t>(start)]) {
      if (is_used[static_cast<std::size_t>(first)]) continue;
      DeckChordae::Segment segment{point(start), -1, 0, net.trusses[static_cast<std::size_t>(first)].area, 0, tip, net.trusses[static_cast<std::size_t>(first)].material};
      int at = start, along = first;
      while (true) {
        const Truss& truss = net.trusses[static_cast<std::size_t>(along)];
        is_used[static_cast<std::size_t>(along)] = 1;
        segment.rest_length += truss.length;
        at = truss.a == at ? truss.b : truss.a;
        if (!options.merge_chains || is_joint(net, at)) break;
        const auto& both = net.at[static_cast<std::size_t>(at)];
        const int next = both[0] == along ? both[1] : both[0];
        if (is_used[static_cast<std::size_t>(next)]) break;
        along = next;
      }
      segment.b = point(at);
      out.segments.push_back(segment);
      // A leaflet end may have further trusses of its own, e.g. a fan that spreads along the leaflet; the walk goes on through it.
      if (!is_reached[static_cast<std::size_t>(at)]) is_reached[static_cast<std::size_t>(at)] = 1, queue.emplace_back(at, tip);
    }
  }
  for (std::size_t t = 0; t < net.trusses.size(); ++t)
    if (!is_used[t]) {
      const Vec3& x = net.points[static_cast<std::size_t>(net.trusses[t].a)];
      throw InputError(fmt::format("{}: chordae at node {} ({:.2f}, {:.2f}, {:.2f}) mm hang on no held root; hold the root by *BOUNDARY or remove them", deck.lines.files[0].string(),
                                   deck.node_labels[static_cast<std::size_t>(net.node[static_cast<std::size_t>(net.trusses[t].a)])], x.x(), x.y(), x.z()));
    }
  // Dead ends carry nothing: drop them from the ends up.
  std::vector<int> uses(out.points.size(), 0);
  for (const auto& s : out.segments) ++uses[static_cast<std::size_t>(s.a)], ++uses[static_cast<std::size_t>(s.b)];
  std::size_t dropped = 0;
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    std::erase_if(out.segments, [&](const DeckChordae::Segment& s) {
      const auto b = static_cast<std::size_t>(s.b), a = static_cast<std::size_t>(s.a);
      if (out.leaflet_point[b] >= 0 || out.tip_of_point[b] >= 0 || uses[b] > 1) return false;
      --uses[a], --uses[b], ++dropped;
      return is_changed = true;
    });
  }
  if (dropped > 0) valve.notes.push_back(fmt::format("{} chordae that end in the open were left out", dropped));
  // Leaflet of a segment: by its end, from the ends up to the roots.
  std::vector<int> region_of_point(valve.points.size(), 0), region_of_end(out.points.size(), 0);
  for (std::size_t t = 0; t < valve.triangles.size(); ++t)
    for (const int p : valve.triangles[t]) region_of_point[static_cast<std::size_t>(p)] = valve.region[t];
  for (std::size_t p = 0; p < out.points.size(); ++p)
    if (out.leaflet_point[p] >= 0) region_of_end[p] = region_of_point[static_cast<std::size_t>(out.leaflet_point[p])];
  for (auto s = out.segments.rbegin(); s != out.segments.rend(); ++s) {
    s->leaflet = region_of_end[static_cast<std::size_t>(s->b)];
    if (int& above = region_of_end[static_cast<std::size_t>(s->a)]; above == 0) above = s->leaflet;
  }
}

Chordae hang_chordae(const DeckValve& valve, const LeafletMesh& mesh, int layers) {
  const DeckChordae& in = valve.chordae;
  const std::size_t columns = valve.points.size();
  if (mesh.points.size() < columns * static_cast<std::size_t>(layers + 1))
    throw InputError(fmt::format("leaflets.vtu has {} points, {} or more were expected from the deck's {} nodes; run all stages again", mesh.points.size(), columns * static_cast<std::size_t>(layers + 1), columns));
  std::vector<double> volume(mesh.points.size(), 0.0);
  for (const auto& tet : mesh.tets) {
    const Vec3& a = mesh.points[static_cast<std::size_t>(tet[0])];
    const double v = (mesh.points[static_cast<std::size_t>(tet[1])] - a).cross(mesh.points[static_cast<std::size_t>(tet[2])] - a).dot(mesh.points[static_cast<std::size_t>(tet[3])] - a) / 24;
    for (std::size_t c = 0; c < 4; ++c) volume[static_cast<std::size_t>(tet[c])] += v;
  }
  const std::set<int> edge(valve.free_edge.begin(), valve.free_edge.end());
  Chordae out;
  out.points = in.points;
  out.muscle_of_point = in.tip_of_point;
  for (std::size_t p = 0; p < in.points.size(); ++p) {
    if (in.leaflet_point[p] < 0) continue;
    double sum = 0;
    Vec3 end = Vec3::Zero();
    for (int level = 0; level <= layers; ++level) sum += volume[static_cast<std::size_t>(level) * columns + static_cast<std::size_t>(in.leaflet_point[p])];
    for (int level = 0; level <= layers; ++level) {
      const std::size_t node = static_cast<std::size_t>(level) * columns + static_cast<std::size_t>(in.leaflet_point[p]);
      out.insertions.push_back({static_cast<int>(p), static_cast<int>(node), volume[node] / sum});
      end += volume[node] / sum * mesh.points[node];
    }
    out.points[p] = end;
  }
  for (const DeckChordae::Segment& s : in.segments) {
    const int end = in.leaflet_point[static_cast<std::size_t>(s.b)];
    out.segments.push_back({s.a, s.b, end >= 0 && edge.contains(end) ? ChordaKind::primary : ChordaKind::secondary, std::max(s.tip, 0), s.leaflet, s.rest_length, s.area});
  }
  // A segment above a branch is primary when one below it is.
  std::vector<char> leads_to_edge(out.points.size(), 0);
  for (auto s = out.segments.rbegin(); s != out.segments.rend(); ++s) {
    if (leads_to_edge[static_cast<std::size_t>(s->b)]) s->kind = ChordaKind::primary;
    if (s->kind == ChordaKind::primary) leads_to_edge[static_cast<std::size_t>(s->a)] = 1;
  }
  return out;
}

}  // namespace mv
