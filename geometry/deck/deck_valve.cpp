// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/deck_valve.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/deck/deck_chordae.h"

namespace mv {
namespace {

using Kind = DeckElementType::Kind;

std::string file_of(const AbaqusDeck& deck) { return deck.lines.files[0].string(); }

int region_named(const std::string& name) {
  for (const NamedRegion& leaflet : leaflet_names)
    if (name == leaflet.name) return leaflet.region;
  return 0;
}

/// Region of each shell element, 0 for what is no shell.
std::vector<int> regions_of(const AbaqusDeck& deck, const DeckValveOptions& options, const std::vector<char>& is_shell) {
  std::vector<int> region(deck.elements.size(), 0);
  auto give = [&](const std::vector<int>& elements, int leaflet, const std::string& set) {
    for (const int e : elements) {
      int& r = region[static_cast<std::size_t>(e)];
      if (!is_shell[static_cast<std::size_t>(e)]) continue;
      if (r != 0 && r != leaflet)
        throw InputError(fmt::format("{}: element {} of set '{}' belongs to two leaflets; name disjoint sets by deck.leaflets", file_of(deck),
                                     deck.elements[static_cast<std::size_t>(e)].label, set));
      r = leaflet;
    }
  };
  for (const std::string& entry : options.leaflets) {
    const auto equals = entry.find('=');
    const int leaflet = equals == std::string::npos ? 0 : region_named(deck_name(entry.substr(0, equals)));
    if (leaflet == 0) throw ConfigError("key 'deck.leaflets': '" + entry + "': expected NAME=SET with NAME anterior, posterior or septal");
    const std::string set = deck_name(entry.substr(equals + 1));
    const auto found = deck.element_sets.find(set);
    if (found == deck.element_sets.end()) throw ConfigError("key 'deck.leaflets': the deck has no element set '" + set + "'");
    give(found->second, leaflet, set);
  }
  if (options.leaflets.empty())
    for (const auto& [set, elements] : deck.element_sets)
      for (const NamedRegion& leaflet : leaflet_names)
        if (set.find(leaflet.name) != std::string::npos) give(elements, leaflet.region, set);
  for (std::size_t e = 0; e < region.size(); ++e)
    if (is_shell[e] && region[e] == 0)
      throw InputError(fmt::format("{}: shell element {} belongs to no leaflet; name the element sets by deck.leaflets = [\"anterior=SET\", ...]", file_of(deck), deck.elements[e].label));
  return region;
}

/// Border loops as closed lists of points, in the direction of the triangles' edges.
std::vector<std::vector<int>> border_loops(const AbaqusDeck& deck, const DeckValve& valve) {
  std::map<std::pair<int, int>, int> count;
  for (const auto& t : valve.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (++count[{t[k], t[(k + 1) % 3]}] > 1)
        throw InputError(fmt::format("{}: the leaflets are not consistently oriented at nodes {} and {}: two elements run along their edge in the same direction; turn one of them",
                                     file_of(deck), valve.labels[static_cast<std::size_t>(t[k])], valve.labels[static_cast<std::size_t>(t[(k + 1) % 3])]));
  std::map<int, int> next;
  for (const auto& [edge, times] : count) {
    if (count.contains({edge.second, edge.first})) continue;
    if (!next.try_emplace(edge.first, edge.second).second)
      throw InputError(fmt::format("{}: the leaflets' borders touch at node {}", file_of(deck), valve.labels[static_cast<std::size_t>(edge.first)]));
  }
  std::vector<std::vector<int>> loops;
  std::set<int> done;
  for (const auto& [start, ignored] : next) {
    if (done.contains(start)) continue;
    std::vector<int> loop;
    for (int at = start; done.insert(at).second; at = next.at(at)) loop.push_back(at);
    loops.push_back(std::move(loop));
  }
  return loops;
}

double share_of(const std::vector<int>& loop, const std::vector<char>& marked) {
  double hits = 0;
  for (const int p : loop) hits += marked[static_cast<std::size_t>(p)] ? 1 : 0;
  return hits / static_cast<double>(loop.size());
}

struct Held {
  Vec3 displacement = Vec3::Zero();
  std::string amplitude;
  int freedoms = 0;
};

/// Nodes with all three displacements prescribed in the last step that says something about them.
std::map<int, Held> held_nodes(const AbaqusDeck& deck, double unit) {
  std::map<int, Held> held;
  for (const DeckBoundary& b : deck.boundaries) {
    if (b.freedom > 3) continue;
    Held& h = held[b.node];
    h.displacement[b.freedom - 1] = unit * b.value;
    h.freedoms |= 1 << (b.freedom - 1);
    if (b.value != 0) h.amplitude = b.amplitude;
  }
  std::erase_if(held, [](const auto& entry) { return entry.second.freedoms != 7; });
  return held;
}

Vec3 fibre_of(const AbaqusDeck& deck, const DeckElement& element, const DeckOrientation& orientation, const Vec3& normal) {
  const auto own = orientation.elements.find(element.label);
  const DeckAxes& axes = own == orientation.elements.end() ? orientation.axes : own->second;
  // Local 1 is the direction a, then turned about an axis, projected on the shell.
  Vec3 x = axes.a.normalized();
  Vec3 z = x.cross(axes.b);
  if (!(z.norm() > 1e-9)) deck.lines.fail(orientation.place, fmt::format("the two vectors of element {}'s orientation are parallel", element.label));
  z.normalize();
  const Vec3 y = z.cross(x);
  if (orientation.axis > 0 && orientation.angle != 0) {
    const Vec3 about = orientation.axis == 1 ? x : orientation.axis == 2 ? y : z;
    x = Eigen::AngleAxisd(orientation.angle * std::acos(-1.0) / 180, about) * x;
  }
  Vec3 tangent = x - x.dot(normal) * normal;
  return tangent.norm() > 1e-6 ? Vec3(tangent.normalized()) : Vec3(Vec3::Zero());
}

}  // namespace

DeckUnits DeckUnits::named(const std::string& name) {
  if (name == "mm-tonne-s") return {1, 1e6, 1e12};
  if (name == "mm-g-s") return {1, 1, 1e6};
  if (name == "m-kg-s") return {1e3, 1, 1};
  throw ConfigError("key 'deck.units': '" + name + "': expected mm-tonne-s, mm-g-s or m-kg-s");
}

DeckValve build_deck_valve(const AbaqusDeck& deck, const DeckValveOptions& options) {
  const DeckUnits units = DeckUnits::named(options.units);
  DeckValve valve;
  valve.notes = deck.notes;
  std::vector<char> is_shell(deck.elements.size(), 0);
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    const Kind kind = deck_element_type(deck.elements[e].type)->kind;
    is_shell[e] = kind == Kind::shell || kind == Kind::membrane;
    if (kind == Kind::solid)
      throw InputError(fmt::format("{}: element {} is a {}: leaflets of solid elements are not understood, expected shells or membranes (a closed thick leaflet goes in by mvprep surface)",
                                   file_of(deck), deck.elements[e].label, deck.elements[e].type));
  }
  if (std::none_of(is_shell.begin(), is_shell.end(), [](char c) { return c != 0; })) throw InputError(file_of(deck) + ": no shells or membranes; expected the leaflets as such");
  const std::vector<int> region = regions_of(deck, options, is_shell);
  const std::vector<int> section = deck.section_of_element();

