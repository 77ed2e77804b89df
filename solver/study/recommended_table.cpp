// SPDX-License-Identifier: BSD-3-Clause
// Written by: mvsolve accuracy -o DIR --fresh --table solver/study/recommended_table.cpp
// Repeat with: mvsolve accuracy -o DIR --table solver/study/recommended_table.cpp
#include <limits>

#include "solver/study/recommended.h"

namespace mv {

const std::vector<RecommendedSettings>& recommended_table() {
  [[maybe_unused]] constexpr double none = std::numeric_limits<double>::quiet_NaN();
  static const std::vector<RecommendedSettings> table{
      {5, "f1-s0.5", 1, 0.5, 1, {}, 168.6,
       {"leak", "chordae_primary_force", "fibre_stress_belly"},
       {{"closing_volume", 47.7}, {"closing_time", 7.95}, {"peak_velocity", 59.2}, {"papillary_force", 22}, {"chordae_secondary_force", 6.35}, {"contact_force", 56}, {"contact_area", 82.6}, {"bulging_volume", 50.4}, {"fibre_stress_trigones", 8.18}}},
      {2, "f1-s0.5", 1, 0.5, 1, {}, 168.6,
       {"leak", "fibre_stress_belly"},
       {{"closing_volume", 47.7}, {"closing_time", 7.95}, {"peak_velocity", 59.2}, {"papillary_force", 22}, {"chordae_primary_force", 4.45}, {"chordae_secondary_force", 6.35}, {"contact_force", 56}, {"contact_area", 82.6}, {"bulging_volume", 50.4}, {"fibre_stress_trigones", 8.18}}},
      {1, "f1-s0.5", 1, 0.5, 1, {}, 168.6,
       {},
       {{"closing_volume", 47.7}, {"closing_time", 7.95}, {"leak", 1.34}, {"peak_velocity", 59.2}, {"papillary_force", 22}, {"chordae_primary_force", 4.45}, {"chordae_secondary_force", 6.35}, {"contact_force", 56}, {"contact_area", 82.6}, {"bulging_volume", 50.4}, {"fibre_stress_belly", 1.71}, {"fibre_stress_trigones", 8.18}}},
  };
  return table;
}

}  // namespace mv
