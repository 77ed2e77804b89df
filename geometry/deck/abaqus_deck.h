// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// An Abaqus deck as plain data: what a valve model needs of it, in the deck's own units. Flat decks and decks of parts and instances; names are
// compared without case. Keywords that would change the geometry and are not understood are errors, all others that are not understood become notes.

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/deck/deck_lines.h"

namespace mv {

struct DeckElement {
  long label = 0;
  std::string type;        // upper case, e.g. "S4R"
  std::vector<int> nodes;  // indices into AbaqusDeck::nodes
  DeckPlace place;
  int corners() const;     // nodes that are corners: 3 or 4 for shells and membranes, 2 for trusses and beams, 4 for tetrahedra
};

/// What an element type is; `nodes` per element.
struct DeckElementType {
  enum class Kind { shell, membrane, truss, beam, solid, connector } kind;
  int nodes, corners;
};
/// nullopt for a type that is not known.
std::optional<DeckElementType> deck_element_type(const std::string& type);

struct DeckSection {
  std::string kind;  // "shell", "solid", "membrane", "beam"
  std::string elset, material, orientation;
  double size = 0;   // thickness of shells and membranes, cross-section of trusses and beams (0: not given)
  DeckPlace place;
};

struct DeckMaterial {
  std::string name;
  double density = 0;
  std::string law;           // "", "elastic", "hyperelastic", "anisotropic hyperelastic"
  std::string form;          // "ogden", "neo hooke", "mooney-rivlin", "yeoh", "reduced polynomial", "polynomial", "fung-anisotropic", "fung-orthotropic", "holzapfel", "user", ...
  int terms = 1;             // N
  std::vector<double> data;  // its data lines in one row
  DeckPlace place;
};

/// Two vectors that span the plane of local directions 1 and 2.
struct DeckAxes {
  Vec3 a = Vec3::UnitX(), b = Vec3::UnitY();
};
struct DeckOrientation {
  DeckAxes axes;                      // of every element without an entry of its own
  std::map<long, DeckAxes> elements;  // by element label (rectangular distributions)
  int axis = 0;                       // additional rotation: axis 1..3 (0: none) ...
  double angle = 0;                   // ... by this angle, degrees
  DeckPlace place;
};

/// Amplitude over time: "tabular" is piecewise linear, "smooth step" has (10 - 15 s + 6 s^2) s^3 between its points; constant outside.
struct DeckAmplitude {
  bool is_smooth = false;
  std::vector<double> times, values;
  double at(double time) const;
};

/// One degree of freedom that a step holds or moves; the last step's entry for a node and freedom wins.
struct DeckBoundary {
  int node = 0;
  int freedom = 0;  // 1..3 displacement, 4..6 rotation
  double value = 0;
  std::string amplitude;  // "" none: at once
  int step = -1;          // -1: model data, before the first step
  DeckPlace place;
};

struct DeckPressure {
  std::vector<int> elements;
  int side = 1;  // +1 acts on the face towards which the elements' normals point (SPOS), so pushes against them; -1 SNEG
  double value = 0;
  std::string amplitude;
  int step = -1;
  DeckPlace place;
};

struct DeckStep {
  std::string name;
  double period = 1;
};

struct AbaqusDeck {
  DeckLines lines;
  std::vector<Vec3> nodes;
  std::vector<long> node_labels;
  std::vector<DeckElement> elements;
  std::map<std::string, std::vector<int>> node_sets, element_sets;  // keys "set" and "instance.set"
  std::map<std::string, std::vector<std::pair<std::vector<int>, int>>> surfaces;  // elements and side (+1, -1)
  std::vector<DeckSection> sections;
  std::map<std::string, DeckMaterial> materials;
  std::map<std::string, DeckOrientation> orientations;
  std::map<std::string, DeckAmplitude> amplitudes;
  std::vector<DeckBoundary> boundaries;
  std::vector<DeckPressure> pressures;
  std::vector<DeckStep> steps;
  std::optional<double> friction;
  std::vector<std::string> notes;  // what was left out

  /// The section of each element (index into sections) or -1.
  std::vector<int> section_of_element() const;
  /// Elements of a set; throws InputError listing the nearest known name.
  const std::vector<int>& element_set(const std::string& name, const DeckPlace& place) const;
};

/// Throws InputError (file, line, what was expected) for anything malformed: missing or repeated labels, unknown element types or names, wrong
/// counts of nodes or values, numbers that are none; IoError for a file that cannot be read.
AbaqusDeck read_abaqus_deck(const std::filesystem::path& file);

}  // namespace mv
