// SPDX-License-Identifier: GPL-3.0-or-later
// Parts placed by instances, references across them, and the history data that refers to them.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "geometry/core/config.h"  // nearest_name
#include "geometry/deck/deck_parser.h"

namespace mv {
namespace {

std::string qualified(const std::string& instance, const std::string& name) { return instance.empty() ? name : instance + "." + name; }

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

void DeckParser::read_instance(const Block& block) {
  const std::string name = deck_name(need(block, "name"));
  const std::string part_name = deck_name(need(block, "part"));
  const auto part = parts_.find(part_name);
  if (part == parts_.end()) fail(block.place, fmt::format("there is no *PART '{}'", block.option("part")));
  if (labels_.contains(name)) fail(block.place, fmt::format("instance '{}' is defined twice", block.option("name")));
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  if (!block.data.empty()) {
    const auto shift = numbers(block.data[0]);
    if (shift.size() != 3) fail(block.data[0].place, "expected a translation of three numbers");
    frame.translation() = Vec3(shift[0], shift[1], shift[2]);
  }
  if (block.data.size() > 1) {
    const auto turn = numbers(block.data[1]);
    if (turn.size() != 7) fail(block.data[1].place, "expected a rotation as two points of its axis and an angle in degrees (seven numbers)");
    const Vec3 a(turn[0], turn[1], turn[2]), b(turn[3], turn[4], turn[5]);
    if ((b - a).norm() == 0) fail(block.data[1].place, "the two points of the rotation's axis coincide");
    const Eigen::Isometry3d about = Eigen::Translation3d(a) * Eigen::AngleAxisd(turn[6] * std::acos(-1.0) / 180, (b - a).normalized()) * Eigen::Translation3d(-a);
    frame = about * frame;
  }
  place_part(part->second, name, frame);
}

void DeckParser::place_root() {
  if (std::exchange(root_is_placed_, true)) return;
  place_part(root_, "", Eigen::Isometry3d::Identity());
}

void DeckParser::place_part(const Part& part, const std::string& instance, const Eigen::Isometry3d& frame) {
  Labels& labels = labels_[instance];
  for (const auto& [label, x] : part.nodes) {
    labels.nodes[label] = static_cast<int>(deck_.nodes.size());
    deck_.nodes.push_back(frame * x);
    deck_.node_labels.push_back(label);
  }
  for (const RawElement& raw : part.elements) {
    DeckElement element{raw.label, raw.type, {}, raw.place};
    for (const long node : raw.nodes) {
      const auto found = labels.nodes.find(node);
      if (found == labels.nodes.end()) fail(raw.place, fmt::format("element {} names node {}, which is not defined", raw.label, node));
      element.nodes.push_back(found->second);
    }
    labels.elements[raw.label] = static_cast<int>(deck_.elements.size());
    deck_.elements.push_back(std::move(element));
  }
  // Sets of sets are resolved in any order: names that are not there yet come in a later round.
  for (const bool is_node : {false, true}) {
    const auto& raw_sets = is_node ? part.node_sets : part.element_sets;
    auto& sets = is_node ? deck_.node_sets : deck_.element_sets;
    std::map<std::string, RawSet> left(raw_sets.begin(), raw_sets.end());
    while (!left.empty()) {
      const std::size_t before = left.size();
      for (auto set = left.begin(); set != left.end();) {
        const bool is_ready = std::all_of(set->second.names.begin(), set->second.names.end(), [&](const std::string& n) { return !left.contains(n); });
        if (!is_ready) {
          ++set;
          continue;
        }
        sets[qualified(instance, set->first)] = members(set->second, labels, instance, is_node);
        if (!instance.empty()) sets.try_emplace(set->first, sets[qualified(instance, set->first)]);
        set = left.erase(set);
      }
      if (left.size() == before) fail(left.begin()->second.place, fmt::format("set '{}' contains itself", left.begin()->first));
    }
  }
  for (DeckSection section : part.sections) {
    section.elset = qualified(instance, section.elset);
    deck_.sections.push_back(section);
  }
}

std::vector<int> DeckParser::members(const RawSet& set, const Labels& labels, const std::string& prefix, bool is_node) const {
  std::vector<int> out;
  const auto& known = is_node ? labels.nodes : labels.elements;
  for (const long label : set.labels) {
    const auto found = known.find(label);
    if (found == known.end()) fail(set.place, fmt::format("the set names {} {}, which is not defined", is_node ? "node" : "element", label));
    out.push_back(found->second);
  }
  const auto& sets = is_node ? deck_.node_sets : deck_.element_sets;
  for (const std::string& name : set.names) {
    auto found = sets.find(qualified(prefix, name));
    if (found == sets.end()) found = sets.find(name);
    if (found == sets.end()) fail(set.place, fmt::format("the set names the set '{}', which is not defined", name));
    out.insert(out.end(), found->second.begin(), found->second.end());
  }
  if (!set.from_element_set.empty()) {
    auto found = deck_.element_sets.find(qualified(prefix, set.from_element_set));
    if (found == deck_.element_sets.end()) fail(set.place, fmt::format("there is no element set '{}'", set.from_element_set));
    for (const int e : found->second) {
      const auto& nodes = deck_.elements[static_cast<std::size_t>(e)].nodes;
      out.insert(out.end(), nodes.begin(), nodes.end());
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<int> DeckParser::resolve(const std::string& token, const DeckPlace& place, bool is_node) const {
  const char* const what = is_node ? "node" : "element";
  std::string instance, name = deck_name(token);
  // An instance's name may hold points itself.
  for (std::size_t at = name.find('.'); at != std::string::npos; at = name.find('.', at + 1))
    if (labels_.contains(name.substr(0, at))) instance = name.substr(0, at);
  const auto& sets = is_node ? deck_.node_sets : deck_.element_sets;
  const std::string local = instance.empty() ? name : name.substr(instance.size() + 1);
  if (!is_deck_label(local)) {
    const auto found = sets.find(name);
    if (found != sets.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& [set, ignored] : sets) known.push_back(set);
    fail(place, fmt::format("there is no {} set '{}'{}", what, token, known.empty() ? "" : "; did you mean '" + nearest_name(name, known) + "'?"));
  }
  const long label = std::stol(local);
  auto look = [&](const std::string& in) -> int {
    const auto labels = labels_.find(in);
    if (labels == labels_.end()) return -1;
    const auto& map = is_node ? labels->second.nodes : labels->second.elements;
    const auto found = map.find(label);
    return found == map.end() ? -1 : found->second;
  };
  int index = look(instance);
  // A bare label in a deck with one instance means that instance's.
  if (index < 0 && instance.empty()) {
    int matches = 0;
    for (const auto& [in, ignored] : labels_)
      if (const int found = look(in); found >= 0) index = found, ++matches;
    if (matches > 1) fail(place, fmt::format("{} {} is in several instances; write instance.{}", what, label, label));
  }
  if (index < 0) fail(place, fmt::format("{} {} is not defined", what, token));
  return {index};
}

void DeckParser::read_surface(const Block& block) {
  const std::string type = upper(block.option("type", "ELEMENT"));
  if (type != "ELEMENT") return;
  if (part_ == &root_) place_root();
  if (part_ != &root_) {
    ++ignored_["surface in a part"];
    return;
  }
  auto& surface = deck_.surfaces[deck_name(need(block, "name"))];
  for (const Block::Data& data : block.data) {
    const std::string face = data.fields.size() > 1 ? upper(data.fields[1]) : "SPOS";
    if (face != "SPOS" && face != "SNEG" && face.rfind('S', 0) != 0 && face != "E1" && face != "E2") fail(data.place, fmt::format("face '{}'; expected SPOS or SNEG", face));
    surface.emplace_back(resolve(data.fields[0], data.place, false), face == "SNEG" ? -1 : 1);
  }
}

void DeckParser::read_step_control(const Block& block) {
  if (step_ < 0) fail(block.place, fmt::format("*{} outside of *STEP", upper(block.keyword)));
  if (block.data.empty() || block.data[0].fields.size() < 2 || block.data[0].fields[1].empty()) return;
  const double period = deck_number(deck_.lines, block.data[0].place, block.data[0].fields[1], "the step's period");
  if (!(period > 0)) fail(block.data[0].place, "the step's period must be positive");
  deck_.steps.back().period = period;
}

void DeckParser::read_boundary(const Block& block) {
  place_root();
  const std::string type = upper(block.option("type", "DISPLACEMENT"));
  if (type != "DISPLACEMENT") fail(block.place, "*BOUNDARY, TYPE=" + type + ": only prescribed displacements are understood");
  if (upper(block.option("op", "MOD")) == "NEW" && cleared_in_step_ != step_) {
    std::erase_if(deck_.boundaries, [&](const DeckBoundary& b) { return b.step < step_; });
    cleared_in_step_ = step_;
  }
  const std::string amplitude = deck_name(block.option("amplitude"));
  for (const Block::Data& data : block.data) {
    if (data.fields.size() < 2) fail(data.place, "expected 'node or set, first freedom, last freedom, value'");
    int first = 0, last = 0;
    double value = 0;
    const std::string word = upper(data.fields[1]);
    if (word == "ENCASTRE") first = 1, last = 6;
    else if (word == "PINNED") first = 1, last = 3;
    else if (!is_deck_label(data.fields[1])) fail(data.place, fmt::format("'{}': expected a freedom 1 to 6, PINNED or ENCASTRE", data.fields[1]));
    else {
      first = static_cast<int>(deck_integer(deck_.lines, data.place, data.fields[1], "a freedom"));
      last = data.fields.size() > 2 && !data.fields[2].empty() ? static_cast<int>(deck_integer(deck_.lines, data.place, data.fields[2], "a freedom")) : first;
      if (data.fields.size() > 3 && !data.fields[3].empty()) value = deck_number(deck_.lines, data.place, data.fields[3], "a displacement");
      if (first < 1 || last < first || last > 6) fail(data.place, fmt::format("freedoms {} to {}; expected 1 to 3 (displacement) or 4 to 6 (rotation)", first, last));
    }
    for (const int node : resolve(data.fields[0], data.place, true))
      for (int freedom = first; freedom <= last; ++freedom) deck_.boundaries.push_back({node, freedom, value, amplitude, step_, data.place});
  }
}

void DeckParser::read_load(const Block& block, bool is_surface_load) {
  place_root();
  const std::string amplitude = deck_name(block.option("amplitude"));
  for (const Block::Data& data : block.data) {
    if (data.fields.size() < 3) fail(data.place, is_surface_load ? "expected 'surface, P, value'" : "expected 'elements, P, value'");
    const std::string label = upper(data.fields[1]);
    if (label != "P") fail(data.place, fmt::format("load '{}'; only uniform pressure P on shells and membranes is understood", data.fields[1]));
    const double value = deck_number(deck_.lines, data.place, data.fields[2], "a pressure");
    if (!is_surface_load) {
      // On elements P acts along their normals, on surfaces against them.
      deck_.pressures.push_back({resolve(data.fields[0], data.place, false), -1, value, amplitude, step_, data.place});
      continue;
    }
    const auto surface = deck_.surfaces.find(deck_name(data.fields[0]));
    if (surface == deck_.surfaces.end()) fail(data.place, fmt::format("there is no *SURFACE '{}'", data.fields[0]));
    for (const auto& [elements, side] : surface->second) deck_.pressures.push_back({elements, side, value, amplitude, step_, data.place});
  }
}

}  // namespace mv
