// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The only file that knows about threads. Ranges are split statically, so the same thread count gives the same arithmetic; kernels written per cell or per
// node with fixed gather order do not depend on the count at all. Pieces go to whichever thread is free: their results must not depend on who does them.

#include <atomic>
#include <cstddef>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace mv {

/// Loops shorter than this run on the calling thread: starting a team costs more than the work.
inline constexpr std::ptrdiff_t serial_loop_limit = 256;

inline int thread_count() {
#ifdef _OPENMP
  return omp_get_max_threads();
#else
  return 1;
#endif
}

inline void set_thread_count(int n) {
#ifdef _OPENMP
  omp_set_num_threads(n);
#else
  (void)n;
#endif
}

namespace detail {
/// One compiled copy of a body for the serial and the parallel path: inlined twice, the compiler may fuse multiplications and additions
/// differently, and results would depend on the thread count by round-off.
template <class Body>
[[gnu::noinline]] void run_range(Body& body, std::ptrdiff_t begin, std::ptrdiff_t end, int thread) {
  body(begin, end, thread);
}
}  // namespace detail

/// Calls body(begin, end, thread) for contiguous ranges that cover [0, n).
template <class Body>
void parallel_ranges(std::ptrdiff_t n, Body&& body, std::ptrdiff_t serial_below = serial_loop_limit) {
#ifdef _OPENMP
  if (n >= serial_below && omp_get_max_threads() > 1) {
#pragma omp parallel
    {
      const std::ptrdiff_t teams = omp_get_num_threads();
      const std::ptrdiff_t t = omp_get_thread_num();
      detail::run_range(body, n * t / teams, n * (t + 1) / teams, static_cast<int>(t));
    }
    return;
  }
#endif
  (void)serial_below;
  detail::run_range(body, std::ptrdiff_t{0}, n, 0);
}

/// Calls body(i) for i in [0, n).
template <class Body>
void parallel_for(std::ptrdiff_t n, Body&& body, std::ptrdiff_t serial_below = serial_loop_limit) {
  parallel_ranges(
      n,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        for (std::ptrdiff_t i = begin; i < end; ++i) body(i);
      },
      serial_below);
}

/// Calls body(begin, end, thread) for pieces of `piece` items, handed out in ascending order as threads become free: for loops whose work is bunched up
/// somewhere. Which thread does which piece must not matter for the result.
template <class Body>
void parallel_pieces(std::ptrdiff_t n, std::ptrdiff_t piece, Body&& body, std::ptrdiff_t serial_below = serial_loop_limit) {
#ifdef _OPENMP
  if (n >= serial_below && omp_get_max_threads() > 1) {
    std::atomic<std::ptrdiff_t> next{0};
#pragma omp parallel
    {
      const int t = omp_get_thread_num();
      for (std::ptrdiff_t begin; (begin = next.fetch_add(piece, std::memory_order_relaxed)) < n;)
        detail::run_range(body, begin, begin + piece < n ? begin + piece : n, t);
    }
    return;
  }
#endif
  (void)serial_below;
  detail::run_range(body, std::ptrdiff_t{0}, n, 0);
}

/// Sum of value(i) for i in [0, n) in blocks of fixed size, so that the result does not depend on the thread count.
template <class Value>
double parallel_sum(std::ptrdiff_t n, Value&& value);

}  // namespace mv

#include <vector>

template <class Value>
double mv::parallel_sum(std::ptrdiff_t n, Value&& value) {
  constexpr std::ptrdiff_t block = 2048;
  const std::ptrdiff_t blocks = (n + block - 1) / block;
  std::vector<double> partial(static_cast<std::size_t>(blocks), 0.0);
  parallel_for(
      blocks,
      [&](std::ptrdiff_t b) {
        double sum = 0;
        const std::ptrdiff_t end = (b + 1) * block < n ? (b + 1) * block : n;
        for (std::ptrdiff_t i = b * block; i < end; ++i) sum += value(i);
        partial[static_cast<std::size_t>(b)] = sum;
      },
      2);
  double total = 0;
  for (double p : partial) total += p;
  return total;
}
