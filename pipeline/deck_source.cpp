// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/deck_source.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "geometry/annulus/annulus_check.h"
#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/log.h"
#include "geometry/deck/deck_chordae.h"
#include "geometry/deck/ring_pattern.h"
#include "geometry/generic/generic_valve.h"
#include "pipeline/patient_source.h"

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<Vec3> normals_of(const DeckValve& valve) {
  std::vector<Vec3> normals(valve.points.size(), Vec3::Zero());
  for (const auto& t : valve.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &p = valve.points[at(t[k])], a = valve.points[at(t[(k + 1) % 3])] - p, b = valve.points[at(t[(k + 2) % 3])] - p;
      const Vec3 normal = a.cross(b);
      // Weighted by the angle at the corner, so that the split of a quad does not tilt it.
      normals[at(t[k])] += std::atan2(normal.norm(), a.dot(b)) * normal.normalized();
    }
  }
  for (Vec3& n : normals) n.normalize();
  return normals;
}

std::vector<Vec3> points_at(const DeckValve& valve, const std::vector<int>& which) {
  std::vector<Vec3> out;
  for (const int p : which) out.push_back(valve.points[at(p)]);
  return out;
}

/// From the annulus' centre towards the anterior leaflet, in the annulus plane.
Vec3 anterior_direction(const DeckValve& valve, const Annulus& annulus) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t t = 0; t < valve.triangles.size(); ++t)
    if (valve.region[t] == anterior)
      for (const int p : valve.triangles[t]) sum += valve.points[at(p)] - annulus.origin;
  Vec3 direction = sum - sum.dot(annulus.normal) * annulus.normal;
  return direction.norm() > 1e-9 ? Vec3(direction.normalized()) : Vec3(annulus.axis_major.cross(annulus.normal));
}

Papillary papillary_of(const DeckValve& valve) {
  Papillary papillary;
  papillary.tips = valve.tips;
  for (std::size_t t = 0; t < valve.tips.size(); ++t) papillary.names.push_back(fmt::format("papillary_{}", t + 1));
  return papillary;
}

SourceGeometry remeshed(const Config& config, const DeckValve& valve) {
  if (std::any_of(valve.region.begin(), valve.region.end(), [](int r) { return r != anterior && r != posterior; }))
    throw ConfigError("key 'deck.remesh': only valves of an anterior and a posterior leaflet are remeshed; set it to false to keep the deck's own nodes");
  RawLeaflets raw;
  raw.points = valve.points;
  raw.triangles = valve.triangles;
  raw.region = valve.region;
  if (!valve.has_uniform_thickness) raw.thickness = valve.thickness;
  raw.annulus_curve = points_at(valve, valve.annulus);
  raw.papillary_points = valve.tips;
  raw.notes = valve.notes;
  return make_patient_source(config, std::move(raw));
}

/// Only the source stage's own mid-surface has the deck's points column by column.
void need_own_nodes(const Config& config, const char* key) {
  if (config.text("source.kind") == "deck" && !config.flag("deck.remesh")) return;
  throw ConfigError(fmt::format("key '{}': the deck's own can be used with source.kind = \"deck\" and deck.remesh = false only", key));
}

}  // namespace

DeckValve read_deck_valve(const Config& config) {
  if (config.text("deck.file").empty()) throw ConfigError("key 'deck.file' is empty; source.kind = \"deck\" needs an Abaqus input file");
  DeckValveOptions options;
  options.units = config.text("deck.units");
  options.leaflets = config.texts("deck.leaflets");
  options.merge_chains = config.flag("deck.merge_chains");
  options.thickness = config.number_in("mesh.thickness", "mm");
  return build_deck_valve(read_abaqus_deck(config.path("deck.file")), options);
}

