// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/fiber_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fibers/guides.h"
#include "fibers/nematic.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void check_arrays(const LeafletMesh& mesh) {
  if (mesh.tets.empty()) throw InputError("fibers: the leaflet mesh is empty; run the mesh stage first");
  if (mesh.sheet_normal.size() != mesh.tets.size() || mesh.region.size() != mesh.tets.size())
    throw InputError("fibers: the leaflets have no sheet_normal or region; run the mesh stage first");
}

}  // namespace

FiberModel fiber_model_from_name(std::string_view name) {
  if (name == "none") return FiberModel::none;
  if (name == "parallel") return FiberModel::parallel;
  if (name == "arc") return FiberModel::arc;
  if (name == "outline") return FiberModel::outline;
  if (name == "chordae") return FiberModel::chordae;
  throw ConfigError("fibers.model = \"" + std::string(name) + "\": expected none, parallel, arc, outline or chordae");
}

std::vector<Vec3> parallel_fibers(const LeafletMesh& mesh, const Vec3& normal) {
  check_arrays(mesh);
  if (!normal.allFinite() || !(normal.norm() > 0)) throw InputError("fibers: the annulus normal is not a direction");
  const Vec3 n = normal.normalized();
  std::vector<Vec3> fibres(mesh.tets.size(), Vec3::Zero());
  std::vector<int> all, flat;
  std::vector<GivenDirection> given;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    all.push_back(static_cast<int>(e));
    const Vec3 direction = n.cross(mesh.sheet_normal[e]);
    if (!(direction.norm() >= flat_sine)) {
      flat.push_back(static_cast<int>(e));
      continue;
    }
    fibres[e] = direction.normalized();
    for (std::size_t i = 0; i < 4; ++i)
      given.push_back({mesh.tets[e][i], fibres[e], 1});
  }
  if (flat.empty()) return fibres;
  if (given.empty())
    throw InputError(
        "fibers: the leaflets lie in the annulus plane, so \"parallel\" has no direction; use fibers.model = \"arc\"");
  const NematicField field = diffuse_directions(mesh, all, given);
  for (int e : flat)
    fibres[at(e)] = field.directions[at(e)];
  return fibres;
}

std::vector<Vec3> arc_fibers(const LeafletMesh& mesh, const FiberOptions& options) {
  check_arrays(mesh);
  std::vector<Vec3> fibres(mesh.tets.size(), Vec3::Zero());
  for (int region : {static_cast<int>(anterior), static_cast<int>(posterior)}) {
    std::vector<int> elements;
    for (std::size_t e = 0; e < mesh.tets.size(); ++e)
      if (mesh.region[e] == region) elements.push_back(static_cast<int>(e));
    if (elements.empty()) continue;
    std::vector<GivenDirection> given;
    for (const GuidePoint& g : guide_points(mesh, region, options)) given.push_back(g.given);
    const NematicField field = diffuse_directions(mesh, elements, given);
    for (std::size_t k = 0; k < elements.size(); ++k)
      fibres[at(elements[k])] = field.directions[k];
  }
  return fibres;
}

void assign_fibers(LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options) {
  switch (options.model) {
    case FiberModel::none:
      mesh.fibre.assign(mesh.tets.size(), Vec3::Zero());
      return;
    case FiberModel::parallel:
      mesh.fibre = parallel_fibers(mesh, annulus.normal);
      return;
    case FiberModel::arc:
    case FiberModel::outline:
    case FiberModel::chordae:
      mesh.fibre = arc_fibers(mesh, options);
      return;
  }
}

FiberReport check_fibers(const LeafletMesh& mesh, FiberModel model, double tolerance) {
  FiberReport report;
  report.elements = static_cast<int>(mesh.tets.size());
  if (mesh.fibre.size() != mesh.tets.size() || mesh.sheet_normal.size() != mesh.tets.size()) {
    report.message = "fibre or sheet_normal is missing: " + std::to_string(mesh.fibre.size()) + " and " +
                     std::to_string(mesh.sheet_normal.size()) + " entries for " + std::to_string(mesh.tets.size()) + " elements";
    return report;
  }
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Vec3& f = mesh.fibre[e];
    std::string reason;
    if (!f.allFinite()) {
      ++report.non_finite;
      reason = "is not finite";
    } else if (model == FiberModel::none) {
      if (!f.isZero(0)) reason = "is not zero although fibers.model is none";
    } else {
      const double unit = std::abs(f.norm() - 1), tangent = std::abs(f.dot(mesh.sheet_normal[e]));
      report.unit_error_max = std::max(report.unit_error_max, unit);
      report.tangent_error_max = std::max(report.tangent_error_max, tangent);
      if (!(unit <= tolerance))
        reason = "has length " + std::to_string(f.norm());
      else if (!(tangent <= tolerance))
        reason = "leaves the tangent plane: fibre . sheet_normal = " + std::to_string(f.dot(mesh.sheet_normal[e]));
    }
    if (!reason.empty() && report.first_bad_element < 0) {
      report.first_bad_element = static_cast<int>(e);
      report.message = "fibre of element " + std::to_string(e) + " " + reason;
    }
  }
  report.passed = report.first_bad_element < 0 && report.elements > 0;
  return report;
}

}  // namespace mv
