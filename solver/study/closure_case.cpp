// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/closure_case.h"

#include <fmt/format.h>

#include <algorithm>

namespace mv {

std::string closure_case_toml(const ClosureMesh& mesh) {
  // Neighbouring points of a quadratic element are half its edge apart.
  const double neighbours = mesh.order == 2 ? 0.5 * mesh.solid_mm : mesh.solid_mm;
  return fmt::format(
      "# The generic valve of configs/demo.toml, for the studies of mvsolve.\n"
      "[case]\nname = \"Generic valve, study\"\n\n"
      "[generic]\nstrip_height = \"8 mm\"\n\n"
      "[mesh]\nspacing = \"{:g} mm\"\nlayers = 2\norder = {}\n\n"
      "[leaflet]\nbulk = \"2 MPa\"\n\n"
      "[tube]\nspacing = \"{:g} mm\"\nlength_atrium = \"{:g} mm\"\n\n"
      "[gates]\nmax_spacing_ratio = {:.6g}\n\n"
      "[pressure]\nwaveform = \"systolic\"\npeak = \"120 mmHg\"\nrise_time = \"100 ms\"\n",
      mesh.solid_mm, mesh.order, mesh.fluid_mm, mesh.atrium_mm, std::max(0.5, 1.01 * neighbours / mesh.fluid_mm));
}

std::string mesh_name(const ClosureMesh& mesh) { return fmt::format("f{:g}-s{:g}{}", mesh.fluid_mm, mesh.solid_mm, mesh.order == 2 ? "-q" : ""); }

}  // namespace mv
