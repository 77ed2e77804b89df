// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "solver/output/summary.h"

namespace mv {

struct TrustGate {
  std::string name;
  std::string value;  // with its unit
  std::string limit;
  bool is_passed = false;
};

enum class Finding { sealed, leaks, none };

struct Verdict {
  Finding finding = Finding::none;
  bool is_trustworthy =
      false;         // the run came to its end, and trust.passed of the summary holds (without it: every gate here passed)
  std::string word;  // "Sealed", "Leaks through 2 holes", "No verdict", with a reservation when not trustworthy
  std::vector<std::string> sentences;  // HTML
  std::vector<TrustGate> gates;
};

/// Limits of the report's own gates, used where summary.json has no list trust.gates of {name, value, limit, passed}.
inline constexpr double energy_residual_limit = 0.05;      // of the total work
inline constexpr double volume_drift_limit = 0.01;         // of the solid's volume
inline constexpr double distortion_fraction_limit = 0.01;  // of the elements

Verdict make_verdict(const Json& summary);

}  // namespace mv
