// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "fibers/fiber_field.h"
#include "pipeline/stage.h"

namespace mv {

/// Completes leaflets.vtu with the collagen directions; zero vectors for fibers.model = "none".
std::string run_fibers_stage(const StageContext& context);

/// What the configuration asks for; `chordae` must outlive the result. Reads fibers.outline.
FiberOptions fiber_options(const Config& config, const Chordae& chordae);

}  // namespace mv
