// SPDX-License-Identifier: BSD-3-Clause
// Not part of the ordinary run: unit_contact --gtest_also_run_disabled_tests --gtest_filter='*timing*'
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "geometry/core/parallel.h"
#include "solver/contact/intersection.h"
#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

using Clock = std::chrono::steady_clock;
double milliseconds(Clock::time_point since) { return std::chrono::duration<double, std::milli>(Clock::now() - since).count(); }

/// Smallest elapsed and processor time (all threads) of some repetitions, in ms. On a busy machine only the second one means
/// anything.
struct Cost {
  double elapsed = 1e9, processor = 1e9;
};
template <class Work>
Cost cost(int repeats, Work&& work) {
  Cost best;
  for (int k = 0; k < repeats; ++k) {
    const auto start = Clock::now();
    const std::clock_t ticks = std::clock();
    work();
    best.elapsed = std::min(best.elapsed, milliseconds(start));
    best.processor = std::min(best.processor, 1e3 * static_cast<double>(std::clock() - ticks) / CLOCKS_PER_SEC);
  }
  return best;
}

TEST(ContactTiming, DISABLED_timing_of_two_leaflets_in_contact) {
  // Two gently waved 1 mm leaflets, about 16k surface nodes in all; a quarter of them touches.
  constexpr double mm = 1e-3;
  const int n = 62;
  TetMesh m = tet_box(n, n, 2, 0.5 * mm * n, 0.5 * mm * n, 1 * mm);
  const TetMesh one = m;
  const int offset = static_cast<int>(one.side.size());
  for (int k = 0; k < offset; ++k) {
    const Vec3 p = one.point(k) + Vec3(0, 0, 6.0 * mm);  // open at rest
    m.x.insert(m.x.end(), {p[0], p[1], p[2]});
    m.side.push_back(one.side[k]);
  }
  for (auto t : one.tets) {
    for (int c = 0; c < 4; ++c) t[c] += offset;
    m.tets.push_back(t);
  }
  auto start = Clock::now();
  const auto s = extract_contact_surface(m.x, m.tets, 1, m.side, ContactFaces::both);
  std::printf("surface nodes %d, triangles %d, extraction %.0f ms\n", s.node_count(), s.triangle_count(), milliseconds(start));
  ContactOptions options;
  options.threshold = 0.2 * mm;
  start = Clock::now();
  SelfContact contact(s, options);
  std::printf("construction %.0f ms\n", milliseconds(start));
  std::vector<double> x = m.x, v(x.size(), 0.0), forces(x.size());
  for (std::size_t k = 0; k < x.size() / 3; ++k) {
    const double z = x[3 * k + 2], lift = static_cast<int>(k) < offset ? 0.0 : 1.0;
    const double open = std::max(0.0, x[3 * k] - 15 * mm) * 0.5;  // touching half, opening half
    x[3 * k + 2] = z + 0.3 * mm * std::sin(x[3 * k] / (3 * mm)) * std::cos(x[3 * k + 1] / (4 * mm)) + lift * (open - 4.9 * mm) +
                   lift * 0.03 * mm * std::sin(x[3 * k + 1] / mm);
    v[3 * k] = 0.1 * lift;
  }
  for (int threads : {1, 2}) {
    set_thread_count(threads);
    contact.update_candidates(x);
    ContactResult result;
    ClosestGaps closest;
    std::size_t crossings = 0;
    const Cost search = cost(30, [&] { contact.update_candidates(x); });
    const Cost step = cost(300, [&] { result = contact.evaluate(x, v, 1e-5, forces); });
    const Cost gaps = cost(5, [&] { contact.closest_gaps(x, 4 * mm, true, closest); });
    const Cost exact = cost(3, [&] { crossings = self_intersections(s, x).size(); });
    std::printf(
        "threads %d: active %d, pairs %ld; elapsed (processor) ms: search %.2f (%.2f), evaluate %.3f (%.3f), closest gaps to 4 "
        "mm %.1f (%.1f), "
        "self-intersection %.1f (%.1f), %zu crossings\n",
        threads, result.active_nodes, contact.candidate_pairs(), search.elapsed, search.processor, step.elapsed, step.processor,
        gaps.elapsed, gaps.processor, exact.elapsed, exact.processor, crossings);
    EXPECT_GT(result.active_nodes, 2000);
  }
}

}  // namespace
}  // namespace mv::test
