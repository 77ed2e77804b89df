// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From clean triangles to one ring with two borders, annulus and free edge. Internal to mv_unfold.

#include "geometry/surface/leaflet_surface.h"
#include "geometry/unfold/raw_mesh.h"

namespace mv {

struct Ring {
  RawMesh mesh;
  std::vector<int> annulus;    // points in order, running as the triangles do
  std::vector<int> free_edge;  // same
  std::string annulus_rule;    // which evidence told them apart
  bool has_regions = false;    // regions split the ring into two leaflets ...
  bool has_names = false;      // ... and the source says which is which
};

/// One connected part with two large borders is a ring; its further borders are holes and are filled. Two parts with one large border each are leaflets:
/// their annulus ends are found (nearest to each other and, with an annulus curve, to it, else highest on the atrial side) and the commissures between
/// them bridged. Parts below 5 % of the largest are dropped. Throws InputError: one leaflet only, two rings, more parts, handles, no border, holes of more
/// than 20 % of the area, ends further apart than options.commissure_gap, no evidence for the annulus. The ring's
/// edges are split to 1 mm.
Ring make_ring(const RawMesh& clean, const RawLeaflets& raw, const LeafletSurfaceOptions& options, std::vector<std::string>& notes);

/// Direction from atrium to ventricle, as far as known before there is an annulus: given, papillary points, annulus curve and where the
/// leaflets hang from it; else none.
std::optional<Vec3> downward(const RawMesh& mesh, const RawLeaflets& raw);

/// Joins two leaflets (parts with one border each) at both commissures.
RawMesh join_leaflets(RawMesh a, RawMesh b, const RawLeaflets& raw, double largest_gap, std::vector<std::string>& notes);

}  // namespace mv
