// SPDX-License-Identifier: BSD-3-Clause
// Written by: mvsolve accuracy -o DIR --budget 330 --no-known-answers --no-scene-parts
// Repeat with: mvsolve accuracy -o DIR --table solver/study/recommended_table.cpp
#include <limits>

#include "solver/study/recommended.h"

namespace mv {

const std::vector<RecommendedSettings>& recommended_table() {
  [[maybe_unused]] constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static const std::vector<RecommendedSettings> table{
      {5, "f1-s0.5", 1, 0.5, 1, {}, 141.4,
       {"closing_time", "leak", "papillary_force", "contact_force"},
       {{"closing_volume", 31.1}, {"peak_velocity", 79.8}, {"chordae_primary_force", 12.3}, {"chordae_secondary_force", 6.36}, {"contact_area", 9.5}, {"bulging_volume", 77.9}, {"fibre_stress_belly", 13.9}, {"fibre_stress_trigones", 16.3}}},
      {2, "f1-s0.5", 1, 0.5, 1, {}, 141.4,
       {"closing_time", "leak", "contact_force"},
       {{"closing_volume", 31.1}, {"peak_velocity", 79.8}, {"papillary_force", 2.93}, {"chordae_primary_force", 12.3}, {"chordae_secondary_force", 6.36}, {"contact_area", 9.5}, {"bulging_volume", 77.9}, {"fibre_stress_belly", 13.9}, {"fibre_stress_trigones", 16.3}}},
      {1, "f1-s0.5", 1, 0.5, 1, {}, 141.4,
       {"leak"},
       {{"closing_volume", 31.1}, {"closing_time", 1.81}, {"peak_velocity", 79.8}, {"papillary_force", 2.93}, {"chordae_primary_force", 12.3}, {"chordae_secondary_force", 6.36}, {"contact_force", 1.45}, {"contact_area", 9.5}, {"bulging_volume", 77.9}, {"fibre_stress_belly", 13.9}, {"fibre_stress_trigones", 16.3}}},
  };
  return table;
}

}  // namespace mv
