// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From a raw patient mid-surface to the one that the mesher, the chordae, the fibres and the contact map need: annulus and free edge told
// apart, leaflets and commissures, even triangles, normals towards the atrium, and a bijective flat pattern (u, v).

#include <string>
#include <vector>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/generic/mid_surface.h"
#include "geometry/surface/raw_leaflets.h"

namespace mv {

struct LeafletSurfaceOptions {
  int layers = 2;                 // of tetrahedra, and the smallest dihedral angle they must have (degrees): the thickness gives way where it can
  double dihedral_min = 10;
  double spacing = 0.5;           // mm, largest edge on the faces of the thick leaflets
  double thickness = 1;           // mm, where raw.thickness is empty
  double thickness_min = 0.3;     // mm, measured thickness is kept within these
  double thickness_max = 4;
  int annulus_harmonics = 12;     // Fourier harmonics kept of the annulus; 0 takes it as it is
  double smoothing = 4;           // mm, wavelength that the surface keeps by half; shorter ones (voxels, triangles) vanish, longer ones stay
  double commissure_gap = 5;      // mm, separate leaflets whose annulus ends are no further apart are joined
};

struct LeafletSurfaceReport {
  double annulus_moved_rms = 0, annulus_moved_max = 0;    // mm, by smoothing
  double surface_moved_mean = 0, surface_moved_max = 0;   // mm, distance of the result from the raw surface
  double area_anterior = 0, area_posterior = 0;           // mm2, mid-surface
  double free_edge_length = 0;                            // mm
  double edge_min = 0, edge_mean = 0, edge_max = 0;       // mm
  double angle_min = 0, angle_max = 0;                    // degrees
  double area_distortion_max = 0;                         // of the flat pattern
  std::string region_rule, annulus_rule, normal_rule;     // which evidence decided
  std::vector<std::string> notes;
};

struct LeafletSurface {
  // unfolded: u in [0, perimeter) along the annulus, counter-clockwise seen from the atrium, 0 at the commissure behind which the anterior leaflet
  // follows; v = 0 at the annulus, arc length along the column u (mm). thickness: per point; empty when raw.thickness is and options.thickness fits.
  MidSurface surface;
  Annulus annulus;                 // smoothed curve, plane and direction
  Vec3 anterior_direction = Vec3::UnitY();
  Papillary papillary;             // two tips; empty when the data hold none
  LeafletSurfaceReport report;
};

/// Throws InputError naming the defect (no ring, two annuli, torn off, one leaflet only, regions swapped beyond doubt, not orientable, not finite)
/// with what was found and what to do, GateError when no mesh of the wanted quality comes out.
LeafletSurface build_leaflet_surface(const RawLeaflets& raw, const LeafletSurfaceOptions& options);

}  // namespace mv
