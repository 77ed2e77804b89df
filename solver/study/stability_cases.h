// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The declared table of `mvsolve stability`: what is made stiff or extreme, and how each case has to end.

#include <functional>
#include <string>
#include <vector>

#include "solver/time/scene.h"

namespace mv {

/// How a case has to end: solved with every gate passed, or refused before its first step.
enum class Expected { stable, refused };

/// What the valve must do for the answer to be physically sensible.
enum class Behaviour {
  closes,      // towards the atrium until the chordae hold it; blood stops
  opens,       // blood flows towards the ventricle
  prolapses,   // nothing holds it: blood flows towards the atrium and goes on
  rests,       // too little time or too stiff for any of these; only bounds that hold for everything are asked
  beats        // closes and opens many times, each time alike
};

struct StabilityCase {
  std::string name;                    // unique, a plain file name
  std::string axis;                    // what is varied, one of stability_axes()
  std::string note;                    // the case in a phrase, for the page
  std::vector<std::string> geometry;   // key=value for mvprep, over the base
  std::vector<std::string> settings;   // key=value for mvsolve, over the case's
  std::function<void(Scene&)> alter;   // done to the scene before the run; may be empty
  double end = 0;                      // s, simulated
  Behaviour behaviour = Behaviour::closes;
  Expected expected = Expected::stable;
};

/// Every axis that the table must hold.
const std::vector<std::string>& stability_axes();

/// The table. Deterministic.
std::vector<StabilityCase> stability_cases();

/// The configuration of a case's geometry as TOML.
std::string geometry_toml(const StabilityCase& stability_case);

/// Number of beats in the pressure of cases that beat, and the length of one (s).
inline constexpr int beat_count = 100;
inline constexpr double beat_length = 0.06;
inline constexpr double beat_hold_middle = 0.5;   // of a beat

}  // namespace mv
