// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What a scene leaves out must cost nothing: time per step of one closed valve with each part switched off.

#include <filesystem>
#include <string>
#include <vector>

#include "solver/study/step_timing.h"

namespace mv {

struct ScenePart {
  std::string name;      // "no friction"
  std::string setting;   // "contact.friction=0"; empty for the full scene
  std::size_t part = 0;  // the part of part_names() that it touches
  StepTiming timing;
  std::string failure;   // why it could not be timed, "" when it was
};

/// The full scene first. It is advanced to `at` (s); the variants start from its positions, velocities and flow, so that all do the same work but for what
/// they leave out. `state`, when given, is that instant already.
std::vector<ScenePart> time_scene_parts(const std::filesystem::path& case_directory, double at, int steps, int repeats, const State* state = nullptr);

/// The same for the generic valve at a fluid spacing, in a tube that is long enough on the atrial side for the scene without chordae. The case is made in `output`/cases.
std::vector<ScenePart> time_generic_scene_parts(const std::filesystem::path& output, const std::filesystem::path& mvprep, double fluid_mm, double at, int steps, int repeats);

/// CSV with one row a variant: name, setting, ms per step of every part and in all, difference to the full scene.
std::string scene_parts_csv(const std::vector<ScenePart>& parts);

/// Bars and table with what they say, for a page.
std::string scene_parts_html(const std::vector<ScenePart>& parts);

}  // namespace mv
