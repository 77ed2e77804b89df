// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "solver/study/stability.h"

namespace mv {

/// stability.html, self-contained: counts, the table case by case, and what was checked. `seconds` is the whole command's wall time.
std::string stability_page(const std::vector<StabilityRow>& rows, double seconds, int jobs);

}  // namespace mv
