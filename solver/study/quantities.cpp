// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/quantities.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/output/contact_map.h"
#include "solver/output/frame_reader.h"
#include "solver/output/series.h"
#include "solver/output/summary.h"
#include "solver/seal/valve_metrics.h"
#include "solver/time/stress_areas.h"

namespace mv {
namespace {

namespace fs = std::filesystem;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double systole = 0.3;  // s

enum : std::size_t {
  closing_volume, closing_time, leak, peak_velocity, papillary, primary, secondary, contact_force, contact_area, bulging, belly, trigones, quantity_count
};

double number_at(const Json& json, const char* name) {
  const Json& value = json_at(json, name);
  return value.is_number() ? value.get<double>() : nan;
}

/// Mean of a column over the rows from `from` on; rows are evenly spaced but for the steps that end at other outputs.
double mean_from(const std::vector<double>& time, const std::vector<double>& column, double from) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < time.size() && i < column.size(); ++i)
    if (time[i] >= from) {
      sum += column[i];
      ++count;
    }
  return count > 0 ? sum / count : nan;
}

void read_series(const fs::path& results, double window, std::vector<double>& values) {
  const SeriesTable table = read_csv(results / "series.csv");
  const std::vector<double> time = table.numbers("time_s");
  if (time.empty()) return;
  const double from = time.back() - window - 1e-9;
  auto mean = [&](const char* column) { return mean_from(time, table.numbers(column), from); };
  values[papillary] = mean("papillary_force_0_N") + mean("papillary_force_1_N");
  values[primary] = mean("chordae_primary_N");
  values[secondary] = mean("chordae_secondary_N");
  values[contact_force] = mean("contact_force_N");
  values[contact_area] = mean("contact_area_mm2");
}

void read_frames(const fs::path& results, double window, std::vector<double>& values) {
  std::vector<fs::path> files;
  if (!fs::is_directory(results / "frames")) return;
  for (const auto& entry : fs::directory_iterator(results / "frames"))
    if (const std::string name = entry.path().filename().string(); name.starts_with("leaflets_") && name.ends_with(".vtu")) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  double last = -1, bulging_sum = 0, belly_sum = 0, trigones_sum = 0;
  int count = 0;
  for (auto file = files.rbegin(); file != files.rend(); ++file) {
    const LeafletsFrame frame = read_leaflets_frame(*file);
    if (last < 0) last = frame.time;
    if (frame.time < last - window - 1e-9) break;
    const AnnulusPlane plane{frame.annulus_origin, -frame.annulus_normal};
    bulging_sum += measure_bulging(frame.mesh.points, faces_on_side(frame.mesh, atrial).triangles, plane).volume_ml;
    LeafletMesh rest = frame.mesh;
    for (std::size_t i = 0; i < rest.points.size(); ++i) rest.points[i] -= frame.displacement[i];
    if (frame.fibre_stress.empty()) belly_sum = trigones_sum = nan;
    else {
      const StressAreas areas = find_stress_areas(rest, {});
      belly_sum += mean_over(rest, areas.belly, frame.fibre_stress);
      trigones_sum += 0.5 * (mean_over(rest, areas.trigone[0], frame.fibre_stress) + mean_over(rest, areas.trigone[1], frame.fibre_stress));
    }
    ++count;
  }
  if (count == 0) return;
  values[bulging] = bulging_sum / count;
  values[belly] = belly_sum / count;
  values[trigones] = trigones_sum / count;
}

}  // namespace

const std::vector<Quantity>& quantities() {
  static const std::vector<Quantity> list{
      {"closing_volume", "ml", "Closing volume", "backward through the annulus until the flow's first zero crossing"},
      {"closing_time", "ms", "Closing time", "of that crossing, from the start"},
      {"leak", "ml/s", "Leak", "net of what the leaflets sweep, over the last 50 ms"},
      {"peak_velocity", "m/s", "Peak velocity", "largest of the whole run"},
      {"papillary_force", "N", "Papillary force", "both tips, mean over the window"},
      {"chordae_primary_force", "N", "Primary chordae", "sum at the roots, mean over the window"},
      {"chordae_secondary_force", "N", "Secondary chordae", "sum at the roots, mean over the window"},
      {"contact_force", "N", "Contact force", "mean over the window"},
      {"contact_area", "mm2", "Contact area", "faces nearer than one fluid cell, mean over the window"},
      {"bulging_volume", "ml", "Bulging", "volume above the annulus plane, mean of the window's frames"},
      {"fibre_stress_belly", "kPa", "Fibre stress, belly", "mean over the belly of the anterior leaflet and the window's frames"},
      {"fibre_stress_trigones", "kPa", "Fibre stress, trigones", "mean over both trigones and the window's frames"},
  };
  return list;
}

std::vector<double> read_quantities(const fs::path& results, double window) {
  std::vector<double> values(quantity_count, nan);
  const Json summary = read_json(results / "summary.json");
  values[closing_volume] = number_at(summary, "flow.closing_volume_ml");
  values[closing_time] = 1e3 * number_at(summary, "flow.closing_time_s");
  values[leak] = number_at(summary, "flow.leak_rate_ml_s");
  values[peak_velocity] = number_at(summary, "flow.peak_velocity_m_s");
  read_series(results, window, values);
  read_frames(results, window, values);
  return values;
}

std::vector<double> errors_percent(const std::vector<double>& values, const std::vector<double>& reference) {
  std::vector<double> errors;
  for (std::size_t q = 0; q < values.size(); ++q) {
    const double scale = q == leak ? std::abs(reference[closing_volume]) / systole : std::abs(reference[q]);
    errors.push_back(scale > 0 ? 100 * std::abs(values[q] - reference[q]) / scale : nan);
  }
  return errors;
}

}  // namespace mv
