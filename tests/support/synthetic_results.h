// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A small RESULTS/ folder with a made-up but plausible closure, for tests of output and report that must not wait for a
// simulation. Shapes and curves are drawn, not solved: nothing in it is a result.

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/case.h"
#include "solver/output/contact_map.h"

namespace mv::test {

struct SyntheticOptions {
  bool is_sealed = true;  // false: a gap in the belt at the middle of the anterior leaflet, and two holes
  bool has_fluid = true;
  bool has_chordae = true;
  int order = 1;
  int columns = 96;         // elements along the annulus
  int rows = 14;            // elements from annulus to free edge
  double tilt_degrees = 0;  // of the valve's axis against the world
};

struct SyntheticValve {
  LeafletMesh mesh;                      // open state
  std::vector<Vec3> closed;              // points of the closed state, mm
  std::vector<double> contact_pressure;  // Pa, closed state
  std::vector<double> gap;               // m, closed state; NaN where nothing faces the point
  Chordae chordae;
  Annulus annulus;
  double perimeter = 0;  // period of unfolded u, mm
};

/// Four-semicircle cone, 1 mm thick, two layers; atrium towards +z, anterior towards +y.
SyntheticValve make_synthetic_valve(const SyntheticOptions& options = {});

/// Writes a complete RESULTS/ into `results` (series, chordae, frames, contact map, summary, run, case/).
void write_synthetic_results(const std::filesystem::path& results, const SyntheticOptions& options = {});

}  // namespace mv::test
