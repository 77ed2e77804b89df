// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// `mvprep layout`: finds a chordae layout with which a valve seals, by closing it again and again in coarse blood and changing the chordae
// near what is left open (layout_rules.h).

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

struct LayoutOptions {
  std::filesystem::path config;
  std::filesystem::path directory;       // trials, layout.csv, layout.toml, trials.csv
  std::vector<std::string> settings;     // --set, for every trial
  std::filesystem::path mvsolve;         // empty: beside the running program
  double target_area = 5;                // mm2
  int trials = 12;
  std::string fluid_spacing = "2 mm";
  std::string time_end = "0.15 s";       // at most what the configuration says
  int threads = 1;
};

/// Trial 1 takes the configuration's chordae; each later one the best so far with one change a hole. A change that does not make its hole
/// smaller is taken back and not tried again. Ends when the holes are no larger than the target, the trials are used up or nothing is left to
/// try. Deterministic. Writes trials.csv (one row a trial), layout.csv (the best network, for chordae.model = "file") and layout.toml (the
/// keys that use it). Throws GateError when the target is missed (layout.csv holds the best all the same), IoError when mvsolve cannot
/// be run, and what the stages throw.
void layout_command(const LayoutOptions& options);

}  // namespace mv
