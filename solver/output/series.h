// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// series.csv and chordae.csv: one row per output instant. A row reaches the file whole or not at all; numbers are written so that
// reading them back gives the same double.

#include <filesystem>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Append-only CSV file whose first column is time in seconds.
class CsvWriter {
 public:
  /// resume_time < 0: a new file with a header (an old one is replaced). Otherwise the existing file keeps its header and the
  /// rows with time <= resume_time; later rows and an incomplete last line are cut off. Throws IoError, and InputError when the
  /// header found is not `columns`.
  CsvWriter(std::filesystem::path file, std::vector<std::string> columns, double resume_time = -1);
  ~CsvWriter();
  CsvWriter(CsvWriter&& other) noexcept;
  CsvWriter& operator=(CsvWriter&&) = delete;
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  /// One row; `cells` has one entry per column. Cells are written as they are (no comma, quote or newline inside).
  /// On a full disk the partial row is removed and IoError thrown.
  void append(std::span<const std::string> cells);
  void append(std::span<const double> values);

 private:
  std::filesystem::path file_;
  std::vector<std::string> columns_;
  int descriptor_ = -1;
};

/// Shortest decimal text that reads back as the same double; "nan" and "inf" as such.
std::string format_number(double value);

/// One row of series.csv in file units (the names carry them). A quantity that a scene leaves out stays NaN and gives an empty
/// cell.
struct SeriesRow {
  static constexpr double unset = std::numeric_limits<double>::quiet_NaN();
  double time_s = unset;
  double dt_s = unset;
  std::string limiter;
  double pressure_difference_mmHg = unset;
  double flow_ml_s = unset;  // positive: forward, atrium to ventricle
  double volume_ml = unset;  // integral of flow_ml_s
  double leak_net_ml_s = unset;
  double contact_force_N = unset;
  double contact_penalty_N = unset;
  double contact_film_N = unset;
  double contact_area_mm2 = unset;
  double penetration_max_mm = unset;
  double papillary_force_0_N = unset;
  double papillary_force_1_N = unset;
  double chordae_primary_N = unset;
  double chordae_secondary_N = unset;
  double peak_velocity_m_s = unset;
  double divergence_max = unset;
  double kinetic_J = unset;
  double elastic_J = unset;
  double chordae_elastic_J = unset;
  double work_pressure_J = unset;
  double viscous_loss_J = unset;
  double advection_loss_J = unset;
  double friction_loss_J = unset;
  double damping_loss_J = unset;
  double boundary_kinetic_J = unset;
  double energy_residual_relative = unset;
  double J_min = unset;
  double J_max = unset;
  double distortion_controlled_fraction = unset;
  double solid_volume_drift = unset;
};

/// Column names of series.csv, in file order.
const std::vector<std::string>& series_columns();

class SeriesWriter {
 public:
  /// RESULTS/series.csv; resume_time as in CsvWriter.
  explicit SeriesWriter(const std::filesystem::path& results, double resume_time = -1);
  void append(const SeriesRow& row);

 private:
  CsvWriter csv_;
  std::vector<std::string> cells_;
};

class ChordaeSeriesWriter {
 public:
  /// RESULTS/chordae.csv: time_s and one column per segment, see chordae_columns.
  ChordaeSeriesWriter(const std::filesystem::path& results, const Chordae& chordae, double resume_time = -1);
  /// Tension of every segment, N.
  void append(double time, std::span<const double> tensions);

 private:
  CsvWriter csv_;
  std::vector<double> values_;
};

/// "time_s", then kind_NN_leaflet_mM_N per segment, e.g. "primary_00_anterior_m0_N"; NN is the segment's index.
std::vector<std::string> chordae_columns(const Chordae& chordae);

/// A CSV file as columns of text and numbers (empty or unreadable cells are NaN).
struct SeriesTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  bool has(std::string_view column) const;
  std::vector<double> numbers(std::string_view column) const;  // NaN for each row when there is no such column
  std::vector<std::string> texts(std::string_view column) const;
};

/// Incomplete last lines are left out. Throws IoError when missing, InputError when rows differ in length.
SeriesTable read_csv(const std::filesystem::path& file);

}  // namespace mv
