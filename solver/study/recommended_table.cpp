// SPDX-License-Identifier: BSD-3-Clause
// Repeat with: mvsolve accuracy -o DIR --table solver/study/recommended_table.cpp
#include "solver/study/recommended.h"

namespace mv {

const std::vector<RecommendedSettings>& recommended_table() {
  static const std::vector<RecommendedSettings> table;
  return table;
}

}  // namespace mv
