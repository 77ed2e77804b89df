// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "solver/report/map_view.h"
#include "solver/report/results_data.h"

namespace mv {

/// The numbers behind the page's figures, as page/figures.js reads them: time_ms, series (per column), limiter, chordae, map,
/// holes, interruptions, closing_ms, papillary. `pressure_scale`: upper end of the map's colours, kPa. Parts without data are
/// absent. Numbers carry four to five significant digits; more than 2000 rows are thinned.
Json figure_data(const ResultsData& data, const std::optional<MapView>& view, double pressure_scale);

}  // namespace mv