  // Which side is the ventricle: pressure acts against the face it is put on.
  std::vector<int> side(deck.elements.size(), 0);
  const int steps = static_cast<int>(deck.steps.size());
  for (const DeckPressure& p : deck.pressures) {
    if (p.step != steps - 1 && p.step >= 0 && steps > 1) continue;
    for (const int e : p.elements)
      if (is_shell[static_cast<std::size_t>(e)]) side[static_cast<std::size_t>(e)] = p.value >= 0 ? p.side : -p.side;
    valve.pressure = std::abs(p.value) * units.stress;
    valve.pressure_amplitude = p.amplitude.empty() ? DeckAmplitude{} : deck.amplitudes.at(p.amplitude);
  }
  int ventricle_side = 0;
  for (std::size_t e = 0; e < side.size(); ++e) {
    if (side[e] == 0) continue;
    if (ventricle_side != 0 && side[e] != ventricle_side)
      throw InputError(fmt::format("{}: the pressure acts on both sides of the leaflets (element {}); expected all elements' normals on one side", file_of(deck), deck.elements[e].label));
    ventricle_side = side[e];
  }
  if (ventricle_side == 0) {
    ventricle_side = 1;
    valve.notes.push_back("the deck has no pressure: the side of the elements' normals is taken as the ventricle");
  }
  if (!deck.steps.empty()) valve.period = deck.steps.back().period;