SourceGeometry make_deck_source(const Config& config) {
  const DeckValve valve = read_deck_valve(config);
  if (config.flag("deck.remesh")) return remeshed(config, valve);
  SourceGeometry source;
  MidSurface& surface = source.surface;
  surface.points = valve.points;
  surface.triangles = valve.triangles;
  surface.region = valve.region;
  surface.normals = normals_of(valve);
  surface.on_annulus.assign(valve.points.size(), 0);
  surface.on_free_edge.assign(valve.points.size(), 0);
  for (const int p : valve.annulus) surface.on_annulus[at(p)] = 1;
  for (const int p : valve.free_edge) surface.on_free_edge[at(p)] = 1;
  if (!valve.has_uniform_thickness) surface.thickness = valve.thickness;
  const RingPattern pattern = unfold_ring(valve.points, valve.triangles, valve.annulus, valve.free_edge);
  surface.unfolded = pattern.unfolded;
  surface.perimeter = pattern.perimeter;
  source.notes = valve.notes;
  if (const double area = smallest_unfolded_area(pattern, valve.triangles); !(area > 0))
    source.notes.push_back(fmt::format("the flat pattern has folds (smallest triangle {:.3g} mm2): maps on it overlap there", area));
  source.annulus_curve = points_at(valve, valve.annulus);
  source.papillary = papillary_of(valve);

  NormalHints hints;
  hints.papillary_points = valve.tips.empty() ? points_at(valve, valve.free_edge) : valve.tips;
  const std::string file = config.path("deck.file").string();
  const auto add = [&](const std::vector<std::string>& notes) { source.notes.insert(source.notes.end(), notes.begin(), notes.end()); };
  try {
    add(check_annulus_curve(clean_closed_curve(source.annulus_curve, nullptr, file), file));
    if (!valve.tips.empty()) add(check_papillary_points(valve.tips, source.annulus_curve, file));
  } catch (const InputError& e) {
    throw InputError(std::string(e.what()) + " (deck.units = \"" + config.text("deck.units") + "\")");
  }
  const Annulus annulus = fit_annulus(source.annulus_curve, hints);
  surface.axis = annulus.normal;
  source.anterior_direction = anterior_direction(valve, annulus);
  source.scale = surface.perimeter / generic_perimeter(GenericValveParameters{});

  std::map<int, int> count;
  for (const int r : valve.region) ++count[r];
  std::string leaflets;
  for (const auto& [region, triangles] : count) {
    leaflets += fmt::format("{}{} {}", leaflets.empty() ? "" : ", ", leaflet_name(region), triangles);
    source.measures["leaflets." + leaflet_name(region) + "_triangles"] = triangles;
  }
  double moved = 0;
  for (const Vec3& u : valve.annulus_displacement) moved = std::max(moved, u.norm());
  source.measures["annulus.points"] = valve.annulus.size();
  source.measures["annulus.displacement_max_mm"] = moved;
  source.measures["chordae.segments"] = valve.chordae.segments.size();
  source.measures["papillary.tips"] = valve.tips.size();
  source.summary = fmt::format("{} points, triangles: {}; annulus of {} points moves {:.2f} mm at most; {} chordae segments on {} papillary tips", valve.points.size(), leaflets,
                               valve.annulus.size(), moved, valve.chordae.segments.size(), valve.tips.size());
  return source;
}

Chordae make_deck_chordae(const Config& config, const LeafletMesh& mesh) {
  need_own_nodes(config, "chordae.model");
  return hang_chordae(read_deck_valve(config), mesh, static_cast<int>(config.integer("mesh.layers")));
}

void take_deck_fibres(const Config& config, LeafletMesh& mesh) {
  need_own_nodes(config, "fibers.model");
  const DeckValve valve = read_deck_valve(config);
  if (valve.fibre.empty()) throw InputError(config.path("deck.file").string() + ": not every section of the leaflets has an orientation; choose another fibers.model");
  const std::size_t per_triangle = 3 * static_cast<std::size_t>(config.integer("mesh.layers"));
  if (mesh.tets.size() != per_triangle * valve.fibre.size()) throw InputError("leaflets.vtu does not belong to the deck's mesh; run all stages again");
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const Vec3 &f = valve.fibre[e / per_triangle], &n = mesh.sheet_normal[e];
    const Vec3 tangent = f - f.dot(n) * n;
    // An orientation straight through the shell says nothing; the direction along the annulus stands.
    if (tangent.norm() > 1e-6) mesh.fibre[e] = tangent.normalized();
  }
}

}  // namespace mv
