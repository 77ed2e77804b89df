// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the annulus closes: its own tissue and whatever lies between it and the tube's wall, so that no blood passes beside the leaflets.

#include <vector>

#include "solver/coupling/rest_faces.h"
#include "solver/time/scene.h"

namespace mv {

/// Triangles (m, tube frame): the faces of the leaflets all of whose corners are held, and from their outer border straight outwards past the wall. The annulus is
/// star-shaped about the tube's axis (geometry/tube). A mesh without such faces: from the annulus' curve outwards.
std::vector<RestTriangle> annulus_barrier(const Scene& scene);

}  // namespace mv
