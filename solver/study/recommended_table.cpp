// SPDX-License-Identifier: BSD-3-Clause
// Written by: mvsolve accuracy -o DIR --budget 3000 --fresh --table solver/study/recommended_table.cpp
// Repeat with: mvsolve accuracy -o DIR --table solver/study/recommended_table.cpp
#include <limits>

#include "solver/study/recommended.h"

namespace mv {

const std::vector<RecommendedSettings>& recommended_table() {
  [[maybe_unused]] constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static const std::vector<RecommendedSettings> table{
      {5, "f1.25-s0.625-safety0.9", 1.25, 0.625, 1, {"time.safety=0.9"}, 92.32,
       {},
       {{"closing_volume", 47.4}, {"closing_time", 7.38}, {"leak", 17.7}, {"peak_velocity", 66.1}, {"papillary_force", 39.9}, {"chordae_primary_force", 5.98}, {"chordae_secondary_force", 60.8}, {"contact_force", 62.5}, {"contact_area", 74.8}, {"bulging_volume", 55.7}, {"fibre_stress_belly", 23.2}, {"fibre_stress_trigones", 180}}},
      {2, "f1.25-s0.625-safety0.9", 1.25, 0.625, 1, {"time.safety=0.9"}, 92.32,
       {},
       {{"closing_volume", 47.4}, {"closing_time", 7.38}, {"leak", 17.7}, {"peak_velocity", 66.1}, {"papillary_force", 39.9}, {"chordae_primary_force", 5.98}, {"chordae_secondary_force", 60.8}, {"contact_force", 62.5}, {"contact_area", 74.8}, {"bulging_volume", 55.7}, {"fibre_stress_belly", 23.2}, {"fibre_stress_trigones", 180}}},
      {1, "f1.25-s0.625-safety0.9", 1.25, 0.625, 1, {"time.safety=0.9"}, 92.32,
       {},
       {{"closing_volume", 47.4}, {"closing_time", 7.38}, {"leak", 17.7}, {"peak_velocity", 66.1}, {"papillary_force", 39.9}, {"chordae_primary_force", 5.98}, {"chordae_secondary_force", 60.8}, {"contact_force", 62.5}, {"contact_area", 74.8}, {"bulging_volume", 55.7}, {"fibre_stress_belly", 23.2}, {"fibre_stress_trigones", 180}}},
  };
  return table;
}

}  // namespace mv
