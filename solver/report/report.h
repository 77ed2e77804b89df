// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// RESULTS/report.html: one page with everything in it (styles, script, data, pictures; no network), made from RESULTS alone.

#include <filesystem>

namespace mv {

/// Reads RESULTS/ (summary.json, run.json, series.csv, chordae.csv, leaflets.pvd and chordae.pvd with their first and last
/// frames, contact_map.vtp, case/quality.json, case/case.toml, case/manifest.json), writes RESULTS/pictures/*.png and
/// RESULTS/report.html and returns the latter's path. Only summary.json must be there; a section whose source is missing says so.
/// Same input, same bytes. Throws InputError (damaged file), IoError (no such directory, no summary.json, disk full).
std::filesystem::path write_report(const std::filesystem::path& results);

}  // namespace mv
