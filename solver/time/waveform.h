// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/core/config.h"

namespace mv {

/// Ventricular minus atrial pressure (Pa) over time (s).
class Waveform {
 public:
  /// From pressure.* of the configuration; a CSV is sought next to the configuration, then in `case_directory`.
  /// Throws InputError (file, column, row), ConfigError.
  static Waveform from_config(const Config& config, const std::filesystem::path& case_directory);

  /// Piecewise linear through (time, pressure); constant outside. Times must increase.
  static Waveform from_table(std::vector<double> times, std::vector<double> pressures);

  double at(double time) const;
  double largest() const;  // largest magnitude, Pa

 private:
  enum class Kind { systolic, ramp, smooth, table } kind_ = Kind::systolic;
  double peak_ = 0, rise_time_ = 0, shift_ = 0;
  std::vector<double> times_, pressures_;
};

}  // namespace mv
