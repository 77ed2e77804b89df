// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The valve in a deck: shells become the mid-surface (quads split along their shorter diagonal, the deck's own nodes kept), trusses and beams the
// chordae, boundary tables the motion of annulus and papillary tips, pressures the side of the ventricle. Lengths mm, stress Pa.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "geometry/deck/abaqus_deck.h"

namespace mv {

/// Factors from the deck's units to mm, Pa and kg/m3. Throws ConfigError for an unknown name (mm-tonne-s, mm-g-s, m-kg-s).
struct DeckUnits {
  double length = 1, stress = 1e6, density = 1e12;
  static DeckUnits named(const std::string& name);
};

struct DeckValveOptions {
  std::string units = "mm-tonne-s";
  std::vector<std::string> leaflets;  // "anterior=SET"; empty: found by the names of the sets
  bool merge_chains = true;
  double thickness = 1;               // mm, of leaflets whose section says none
};

/// A chorda's end or branch, and pieces between them, in deck terms.
struct DeckChordae {
  struct Segment {
    int a, b;                // indices into points, a nearer to the root
    double rest_length = 0;  // mm
    double area = 0;         // mm2
    int leaflet = 0;         // region of the leaflet it leads to, 0 unknown
    int tip = -1;            // papillary tip its tree hangs on
    std::string material;    // lower case
  };
  std::vector<Vec3> points;
  std::vector<int> tip_of_point;      // papillary tip of a root, else -1
  std::vector<int> leaflet_point;     // mid-surface point of a leaflet end, else -1
  std::vector<Segment> segments;
};

struct DeckValve {
  std::vector<Vec3> points;                   // mid-surface
  std::vector<long> labels;                   // the deck's node labels
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise seen from the atrium
  std::vector<int> region;                    // per triangle
  std::vector<Vec3> fibre;                    // per triangle: local direction 1 of the section's orientation, unit and tangent; empty: none given
  std::vector<double> thickness;              // per point, mm
  bool has_uniform_thickness = true;
  std::vector<int> annulus;                   // mid-surface points in order round the annulus
  std::vector<Vec3> annulus_displacement;     // at the end, per entry of `annulus`
  std::vector<int> free_edge;                 // in order
  std::vector<Vec3> tips;
  std::vector<Vec3> tip_displacement;
  DeckAmplitude motion_amplitude;             // over the step's time; empty: linear
  std::string motion_amplitude_name;
  DeckChordae chordae;
  std::optional<double> pressure;             // Pa, ventricle minus atrium, at the end
  DeckAmplitude pressure_amplitude;
  double period = 1;                          // of the step, deck units of time (s)
  std::vector<std::string> notes;
};

/// Throws InputError naming file, line or node and what was expected: no shells, an element set that names no leaflet or two, leaflets that are not one
/// ring with two borders or not consistently oriented, an annulus that no boundary condition holds, a truss without section or area, chordae that reach
/// neither leaflet nor root, pressures on both sides.
DeckValve build_deck_valve(const AbaqusDeck& deck, const DeckValveOptions& options);

}  // namespace mv
