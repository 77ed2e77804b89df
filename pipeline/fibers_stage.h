// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/stage.h"

namespace mv {

/// Completes leaflets.vtu with the collagen directions; zero vectors for fibers.model = "none".
std::string run_fibers_stage(const StageContext& context);

}  // namespace mv
