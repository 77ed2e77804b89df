// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/triad.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "geometry/core/parallel.h"

namespace mv {

double triad_bandwidth(int repeats) {
  constexpr std::ptrdiff_t n = 8'000'000;
  // Not initialised here: each thread touches its part first.
  const auto make = [] { return std::unique_ptr<double[]>(new double[static_cast<std::size_t>(n)]); };
  const auto a = make(), b = make(), c = make();
  parallel_for(n, [&](std::ptrdiff_t i) {
    a[static_cast<std::size_t>(i)] = 0;
    b[static_cast<std::size_t>(i)] = 1;
    c[static_cast<std::size_t>(i)] = 2;
  });
  double best = 0;
  for (int r = 0; r < repeats; ++r) {
    const auto start = std::chrono::steady_clock::now();
    double *const out = a.get(), *const left = b.get(), *const right = c.get();
    const double scale = 1.0 + r;
    parallel_ranges(n, [=](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
      for (std::ptrdiff_t i = begin; i < end; ++i) out[i] = left[i] + scale * right[i];
    });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    best = std::max(best, 24.0 * static_cast<double>(n) / seconds);
  }
  return best;
}

}  // namespace mv
