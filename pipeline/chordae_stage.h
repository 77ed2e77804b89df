// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "pipeline/stage.h"

namespace mv {

/// Places the chordae and their insertions. Writes chordae.vtp, an empty one for chordae.model = "none".
std::string run_chordae_stage(const StageContext& context);

}  // namespace mv
