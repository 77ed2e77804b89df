// SPDX-License-Identifier: BSD-3-Clause
// Not a test: times the elastic forces. Figure of merit: nanoseconds per element, best of 200 calls.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include "geometry/core/parallel.h"
#include "unit/solid/samples.h"

using namespace mv;
using namespace mv::solid_test;

namespace {

template <class Work>
double best_of(int runs, Work&& work) {
  double best = 1e300;
  for (int r = 0; r < runs; ++r) {
    const auto start = std::chrono::steady_clock::now();
    work();
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return best;
}

void bench(const SolidMesh& mesh, Law law) {
  LeafletSolid solid(mesh, {material_of(law), material_of(law)});
  const Mat3 stretch = Vec3(1.05, 1.02, 0.95).asDiagonal();
  const std::vector<double> x = deformed(mesh, stretch, 1e-5, 1);
  std::vector<double> f(x.size(), 0.0);
  std::printf("%-12s %2d nodes %6ld elements:", name_of(law).c_str(), mesh.nodes_per_tet, solid.element_count());
  for (int threads : {1, 2}) {
    set_thread_count(threads);
    const double seconds = best_of(200, [&] { solid.forces(x, f); });
    std::printf("  %d threads %6.2f ms (%5.1f ns/element)", threads, seconds * 1e3,
                seconds * 1e9 / static_cast<double>(solid.element_count()));
  }
  std::printf("  critical step %.0f ms\n", best_of(3, [&] { solid.critical_step(x); }) * 1e3);
}

}   // namespace

int main() {
  for (Law law : all_laws) bench(block_mesh(80, 80, 2, 0.5e-3, false), law);
  for (Law law : all_laws) bench(block_mesh(41, 41, 2, 1e-3, true), law);
}
