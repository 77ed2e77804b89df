// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/scene.h"

#include <fmt/format.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "solver/output/summary.h"

namespace mv {

Scene load_scene(const std::filesystem::path& directory, const std::vector<std::string>& settings) {
  if (!std::filesystem::is_directory(directory))
    throw IoError(fmt::format("{}: no such case directory; make one with 'mvprep run -c config.toml -o {}'", directory.string(), directory.string()));
  Scene scene;
  scene.directory = directory;
  scene.config = Config::from_case_file(directory / "case.toml");
  for (const std::string& setting : settings) scene.config.set(setting);
  scene.mesh = read_leaflets(directory / "leaflets.vtu");
  scene.annulus = read_annulus(directory / "annulus.vtp");
  scene.tube = read_tube(directory / "tube.vtu");
  scene.papillary = read_papillary(directory / "papillary.vtp");
  if (scene.config.text("chordae.model") != "none") scene.chordae = read_chordae(directory / "chordae.vtp");
  const auto quality = directory / "quality.json";
  if (!std::filesystem::exists(quality)) {
    spdlog::warn("{}: missing, so the case's gates are not known to have passed; 'mvprep check {}' makes it", quality.string(), directory.string());
  } else if (const Json& passed = json_at(read_json(quality), "passed"); passed.is_boolean() && !passed.get<bool>()) {
    throw InputError(fmt::format("{}: the case failed its gates; see there which, mend the configuration and run mvprep again", quality.string()));
  }
  // The report shows it: a damaged one must be known before the run, not after it.
  if (const auto manifest = directory / "manifest.json"; std::filesystem::exists(manifest)) read_json(manifest);
  const int points = static_cast<int>(scene.mesh.points.size());
  for (const Insertion& i : scene.chordae.insertions)
    if (i.node < 0 || i.node >= points)
      throw InputError(fmt::format("{}: insertion names leaflet point {}, leaflets.vtu has {} points; run 'mvprep chordae' again",
                                   (directory / "chordae.vtp").string(), i.node, points));
  for (int muscle : scene.chordae.muscle_of_point)
    if (muscle >= static_cast<int>(scene.papillary.tips.size()))
      throw InputError(fmt::format("{}: a root hangs on papillary tip {}, papillary.vtp has {} tips", (directory / "chordae.vtp").string(), muscle,
                                   scene.papillary.tips.size()));
  return scene;
}

}  // namespace mv
