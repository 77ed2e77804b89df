// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Chordae trees as segmentation tools and decks store them: a network of straight segments with shared points. Nothing here knows
// the valve; attach_chordae (segmented_chordae.h) hangs the network on muscles and leaflets.
//
//   .vtp, .vtk (legacy, ASCII or binary; poly data or unstructured grid): lines and polylines. Points of the same place are one
//         point. Arrays, on points or cells: radius | diameter | area, rest_length (cells), kind (cells), root | fixed (points,
//         non-zero: hangs on a muscle), leaflet | on_leaflet (points, non-zero: ends on the leaflet).
//   .swc  `id type x y z radius parent`, '#' comments, parent -1 for a root. Ids in any order; a cycle is an error.
//   .csv  one segment a row: x0,y0,z0,x1,y1,z1 and, optional, radius | diameter | area, rest_length, kind (a name), from and to
//         (root | branch | leaflet: what the two ends are). A column may carry its unit (x0_mm, area_mm2); otherwise `unit` holds.

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

enum class ChordaeSpace { ras, lps };

struct ChordaeFileOptions {
  std::string unit = "mm";                     // of lengths in the file (areas: its square)
  ChordaeSpace space = ChordaeSpace::ras;      // lps: x and y change sign
  double weld = 1e-3;                          // mm: points closer than this are one point
};

struct RawChordae {
  std::vector<Vec3> points;                    // mm, RAS
  std::vector<std::array<int, 2>> segments;    // points; either direction
  std::vector<double> area;                    // per segment, mm2; NaN: not known
  std::vector<double> rest_length;             // per segment, mm; NaN: not known (the segmented length)
  std::vector<int> kind;                       // per segment: ChordaKind, -1: not known
  std::vector<char> is_root;                   // per point: said to hang on a muscle
  std::vector<char> is_leaflet_end;            // per point: said to end on the leaflet
  std::vector<std::string> notes;              // what was welded, dropped or odd
};

/// Reads by the name's ending (.vtp .vtk .swc .csv). Segments without length and repeated ones are dropped with a note. Throws
/// IoError when unreadable; InputError naming file, line or array for anything else: no segments, NaN, an index out of range, a
/// cycle or a missing parent (.swc), an unknown column unit; ConfigError for an unknown `unit`.
RawChordae read_chordae_file(const std::filesystem::path& file, const ChordaeFileOptions& options = {});

/// Writes a .csv with all columns that read_chordae_file reads back; segments run from the muscle to the leaflet. Throws IoError.
void write_chordae_csv(const std::filesystem::path& file, const Chordae& chordae);

/// "primary", "secondary", "strut", "basal", "marginal"; InputError naming `where` for another name.
ChordaKind chorda_kind_from_name(const std::string& name, const std::string& where);
const char* chorda_kind_name(ChordaKind kind);

}  // namespace mv
