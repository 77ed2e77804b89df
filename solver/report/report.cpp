// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/report.h"

#include <algorithm>
#include <string>
#include <system_error>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/report/page.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

void write_pictures(const fs::path& folder, const std::vector<Picture>& pictures, const std::optional<Picture>& map) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw IoError(folder.string() + ": cannot create the folder: " + error.message());
  const auto write = [&](const Picture& p) { write_text_atomically(folder / (p.name + ".png"), p.png); };
  for (const Picture& p : pictures) write(p);
  if (!map) return;
  write(*map);
  const auto named = [&](const char* name) {
    return std::find_if(pictures.begin(), pictures.end(), [&](const Picture& p) { return p.name == name; });
  };
  if (const auto from_atrium = named("closed_atrial"), cut = named("closed_cut");
      from_atrium != pictures.end() && cut != pictures.end())
    write(draw_overview(*from_atrium, *cut, *map));
}

}  // namespace

fs::path write_report(const fs::path& results) {
  const ResultsData data = read_results(results);
  Scales scales;
  if (data.frames.closed)
    scales = {pressure_scale_of(data.frames.closed->contact_pressure), stress_scale_of(*data.frames.closed)};
  if (data.map) scales.pressure = std::max(1e-3, pressure_scale_of(data.map->contact_pressure));
  std::optional<MapView> view;
  std::optional<Picture> map_picture;
  if (data.map) {
    view = make_map_view(*data.map, data.frames.open, data.frames.open_chordae);
    map_picture = draw_contact_map(*data.map, *view, scales.pressure);
  }
  const std::vector<Picture> pictures = draw_valve(data.frames, scales.pressure, scales.stress);
  write_pictures(results / "pictures", pictures, map_picture);
  const fs::path page = results / "report.html";
  write_text_atomically(page, make_page(data, view, pictures, scales));
  return page;
}

}  // namespace mv
