// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Measures of prepared valves under the names that SlicerHeart's Valve Quantification gives them, in the three tables that its
// batch export writes, so that both can be put side by side.

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct Metric {
  std::string name;  // e.g. "Annulus circumference (3D)"
  double value = 0;
  std::string unit;  // "mm", "mm*mm", "mm*mm*mm", "mm/mm"
};

/// Annulus: circumference, A-P, AL-PM and (with two commissures) ALC-PMC distances between points of the space curve, sphericity
/// index, height with its parts above (towards the atrium) and below the plane, 2D area (projected) and 3D area (soap film).
/// Leaflets: area of the mid-surface, volume of the tetrahedra at rest, thickness estimate = volume / area, of each leaflet and
/// of all (thickness: mean of the leaflets, as there). Reads mid_surface.vtp, annulus.vtp, leaflets.vtu. Throws IoError,
/// InputError.
std::vector<Metric> measure_case_metrics(const std::filesystem::path& case_directory);

struct ValveMetrics {
  std::string filename;  // of the case directory
  std::string phase;     // of the heart cycle, e.g. "ES"; may be empty
  std::vector<Metric> metrics;
};

/// Writes QuantificationResults_wide.csv (Filename, Phase, Measurement = MitralValve, one column per metric; a valve without one
/// leaves it empty), QuantificationResults_long.csv (Filename, Phase, Measurement, Value) and QuantificationUnits.csv
/// (Measurement, Unit) into `directory`, which is made. Throws IoError.
void write_metrics(const std::filesystem::path& directory, const std::vector<ValveMetrics>& valves);

}  // namespace mv