  // Mid-surface: the nodes of shells, in the deck's order.
  std::vector<int> point_of(deck.nodes.size(), -1);
  for (std::size_t e = 0; e < deck.elements.size(); ++e)
    if (is_shell[e])
      for (int c = 0; c < deck.elements[e].corners(); ++c) point_of[static_cast<std::size_t>(deck.elements[e].nodes[static_cast<std::size_t>(c)])] = 0;
  for (std::size_t n = 0; n < deck.nodes.size(); ++n) {
    if (point_of[n] < 0) continue;
    point_of[n] = static_cast<int>(valve.points.size());
    valve.points.push_back(units.length * deck.nodes[n]);
    valve.labels.push_back(deck.node_labels[n]);
  }
  bool has_fibres = true;
  std::vector<double> thickness_sum(valve.points.size(), 0.0), thickness_count(valve.points.size(), 0.0);
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    if (!is_shell[e]) continue;
    const DeckElement& element = deck.elements[e];
    std::vector<int> corner;
    for (int c = 0; c < element.corners(); ++c) corner.push_back(point_of[static_cast<std::size_t>(element.nodes[static_cast<std::size_t>(c)])]);
    // Abaqus' normal follows the right hand; the atrial side is the other one when the ventricle is at the normal.
    if (ventricle_side > 0) std::reverse(corner.begin(), corner.end());
    std::vector<std::array<int, 3>> pieces;
    if (corner.size() == 3) {
      pieces.push_back({corner[0], corner[1], corner[2]});
    } else {
      auto gap = [&](int a, int b) { return (valve.points[static_cast<std::size_t>(corner[static_cast<std::size_t>(a)])] - valve.points[static_cast<std::size_t>(corner[static_cast<std::size_t>(b)])]).norm(); };
      if (gap(0, 2) <= gap(1, 3)) pieces = {{corner[0], corner[1], corner[2]}, {corner[0], corner[2], corner[3]}};
      else pieces = {{corner[0], corner[1], corner[3]}, {corner[1], corner[2], corner[3]}};
    }
    const DeckSection* const own = section[e] < 0 ? nullptr : &deck.sections[static_cast<std::size_t>(section[e])];
    const double thickness = own && own->size > 0 ? units.length * own->size : options.thickness;
    for (const int c : corner) thickness_sum[static_cast<std::size_t>(c)] += thickness, thickness_count[static_cast<std::size_t>(c)] += 1;
    for (const auto& piece : pieces) {
      const Vec3 &a = valve.points[static_cast<std::size_t>(piece[0])], &b = valve.points[static_cast<std::size_t>(piece[1])], &c = valve.points[static_cast<std::size_t>(piece[2])];
      const Vec3 normal = (b - a).cross(c - a);
      if (!(normal.norm() > 0)) deck.lines.fail(element.place, fmt::format("element {} has no area", element.label));
      valve.triangles.push_back(piece);
      valve.region.push_back(region[e]);
      const bool is_oriented = own && !own->orientation.empty();
      has_fibres = has_fibres && is_oriented;
      valve.fibre.push_back(is_oriented ? fibre_of(deck, element, deck.orientations.at(own->orientation), normal.normalized()) : Vec3(Vec3::Zero()));
    }
  }
  if (!has_fibres) valve.fibre.clear();
  for (std::size_t i = 0; i < valve.points.size(); ++i) {
    valve.thickness.push_back(thickness_sum[i] / thickness_count[i]);
    valve.has_uniform_thickness = valve.has_uniform_thickness && std::abs(valve.thickness[i] - valve.thickness[0]) < 1e-9;
  }

  const std::map<int, Held> held = held_nodes(deck, units.length);
  std::vector<char> is_held(valve.points.size(), 0);
  for (const auto& [node, ignored] : held)
    if (point_of[static_cast<std::size_t>(node)] >= 0) is_held[static_cast<std::size_t>(point_of[static_cast<std::size_t>(node)])] = 1;
  auto loops = border_loops(deck, valve);
  if (loops.size() != 2)
    throw InputError(fmt::format("{}: the leaflets have {} borders, expected two (annulus and free edge) of one ring; are parts not joined, or nodes at their seams not shared?", file_of(deck), loops.size()));
  if (share_of(loops[0], is_held) < share_of(loops[1], is_held)) std::swap(loops[0], loops[1]);
  constexpr double enough = 0.9;
  if (share_of(loops[0], is_held) < enough || share_of(loops[1], is_held) > 1 - enough)
    throw InputError(fmt::format("{}: boundary conditions hold {:.0f} % of one border and {:.0f} % of the other; expected the annulus to be held (three displacements each, *BOUNDARY) and the free edge "
                                 "to be free", file_of(deck), 100 * share_of(loops[0], is_held), 100 * share_of(loops[1], is_held)));
  valve.annulus = loops[0];
  valve.free_edge = loops[1];
  std::vector<int> node_of(valve.points.size());
  for (std::size_t n = 0; n < point_of.size(); ++n)
    if (point_of[n] >= 0) node_of[static_cast<std::size_t>(point_of[n])] = static_cast<int>(n);
  for (const int p : valve.annulus) {
    const auto h = held.find(node_of[static_cast<std::size_t>(p)]);
    valve.annulus_displacement.push_back(h == held.end() ? Vec3(Vec3::Zero()) : h->second.displacement);
    if (h != held.end() && !h->second.amplitude.empty()) valve.motion_amplitude_name = h->second.amplitude;
  }
  if (!valve.motion_amplitude_name.empty()) valve.motion_amplitude = deck.amplitudes.at(valve.motion_amplitude_name);

  std::map<int, Vec3> moved;
  for (const auto& [node, h] : held) moved[node] = h.displacement;
  collect_chordae(deck, options, units, point_of, section, moved, valve);
  return valve;
}

}  // namespace mv
