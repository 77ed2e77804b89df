// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which runs are worth their time, and which one to recommend for an asked error.

#include <limits>
#include <string>
#include <vector>

namespace mv {

/// One run on an error-time chart. NaN error: unknown (the run failed, or the quantity is missing).
struct CostError {
  double seconds = 0;
  double error = std::numeric_limits<double>::quiet_NaN();
};

/// Indices of the points that no other point beats: none is at most as long and at most as wrong, and better in one of the two. Sorted by seconds;
/// equal points stand once (the first). Points with an unknown or infinite error or time are never on the front.
std::vector<std::size_t> pareto_front(const std::vector<CostError>& points);

/// Errors of one run, per quantity (the same quantities in the same order for all runs of a table).
struct RunErrors {
  std::string run;
  double seconds = 0;
  std::vector<double> errors;  // in per cent; NaN: unknown
};

/// What to run for an asked error.
struct Recommendation {
  double asked = 0;                   // per cent
  int run = -1;                       // index of the run, -1 when no run gives any quantity
  std::vector<std::size_t> met;       // quantities this run gives within the asked error
  std::vector<std::size_t> not_met;   // the others
  std::vector<double> best_error;     // per quantity the smallest error of any run, per cent (NaN: no run gives it)
  std::vector<int> cheapest;          // per quantity the cheapest run within the asked error, -1 for none
};

/// A quantity that no run gives within the asked error is wanted as good as the runs have it, within this factor.
inline constexpr double recommendation_slack = 1.25;

/// The target of a quantity is the asked error, or `recommendation_slack` times the smallest error of any run where that is larger. Of all runs the one that meets most
/// targets, of those the cheapest; of equal ones the first. So a cheap run is not preferred because most quantities are out of reach anyway.
Recommendation recommend(const std::vector<RunErrors>& runs, double asked);

}  // namespace mv
