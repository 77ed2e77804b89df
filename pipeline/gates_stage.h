// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/stage.h"

namespace mv {

/// Checks everything, writes quality.json and throws GateError naming each failed gate, its element and the reason.
std::string run_gates_stage(const StageContext& context);

}  // namespace mv
