// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/deck_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "geometry/core/config.h"  // nearest_name

namespace mv {
namespace {

/// These make or tie geometry; a valve without them would be another valve.
const std::set<std::string> geometry_makers = {"ngen",   "nfill", "ncopy", "nmap",     "elgen",      "elcopy",           "system",  "transform",
                                               "equation", "mpc",   "tie",   "coupling", "rigid body", "embedded element", "kinematic coupling"};
/// Nothing that a case would take over.
const std::set<std::string> silent = {"heading", "preprint", "part", "end part", "assembly", "end assembly", "instance", "end instance", "end step", "output",
                                      "node output", "element output", "contact output", "energy output", "node print", "el print", "el file", "node file", "restart",
                                      "file output", "monitor", "distribution table", "contact", "contact inclusions", "contact property assignment", "contact pair",
                                      "surface interaction", "surface behavior", "variable mass scaling", "fixed mass scaling", "bulk viscosity", "controls",
                                      "section controls", "filter", "end", "print", "solver controls"};

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

void DeckParser::run() {
  for (const Block& block : deck_.lines.blocks) read(block);
  place_root();
  finish();
}

void DeckParser::read(const Block& block) {
  if (geometry_makers.contains(block.keyword))
    fail(block.place, fmt::format("*{} makes or ties geometry and is not understood; write the nodes and elements out (Abaqus/CAE: export the mesh as an orphan mesh)",
                                  upper(block.keyword)));
  if (block.keyword == "part") {
    part_ = &parts_[deck_name(need(block, "name"))];
    part_->name = deck_name(need(block, "name"));
  } else if (block.keyword == "end part") {
    part_ = &root_;
  }
  if (read_model(block) || read_material(block) || read_history(block)) return;
  if (!silent.contains(block.keyword)) ++ignored_[block.keyword];
}

bool DeckParser::read_model(const Block& block) {
  const std::string& k = block.keyword;
  if (k == "node") read_nodes(block);
  else if (k == "element") read_elements(block);
  else if (k == "nset") read_set(block, true);
  else if (k == "elset") read_set(block, false);
  else if (k == "surface") read_surface(block);
  else if (k == "shell section" || k == "membrane section" || k == "solid section" || k == "beam section" || k == "shell general section" || k == "beam general section")
    read_section(block);
  else if (k == "distribution") read_distribution(block);
  else if (k == "orientation") read_orientation(block);
  else if (k == "amplitude") read_amplitude(block);
  else if (k == "instance") read_instance(block);
  else return false;
  return true;
}

bool DeckParser::read_material(const Block& block) {
  const std::string& k = block.keyword;
  if (k == "material") {
    const std::string name = need(block, "name");
    material_ = &deck_.materials[deck_name(name)];
    *material_ = DeckMaterial{name, 0, "", "", 1, {}, block.place};
    return true;
  }
  const bool is_law = k == "elastic" || k == "hyperelastic" || k == "anisotropic hyperelastic" || k == "user material" || k == "hyperfoam";
  if (k != "density" && !is_law) return false;
  if (!material_) fail(block.place, fmt::format("*{} outside of *MATERIAL", upper(k)));
  if (k == "density") {
    if (block.data.empty()) fail(block.place, "*DENSITY has no data line; expected a number");
    material_->density = deck_number(deck_.lines, block.data[0].place, block.data[0].fields[0], "a density");
    if (!(material_->density > 0)) fail(block.data[0].place, fmt::format("density {:.6g}; expected a positive number", material_->density));
    return true;
  }
  if (block.has("test data input")) fail(block.place, "laws by TEST DATA INPUT are not understood; write the coefficients that Abaqus fitted (in its .dat file)");
  material_->law = k;
  material_->place = block.place;
  if (block.has("n")) material_->terms = static_cast<int>(deck_integer(deck_.lines, block.place, block.option("n"), "the number of terms"));
  for (const auto& [option, value] : block.options)
    if (value.empty() && material_->form.empty()) material_->form = option;
  // Abaqus' names of the form come as flags ("OGDEN", "USER"); which flag is it when there are several does not matter to the ones known here.
  for (const char* form : {"ogden", "neo hooke", "mooney-rivlin", "yeoh", "reduced polynomial", "polynomial", "holzapfel", "holzapfel-gasser-ogden", "fung-anisotropic", "fung-orthotropic", "user"})
    if (block.has(form)) material_->form = form;
  material_->data = row(block);
  return true;
}

bool DeckParser::read_history(const Block& block) {
  const std::string& k = block.keyword;
  if (k == "step") {
    place_root();
    ++step_;
    deck_.steps.push_back({block.option("name", fmt::format("step {}", step_ + 1)), 1.0});
  } else if (k == "dynamic" || k == "static") {
    read_step_control(block);
  } else if (k == "boundary") {
    read_boundary(block);
  } else if (k == "dsload" || k == "dload") {
    read_load(block, k == "dsload");
  } else if (k == "friction") {
    if (!block.data.empty()) deck_.friction = deck_number(deck_.lines, block.data[0].place, block.data[0].fields[0], "a friction coefficient");
  } else if (k == "cload") {
    fail(block.place, "*CLOAD: concentrated forces are not understood; a valve is loaded by pressures (*DSLOAD, *DLOAD) and moved by *BOUNDARY");
  } else {
    return false;
  }
  return true;
}

std::string DeckParser::need(const Block& block, const std::string& option) const {
  if (block.option(option).empty()) fail(block.place, fmt::format("*{} without {}=...", upper(block.keyword), upper(option)));
  return block.option(option);
}

std::vector<double> DeckParser::numbers(const Block::Data& data, std::size_t first) const {
  std::vector<double> out;
  for (std::size_t f = first; f < data.fields.size(); ++f)
    out.push_back(data.fields[f].empty() ? 0.0 : deck_number(deck_.lines, data.place, data.fields[f], "a number"));
  return out;
}

std::vector<double> DeckParser::row(const Block& block) const {
  std::vector<double> out;
  for (const Block::Data& data : block.data)
    for (const double value : numbers(data)) out.push_back(value);
  return out;
}

void DeckParser::read_nodes(const Block& block) {
  if (block.has("system") && upper(block.option("system")) != "R")
    fail(block.place, "*NODE, SYSTEM=" + block.option("system") + ": only rectangular coordinates are understood");
  if (part_ == &root_ && root_is_placed_) fail(block.place, "*NODE after the first *STEP");
  RawSet* const set = block.has("nset") ? &part_->node_sets[deck_name(block.option("nset"))] : nullptr;
  if (set) set->place = block.place;
  for (const Block::Data& data : block.data) {
    if (data.fields.size() < 2 || data.fields.size() > 7)
      fail(data.place, fmt::format("{} fields; expected a node as 'label, x, y, z'", data.fields.size()));
    const long label = deck_integer(deck_.lines, data.place, data.fields[0], "a node label");
    Vec3 x = Vec3::Zero();
    for (std::size_t k = 1; k < std::min<std::size_t>(data.fields.size(), 4); ++k)
      x[static_cast<Eigen::Index>(k) - 1] = data.fields[k].empty() ? 0.0 : deck_number(deck_.lines, data.place, data.fields[k], "a coordinate");
    if (!part_->node_at.try_emplace(label, part_->nodes.size()).second) fail(data.place, fmt::format("node {} is defined twice", label));
    part_->nodes.emplace_back(label, x);
    if (set) set->labels.push_back(label);
  }
}

void DeckParser::read_elements(const Block& block) {
  const std::string type = upper(need(block, "type"));
  const auto known = deck_element_type(type);
  if (!known)
    fail(block.place, fmt::format("element type {} is not known; known: shells S3 S4 S4R, membranes M3D3 M3D4, trusses T3D2, beams B31, tetrahedra C3D4 C3D10, C3D6, C3D8", type));
  RawSet* const set = block.has("elset") ? &part_->element_sets[deck_name(block.option("elset"))] : nullptr;
  if (set) set->place = block.place;
  for (std::size_t d = 0; d < block.data.size(); ++d) {
    const DeckPlace place = block.data[d].place;
    std::vector<std::string> fields = block.data[d].fields;
    // Nodes go on in the next line until there are enough.
    while (static_cast<int>(fields.size()) < known->nodes + 1 && d + 1 < block.data.size() && block.data[d].continues) {
      const auto& next = block.data[++d].fields;
      fields.insert(fields.end(), next.begin(), next.end());
    }
    if (static_cast<int>(fields.size()) != known->nodes + 1)
      fail(place, fmt::format("{} fields; an element of type {} is 'label' and {} nodes", fields.size(), type, known->nodes));
    RawElement element{deck_integer(deck_.lines, place, fields[0], "an element label"), type, {}, place};
    for (std::size_t f = 1; f < fields.size(); ++f) element.nodes.push_back(deck_integer(deck_.lines, place, fields[f], "a node label"));
    if (!part_->element_at.try_emplace(element.label, part_->elements.size()).second) fail(place, fmt::format("element {} is defined twice", element.label));
    if (set) set->labels.push_back(element.label);
    part_->elements.push_back(std::move(element));
  }
}

void DeckParser::read_set(const Block& block, bool is_node_set) {
  const std::string key = is_node_set ? "nset" : "elset";
  const std::string name = deck_name(need(block, key));
  RawSet set;
  set.place = block.place;
  if (is_node_set && block.has("elset")) set.from_element_set = deck_name(block.option("elset"));
  for (const Block::Data& data : block.data) {
    if (block.has("generate")) {
      if (data.fields.size() < 2) fail(data.place, "expected 'first, last, step' below a set with GENERATE");
      const long first = deck_integer(deck_.lines, data.place, data.fields[0], "a label"), last = deck_integer(deck_.lines, data.place, data.fields[1], "a label");
      const long by = data.fields.size() > 2 ? deck_integer(deck_.lines, data.place, data.fields[2], "an increment") : 1;
      if (by < 1 || last < first) fail(data.place, "GENERATE: expected first <= last and a positive increment");
      constexpr long most = 100'000'000;
      if ((last - first) / by > most) fail(data.place, "GENERATE: more labels than any deck holds");
      for (long label = first; label <= last; label += by) set.labels.push_back(label);
      continue;
    }
    for (const std::string& field : data.fields) {
      if (field.empty()) continue;
      if (is_deck_label(field)) set.labels.push_back(std::stol(field));
      else set.names.push_back(deck_name(field));
    }
  }
  if (block.has("instance") || (part_ == &root_ && root_is_placed_)) {
    const std::string instance = deck_name(block.option("instance"));
    const auto labels = labels_.find(instance);
    if (labels == labels_.end()) fail(block.place, fmt::format("there is no instance '{}'", block.option("instance")));
    auto& sets = is_node_set ? deck_.node_sets : deck_.element_sets;
    const std::vector<int> found = members(set, labels->second, instance, is_node_set);
    auto& target = sets[name];
    target.insert(target.end(), found.begin(), found.end());
    return;
  }
  RawSet& target = (is_node_set ? part_->node_sets : part_->element_sets)[name];
  target.labels.insert(target.labels.end(), set.labels.begin(), set.labels.end());
  target.names.insert(target.names.end(), set.names.begin(), set.names.end());
  if (!set.from_element_set.empty()) target.from_element_set = set.from_element_set;
  target.place = set.place;
}

void DeckParser::read_section(const Block& block) {
  DeckSection section;
  section.kind = block.keyword.substr(0, block.keyword.find(' '));
  section.elset = deck_name(need(block, "elset"));
  section.material = deck_name(block.option("material"));
  section.orientation = deck_name(block.option("orientation"));
  section.place = block.place;
  if (block.has("shell thickness") || block.has("nodal thickness"))
    fail(block.place, "thickness by a distribution or by nodes is not understood; give one thickness per section (one section per group of elements)");
  if (block.has("composite")) fail(block.place, "composite sections are not understood; expected one material and one thickness");
  const bool has_size = section.kind != "beam" || upper(block.option("section")) == "CIRC";
  if (has_size && !block.data.empty() && !block.data[0].fields[0].empty()) {
    section.size = deck_number(deck_.lines, block.data[0].place, block.data[0].fields[0], "a thickness or an area");
    if (!(section.size > 0)) fail(block.data[0].place, fmt::format("thickness or area {:.6g}; expected a positive number", section.size));
    if (section.kind == "beam") section.size = std::acos(-1.0) * section.size * section.size;
  }
  part_->sections.push_back(section);
}

void DeckParser::read_distribution(const Block& block) {
  Distribution& distribution = distributions_[deck_name(need(block, "name"))];
  distribution.place = block.place;
  for (const Block::Data& data : block.data) {
    const std::vector<double> values = numbers(data, 1);
    if (data.fields[0].empty()) distribution.otherwise = values;
    else if (is_deck_label(data.fields[0])) distribution.elements[std::stol(data.fields[0])] = values;
    else distribution.sets[deck_name(data.fields[0])] = values;
  }
}

void DeckParser::read_orientation(const Block& block) {
  const std::string system = upper(block.option("system", "RECTANGULAR"));
  if (system != "RECTANGULAR" && system != "R") fail(block.place, "*ORIENTATION, SYSTEM=" + system + ": only RECTANGULAR is understood");
  if (block.data.empty()) fail(block.place, "*ORIENTATION has no data lines; expected two vectors or the name of a distribution");
  DeckOrientation orientation;
  orientation.place = block.place;
  auto axes_of = [&](const std::vector<double>& v, const DeckPlace& place) {
    if (v.size() < 6) fail(place, fmt::format("{} numbers; expected six, two vectors in the plane of local directions 1 and 2", v.size()));
    return DeckAxes{Vec3(v[0], v[1], v[2]), Vec3(v[3], v[4], v[5])};
  };
  const Block::Data& first = block.data[0];
  const bool is_name = first.fields.size() == 1 && !first.fields[0].empty() && (std::isalpha(static_cast<unsigned char>(first.fields[0][0])) || first.fields[0][0] == '_');
  if (is_name) {
    const auto found = distributions_.find(deck_name(first.fields[0]));
    if (found == distributions_.end()) fail(first.place, fmt::format("there is no *DISTRIBUTION '{}' before this line", first.fields[0]));
    const Distribution& distribution = found->second;
    if (!distribution.sets.empty()) fail(distribution.place, "distributions by set are not understood; write one line per element");
    if (!distribution.otherwise.empty()) orientation.axes = axes_of(distribution.otherwise, distribution.place);
    for (const auto& [label, values] : distribution.elements) orientation.elements[label] = axes_of(values, distribution.place);
  } else {
    orientation.axes = axes_of(numbers(first), first.place);
  }
  if (block.data.size() > 1 && block.data[1].fields.size() >= 2) {
    const auto turn = numbers(block.data[1]);
    orientation.axis = static_cast<int>(turn[0]);
    orientation.angle = turn[1];
    if (orientation.axis < 1 || orientation.axis > 3) fail(block.data[1].place, "the axis of the additional rotation must be 1, 2 or 3");
  }
  deck_.orientations[deck_name(need(block, "name"))] = orientation;
}

void DeckParser::read_amplitude(const Block& block) {
  const std::string definition = upper(block.option("definition", "TABULAR"));
  if (definition != "TABULAR" && definition != "SMOOTH STEP") fail(block.place, "*AMPLITUDE, DEFINITION=" + definition + ": only TABULAR and SMOOTH STEP are understood");
  DeckAmplitude amplitude;
  amplitude.is_smooth = definition == "SMOOTH STEP";
  const std::vector<double> values = row(block);
  if (values.empty() || values.size() % 2 != 0) fail(block.place, fmt::format("*AMPLITUDE has {} numbers; expected pairs of time and value", values.size()));
  for (std::size_t i = 0; i < values.size(); i += 2) {
    if (i > 0 && !(values[i] > amplitude.times.back())) fail(block.place, fmt::format("*AMPLITUDE: time {} does not grow", values[i]));
    amplitude.times.push_back(values[i]);
    amplitude.values.push_back(values[i + 1]);
  }
  deck_.amplitudes[deck_name(need(block, "name"))] = amplitude;
}

void DeckParser::finish() {
  std::set<std::string> used;
  for (const DeckSection& section : deck_.sections) {
    if (!section.material.empty() && !deck_.materials.contains(section.material)) fail(section.place, fmt::format("there is no *MATERIAL '{}'", section.material));
    if (!section.orientation.empty() && !deck_.orientations.contains(section.orientation)) fail(section.place, fmt::format("there is no *ORIENTATION '{}'", section.orientation));
    deck_.element_set(section.elset, section.place);
  }
  for (const DeckBoundary& boundary : deck_.boundaries)
    if (!boundary.amplitude.empty() && !deck_.amplitudes.contains(boundary.amplitude)) fail(boundary.place, fmt::format("there is no *AMPLITUDE '{}'", boundary.amplitude));
  for (const DeckPressure& pressure : deck_.pressures)
    if (!pressure.amplitude.empty() && !deck_.amplitudes.contains(pressure.amplitude)) fail(pressure.place, fmt::format("there is no *AMPLITUDE '{}'", pressure.amplitude));
  if (deck_.nodes.empty()) throw InputError(deck_.lines.files[0].string() + ": no *NODE, or parts without an *INSTANCE; expected a mesh");
  if (deck_.elements.empty()) throw InputError(deck_.lines.files[0].string() + ": no *ELEMENT; expected a mesh");
  for (const auto& [keyword, count] : ignored_) deck_.notes.push_back(fmt::format("*{} ({} times) is not taken over", upper(keyword), count));
}

}  // namespace mv
