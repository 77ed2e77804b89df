// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The generic closure at several settings: which runs there are, running them, and what they say.

#include <filesystem>
#include <string>
#include <vector>

#include "solver/study/study_table.h"

namespace mv {

/// One run: a mesh and run-time settings that differ from the baseline.
struct Rung {
  std::string name;                   // folder in DIR/runs
  std::string axis, what;             // see StudyRow
  ClosureMesh mesh;
  std::vector<std::string> settings;  // key=value besides the common ones
};

struct LadderOptions {
  std::filesystem::path output;
  std::filesystem::path mvprep;             // empty: beside mvsolve
  // Fluid, coarse to fine; the finest is the reference. The tube's 40 and 20 mm are whole cells of each: rounded up, a longer tube would hold its blood back
  // (63 mm at 3 mm: 5 %), and the ladder would measure that.
  std::vector<double> spacings_mm{2.5, 2, 1.25, 1};
  double end = 0.15;                        // s simulated; the valve closes at about 45 ms
  double window = 0.03;                     // s at the end over which oscillating quantities are averaged
  bool has_variations = true;
  double budget = 1800;                     // s of wall time for all runs that are not there yet; one runs in any case when there is none
  int jobs = 1;                             // runs at a time, one thread each
  bool is_fresh = false;                    // run again what is there
};

/// Resolution rungs first, then variations: solid spacing and order, step, kernel, coupling, search interval at the second coarsest spacing, and those
/// that save time at the finer ones.
std::vector<Rung> closure_ladder(const LadderOptions& options);

/// Settings of every run of the ladder besides its own.
std::vector<std::string> ladder_settings(const LadderOptions& options);

/// Makes the cases, runs what is not in DIR/runs yet (by hash of case and settings), as the budget allows, and reads the results. A rung that is left out or
/// fails is in the table with its reason. Reference: the finest resolution; uncertainty by Richardson from the three finest ones.
StudyTable closure_table(const LadderOptions& options);

/// The table from rows that have values: references from the resolution rows. Throws TrustError when none of them has values.
void put_closure_reference(StudyTable& table);

}  // namespace mv
