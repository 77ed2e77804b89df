// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/byte_model.h"

namespace mv {

SceneSize size_of(const Simulation& simulation) {
  SceneSize size;
  if (const NavierStokes* fluid = simulation.fluid()) {
    size.cells = static_cast<double>(fluid->grid().cells());
    size.grid_values = static_cast<double>(fluid->grid().padded_size());
  }
  const Structure& structure = simulation.structure();
  size.nodes = structure.node_count();
  size.elements = static_cast<double>(structure.solid().element_count());
  size.nodes_per_element = structure.solid().mesh().nodes_per_tet;
  size.points_per_element = size.nodes_per_element == 10 ? 4 : 1;
  if (const SelfContact* contact = structure.contact()) {
    size.surface_nodes = structure.surface().node_count();
    size.surface_faces = static_cast<double>(structure.surface().triangles.size());
    size.candidate_pairs = static_cast<double>(contact->candidate_pairs());
  }
  return size;
}

std::array<double, part_count> least_bytes(const SceneSize& s) {
  constexpr double real = sizeof(double), index = sizeof(int);
  std::array<double, part_count> bytes{};
  bytes[0] = 21 * real * s.grid_values;
  if (s.grid_values > 0) bytes[1] = 12 * real * s.grid_values + 29 * real * s.nodes;
  bytes[2] = s.elements * (s.points_per_element * 13 * real + (s.nodes_per_element + 1) * index) + 9 * real * s.nodes;
  bytes[3] = 18 * real * s.surface_nodes + 3 * index * s.surface_faces + 2 * index * s.candidate_pairs;
  return bytes;
}

}  // namespace mv
