// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mv {

/// Fluid cells between leaflets or papillary tips and the open ends of the tube, where pressures are given and kernels need support. What mvprep leaves and mvsolve asks for.
inline constexpr double tube_end_cells = 2;

}  // namespace mv
