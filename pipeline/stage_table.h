// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "pipeline/stage.h"

namespace mv {

/// The pipeline: every stage in the order in which it runs.
const std::vector<Stage>& stage_table();

/// Throws UsageError with the nearest name for an unknown stage.
const Stage& find_stage(const std::string& name);

/// Names of the stages that read what `name` makes, directly or through others, in order.
std::vector<std::string> stages_after(const std::string& name);

}  // namespace mv
