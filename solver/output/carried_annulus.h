// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where the held nodes of the mesh have carried the annulus.

#include <span>

#include "geometry/core/case.h"

namespace mv {

/// `rest` (mm) with each point moved as the held node next to it, `points` being the mesh's present positions (mm): the origin by the mean of that, normal and axis turned as the area
/// vector of the curve is. Curve and plane of an annulus that has not moved are left to the last digit. Eigenvalues, residual and rule stay those at rest.
Annulus carried_annulus(const Annulus& rest, const LeafletMesh& mesh, std::span<const Vec3> points);

}  // namespace mv
