// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace mv {

/// Bytes per second of a(i) = b(i) + s c(i) on arrays far beyond the caches, with the threads in use: 24 bytes an element as STREAM counts (McCalpin
/// 1995; the fetch of a line before it is written is not counted). The best of `repeats`. Takes about a tenth of a second and 192 MB.
double triad_bandwidth(int repeats = 7);

}  // namespace mv
