// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The numbers a user quotes from a closure, read from RESULTS alone.

#include <array>
#include <filesystem>
#include <vector>

namespace mv {

struct Quantity {
  const char* name;     // "closing_volume"
  const char* unit;     // "ml"
  const char* title;    // "Closing volume"
  const char* how;      // where the number comes from
};

/// Closing volume and time, leak, peak velocity, papillary and chordae forces, contact area and force, bulging, fibre stress in the belly and at the trigones.
const std::vector<Quantity>& quantities();

/// Their values in the order of quantities(); NaN where the results do not hold one. What oscillates after the impact (forces, contact, bulging, stress) is the mean over
/// the last `window` (s) of the run, from series.csv and the leaflet frames; the rest is from summary.json. Throws IoError, InputError.
std::vector<double> read_quantities(const std::filesystem::path& results, double window);

/// Errors in per cent of the reference. The leak, whose right value is zero, is measured by what it adds to the closing volume in a systole of 0.3 s.
std::vector<double> errors_percent(const std::vector<double>& values, const std::vector<double>& reference);

}  // namespace mv
