// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "solver/report/pictures.h"
#include "solver/report/results_data.h"

namespace mv {

/// Text that the build puts into the program (assets.cmake).
namespace assets {
extern const std::string_view style_css, figures_js, plotly_js;
}

/// The whole page. `stress_scale` in kPa, 0 when there are no stress pictures.
std::string make_page(const ResultsData& data, const std::optional<MapView>& view, const std::vector<Picture>& pictures, double stress_scale);

}  // namespace mv
