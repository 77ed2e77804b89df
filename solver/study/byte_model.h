// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The least memory traffic of a step: every array that a part needs is read once and written once, nothing is read twice, caches are
// as large as needed between the loops of one part and empty between parts. With B bytes of a part and the triad's bandwidth W no step can be
// shorter than B / W, unless a part's arrays stay in the caches from one step to the next; B / (W t) is the share of the limit reached.
//
//   fluid     per padded grid value: velocity r+w (6), old rate r+w (6), force r (3), pressure r+w (2), Poisson right side w+r (2), potential w+r (2): 21 doubles
//   coupling  per padded grid value: force density zeroed and added to (6), read back for what the blood does not see (3), velocity read (3): 12 doubles;
//             per node: forces (3), x and v r+w (12), mean volume (3), volume and step (2), unseen (3), shift r+w (6): 29 doubles
//   tissue    per linear element: inverse reference matrix (9), volume, fibre (3): 13 doubles, 4 indices and a law: 20 bytes; a quadratic one has
//             four such points and 10 indices; per node: x r, force r+w (9 doubles)
//   contact   per surface node: x, v r, force r+w, slip r+w (18 doubles); per surface face 3 indices; per candidate pair 2 indices

#include <string>

#include "solver/study/step_timing.h"

namespace mv {

/// Sizes of a scene that set the cost of a step.
struct SceneSize {
  double cells = 0;          // of the fluid box, 0 without blood
  double grid_values = 0;    // padded
  double nodes = 0, elements = 0;
  int points_per_element = 1, nodes_per_element = 4;
  double surface_nodes = 0, surface_faces = 0, candidate_pairs = 0;
};

SceneSize size_of(const Simulation& simulation);

/// Bytes per step of fluid, coupling, tissue and contact; 0 for the parts the model does not count. Index as in part_names().
std::array<double, part_count> least_bytes(const SceneSize& size);

}  // namespace mv
