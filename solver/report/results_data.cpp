// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/results_data.h"

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/output/frame_writer.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored);
}

Json json_or_null(const fs::path& file) { return is_there(file) ? read_json(file) : Json(); }

/// First and last frame of a collection.
template <class Frame, class Read>
void read_ends(const fs::path& results, const char* collection, Read&& read, std::optional<Frame>& first,
               std::optional<Frame>& last) {
  const std::vector<PvdEntry> entries = read_pvd(results / collection);
  if (!entries.empty()) first = read(results / entries.front().file);
  if (entries.size() > 1) last = read(results / entries.back().file);
}

}  // namespace

ResultsData read_results(const fs::path& results) {
  std::error_code ignored;
  if (!fs::is_directory(results, ignored)) throw IoError(results.string() + ": no such folder");
  if (!is_there(results / "summary.json"))
    throw IoError((results / "summary.json").string() + ": no such file; is this the output folder of 'mvsolve run'?");
  ResultsData data;
  data.summary = read_json(results / "summary.json");
  data.run = json_or_null(results / "run.json");
  data.quality = json_or_null(results / "case" / "quality.json");
  data.manifest = json_or_null(results / "case" / "manifest.json");
  if (is_there(results / "case" / "case.toml")) data.case_toml = read_file(results / "case" / "case.toml");
  if (is_there(results / "series.csv")) data.series = read_csv(results / "series.csv");
  if (is_there(results / "chordae.csv")) data.chordae = read_csv(results / "chordae.csv");
  read_ends<LeafletsFrame>(results, "leaflets.pvd", read_leaflets_frame, data.frames.open, data.frames.closed);
  read_ends<ChordaeFrame>(results, "chordae.pvd", read_chordae_frame, data.frames.open_chordae, data.frames.closed_chordae);
  if (is_there(results / "contact_map.vtp")) data.map = read_contact_map(results / "contact_map.vtp");
  return data;
}

}  // namespace mv
