// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mv {

/// Fluid cells between leaflets or papillary tips and the open ends of the tube, where pressures are given and kernels need support. What mvprep leaves, and what
/// mvsolve asks for: a tube that is just long enough passes however it was rounded.
inline constexpr double tube_end_cells = 2, tube_end_cells_needed = tube_end_cells - 1e-3;

}  // namespace mv
