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

/// Upper ends of the colour scales, kPa; 0 when nothing is drawn with them.
struct Scales {
  double pressure = 0;
  double stress = 0;
};

/// The whole page.
std::string make_page(const ResultsData& data, const std::optional<MapView>& view, const std::vector<Picture>& pictures,
                      const Scales& scales);

}  // namespace mv
