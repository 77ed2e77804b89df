// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a user asks of an instant: contact traction, chordae forces, net leak. SI.

#include "solver/output/series.h"
#include "solver/time/simulation.h"

namespace mv {

/// Contact on the atrial faces, one entry per leaflet point. The traction across the belt is the penalty plus the pressure of the blood film
/// above the atrium's (DESIGN, section 5): in an immersed flow the kernel, not the physics, decides how the two share the load.
struct ContactMeasure {
  std::vector<double> gap;              // m to the facing leaflet, NaN where nothing faces the point within the search distance
  std::vector<double> penalty;          // Pa
  std::vector<double> film;             // Pa, only where in contact
  std::vector<double> traction;         // Pa, penalty + film
  std::vector<Vec3> force;              // N, traction times current area, along the normal the point is pushed
  std::vector<char> in_contact;         // gap below the threshold
  double threshold = 0;                 // m
  double force_total = 0, penalty_total = 0, film_total = 0;  // N, across the interface, counted once
  double area = 0;                      // m2, counted once
};

/// Needs forces evaluated at the state (Simulation::refresh or the end of a step is near enough for the series). `is_quick` takes the gaps of
/// the last film search, at most some twenty steps old, where there are any: a new search costs as much as several steps.
ContactMeasure measure_contact(const Simulation& simulation, const State& state, bool is_quick = false);

/// Row of series.csv except for limiter and net leak.
SeriesRow measure_series(Simulation& simulation, const State& state, const ContactMeasure& contact);

/// Leaflet points in the world frame, mm.
std::vector<Vec3> world_points(const Simulation& simulation, const State& state);

}  // namespace mv
