// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// From what a patient source found (labels, slices, surface, deck) to what the later stages read: the last step of each of them.

#include "geometry/core/config.h"
#include "geometry/surface/leaflet_surface.h"
#include "geometry/surface/raw_leaflets.h"
#include "pipeline/source_file.h"

namespace mv {

/// Options of build_leaflet_surface from mesh.spacing, mesh.thickness and patient.*. Throws ConfigError.
LeafletSurfaceOptions leaflet_surface_options(const Config& config);

/// Puts what the configuration says itself (patient.annulus, papillary, commissures, anterior_point, ventricle_direction) in place of what the source
/// found, with a note each. Throws ConfigError, IoError, InputError naming the file.
void apply_patient_keys(const Config& config, RawLeaflets& raw);

/// The same geometry in the form of mid_surface.vtp and papillary.vtp; summary: one line. Without papillary points the generic tips
/// (generic.papillary_tips_*, scaled by the perimeter) are placed in the annulus' frame, with a note.
SourceGeometry to_source_geometry(const LeafletSurface& leaflets, const Config& config);

/// All of it: apply_patient_keys, build_leaflet_surface, its rules on the log, to_source_geometry (notes and measures go to source.json). A source makes
/// RawLeaflets and returns this. Throws what they throw.
SourceGeometry make_patient_source(const Config& config, RawLeaflets raw);

}  // namespace mv
