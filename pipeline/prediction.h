// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What a run of mvsolve will cost: a small model calibrated on measured runs (README.md).

#include <string>

#include "geometry/core/config.h"

namespace mv {

struct CaseSize {
  long points = 0;  // solid points
  long tets = 0;
  int order = 1;
  long fluid_cells = 0;  // 0 without fluid
  double edge_mean = 0;  // mm, mean edge of the mid-surface triangles
};

struct Prediction {
  double memory_mb = 0;
  double step_s = 0;    // stable step
  std::string limiter;  // what sets it
  double steps = 0;
  double seconds_per_step = 0;
  double run_s = 0;  // wall time on two cores
};

Prediction predict_run(const Config& config, const CaseSize& size);

/// Builds the geometry in memory, writes nothing. Throws what the stages throw.
CaseSize measure_case(const Config& config);

}  // namespace mv
