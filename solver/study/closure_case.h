// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace mv {

/// The valve of the studies: the generic valve of configs/demo.toml (papers/s0) at chosen resolutions.
struct ClosureMesh {
  double fluid_mm = 1;   // tube.spacing
  double solid_mm = 0.5; // mesh.spacing, of corner points
  int order = 1;         // mesh.order
  double atrium_mm = 20; // tube.length_atrium
};

/// The configuration for mvprep. The gate on solid over fluid spacing is widened when the mesh asks for it, so that a study can look at what the
/// gate forbids.
std::string closure_case_toml(const ClosureMesh& mesh);

/// "f2-s1", "f2-s2-q" for quadratic elements: name of the case, and what it says.
std::string mesh_name(const ClosureMesh& mesh);

}  // namespace mv
