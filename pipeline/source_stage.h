// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The first stage: whatever the user brings becomes a mid-surface with annulus, leaflets, papillary tips and a flat pattern.

#include <string>
#include <vector>

#include "pipeline/source_file.h"
#include "pipeline/stage.h"

namespace mv {

/// One kind of source: a value of source.kind and a command of mvprep.
struct SourceKind {
  std::string name;
  std::string help;
  SourceGeometry (*make)(const Config&);
};

/// Every kind that this build knows.
const std::vector<SourceKind>& source_kinds();

/// Builds what source.kind asks for, without writing anything. Throws ConfigError, IoError, InputError, GateError.
SourceGeometry make_source(const Config& config);

/// Writes mid_surface.vtp, papillary.vtp and source.json (kind, what was found, measures, notes; notes are logged as warnings
/// too).
std::string run_source_stage(const StageContext& context);

}  // namespace mv
