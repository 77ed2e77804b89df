// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/mesh_stage.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/thick/thick_leaflets.h"
#include "geometry/volume/leaflet_tets.h"
#include "pipeline/interrupt.h"
#include "pipeline/labels_source.h"
#include "pipeline/surface_source.h"

namespace mv {
namespace {

bool is_thick(const Config& config) { return config.text("mesh.path") == "thick"; }

SolidSurface measured_faces(const Config& config) {
  const std::string& kind = config.text("source.kind");
  if (kind == "surface") return read_thick_surface(config);
  if (kind == "labels") return read_label_surface(config);
  throw ConfigError("key 'mesh.path' = \"thick\": source.kind = \"" + kind + "\" has no thick leaflets; expected surface or labels, or mesh.path = \"mid\"");
}

std::string told(const TetTrial& t) {
  if (!t.failure.empty()) return fmt::format("{} gives no mesh ({})", to_string(t.mesher), t.failure);
  return fmt::format("{} {} tetrahedra, angles {:.1f} to {:.1f} deg, {} below 10 deg, {} with long steps", to_string(t.mesher), t.tets, t.dihedral_min, t.dihedral_max, t.below_limit, t.too_long);
}

LeafletMesh fill(const Config& config, const SourceGeometry& source, const std::filesystem::path& directory, ThickReport& report) {
  ThickOptions options;
  options.directory = directory;
  options.spacing = config.number_in("mesh.spacing", "mm");
  options.thickness = config.number_in("mesh.thickness", "mm");
  options.layers = static_cast<int>(config.integer("mesh.layers"));
  const LeafletMesh mesh = fill_leaflets(source.surface, measured_faces(config), options, &report);
  return config.integer("mesh.order") == 2 ? to_quadratic(mesh, source.surface.perimeter) : mesh;
}

}  // namespace

LeafletMesh make_mesh(const Config& config, const SourceGeometry& source) {
  if (is_thick(config)) {
    ThickReport report;
    std::string name = (std::filesystem::temp_directory_path() / "mvprep_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw IoError(name + ": no such directory can be made for the mesher's files");
    const UnfinishedDirectory work(name);
    return fill(config, source, work.path(), report);
  }
  ThickenOptions options;
  options.thickness = config.number_in("mesh.thickness", "mm");
  options.layers = static_cast<int>(config.integer("mesh.layers"));
  options.order = static_cast<int>(config.integer("mesh.order"));
  return thicken(source.surface, options);
}

std::string run_mesh_stage(const StageContext& context) {
  const SourceGeometry source = read_source(context.in("mid_surface.vtp"));
  ThickReport report;
  const LeafletMesh mesh = is_thick(context.config) ? fill(context.config, source, context.output_directory, report) : make_mesh(context.config, source);
  write_leaflets(context.out("leaflets.vtu"), mesh);
  std::string summary = fmt::format("{} points, {} {} tetrahedra", mesh.points.size(), mesh.tets.size(), mesh.order == 2 ? "quadratic" : "linear");
  if (!is_thick(context.config)) return summary;
  for (const TetTrial& t : report.trials) spdlog::info("mesh: {}", told(t));
  summary += fmt::format(" by {}; faces {:.2f} mm from the measured ones on average ({:.2f} at most; {:.2f} and {:.2f} before they were moved there), {} points held back", to_string(report.kept),
                         report.fit.after_mean, report.fit.after_max, report.fit.before_mean, report.fit.before_max, report.fit.held_back);
  return summary;
}

}  // namespace mv
