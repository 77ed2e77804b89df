// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "solver/time/state.h"

namespace mv {

/// What a run needs to go on exactly where it stopped.
struct Checkpoint {
  State state;
  State snapshot;          // the state a rollback would return to
  bool has_snapshot = false;
  long next_series = 0, next_frame = 0, next_fluid = 0, next_checkpoint = 0;  // output counters
  double leak_volume_before = 0, leak_time_before = 0;
  std::vector<std::pair<double, double>> leak_samples;  // time (s), net volume passed (m3)
  double peak_velocity = 0, volume_drift_max = 0;       // of the run so far
  std::string limiter = "start";  // of the last step that was not shortened for output
  double wall_seconds = 0;
  std::string case_hash;   // of the case and its settings; a different one cannot be resumed
};

/// RESULTS/checkpoint/state.bin, written atomically, with a checksum. Throws IoError.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

/// Throws IoError (missing) and InputError (damaged, other version, sizes that do not fit).
Checkpoint read_checkpoint(const std::filesystem::path& file);

}  // namespace mv
