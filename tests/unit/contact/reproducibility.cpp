// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "geometry/core/parallel.h"
#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

constexpr double mm = 1e-3;

/// Two sheets rubbing, rolling and parting on a prescribed path.
struct Rubbing {
  TriangleMesh mesh;
  std::array<int, 2> upper{};
  ContactSurface surface;
  ContactOptions options;

  Rubbing() {
    mesh.add_sheet(30, 20, 15 * mm, 10 * mm, [](const Vec3& p) -> Vec3 { return p; });
    upper = mesh.add_sheet(
        25, 18, 12 * mm, 8 * mm, [](const Vec3& p) -> Vec3 { return p + Vec3(1 * mm, 1 * mm, 0.1 * mm); }, true);
    surface = contact_surface_from_triangles(mesh.x, mesh.triangles);
    options.thickness = 0;
    options.stiffness = 1e8;
  }

  void at_step(int step, std::vector<double>& x, std::vector<double>& v) const {
    x = mesh.x;
    v.assign(x.size(), 0.0);
    const double t = 0.01 * step;
    for (int n = 0; n < mesh.node_count(); ++n) {
      const Vec3 p = mesh.point(n);
      const double wave = std::sin(p[0] / (2 * mm) + 3 * t) * std::cos(p[1] / (3 * mm) - t);
      x[3 * n + 2] += 0.06 * mm * wave;
      if (n >= upper[0]) {
        x[3 * n] += 0.5 * mm * std::sin(2 * t);
        x[3 * n + 2] += 0.1 * mm * std::sin(5 * t);
        v[3 * n] = 0.1 * std::cos(2 * t);
        v[3 * n + 1] = 0.05 * std::sin(3 * t);
      }
    }
  }
};

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

std::vector<double> trajectory(const Rubbing& r, const ContactOptions& options, int first, int last, std::vector<double>& history,
                               int search_at = -1) {
  SelfContact contact(r.surface, options);
  if (!history.empty()) contact.import_history(history);
  std::vector<double> x, v, forces(r.mesh.x.size()), out;
  for (int step = first; step < last; ++step) {
    r.at_step(step, x, v);
    if (step == search_at) contact.update_candidates(x);
    std::fill(forces.begin(), forces.end(), 0.0);
    const auto result = contact.evaluate(x, v, 1e-5, forces);
    out.insert(out.end(), forces.begin(), forces.end());
    out.insert(out.end(), {result.normal_force, result.potential_energy, result.friction_energy, result.friction_dissipation,
                           result.min_gap, result.contact_area});
    out.insert(out.end(), contact.gap().begin(), contact.gap().end());
    out.insert(out.end(), contact.pressure().begin(), contact.pressure().end());
  }
  history = contact.export_history();
  return out;
}

TEST(ContactReproducibility, bytes_do_not_depend_on_the_number_of_threads) {
  Rubbing r;
  const int threads = thread_count();
  std::vector<double> reference;
  for (int count : {1, 2, 3}) {
    set_thread_count(count);
    std::vector<double> history;
    auto out = trajectory(r, r.options, 0, 25, history);
    out.insert(out.end(), history.begin(), history.end());
    if (count == 1) reference = out;
    EXPECT_TRUE(same_bytes(out, reference)) << count << " threads";
  }
  set_thread_count(threads);
  double largest = 0;
  for (double f : reference) largest = std::isfinite(f) ? std::max(largest, std::abs(f)) : largest;
  EXPECT_GT(largest, 0);
}

TEST(ContactReproducibility, bytes_do_not_depend_on_when_candidates_were_renewed) {
  Rubbing r;
  std::vector<double> h0, h1, h2;
  const auto lazy = trajectory(r, r.options, 0, 60, h0);
  auto eager = r.options;
  eager.search_every = 1;
  auto wide = r.options;
  wide.skin = 1.5 * mm;
  EXPECT_TRUE(same_bytes(trajectory(r, eager, 0, 60, h1), lazy));
  EXPECT_TRUE(same_bytes(trajectory(r, wide, 0, 60, h2, 17), lazy));
  EXPECT_TRUE(same_bytes(h0, h1) && same_bytes(h0, h2));
}

TEST(ContactReproducibility, a_resumed_run_equals_the_uninterrupted_one) {
  Rubbing r;
  std::vector<double> whole_history, history;
  const auto whole = trajectory(r, r.options, 0, 50, whole_history);
  auto parts = trajectory(r, r.options, 0, 23, history);
  bool has_slip = false;
  for (double s : history) has_slip |= s != 0;
  EXPECT_TRUE(has_slip);
  const auto rest = trajectory(r, r.options, 23, 50, history);
  parts.insert(parts.end(), rest.begin(), rest.end());
  EXPECT_TRUE(same_bytes(parts, whole));
  EXPECT_TRUE(same_bytes(history, whole_history));
  // The test can see a difference: without the history the second part is another one.
  std::vector<double> lost;
  EXPECT_FALSE(same_bytes(trajectory(r, r.options, 23, 50, lost), rest));
}

TEST(ContactReproducibility, a_stale_candidate_list_is_noticed) {
  Rubbing r;
  SelfContact contact(r.surface, r.options);
  std::vector<double> x = r.mesh.x, v(x.size(), 0.0), forces(x.size(), 0.0);
  EXPECT_TRUE(contact.evaluate(x, v, 0, forces).searched);
  EXPECT_FALSE(contact.evaluate(x, v, 0, forces).searched);
  x[3 * r.upper[0] + 1] += 0.49 * contact.options().skin;
  EXPECT_FALSE(contact.evaluate(x, v, 0, forces).searched);
  x[3 * r.upper[0] + 1] += 0.02 * contact.options().skin;
  EXPECT_TRUE(contact.evaluate(x, v, 0, forces).searched);
}

}  // namespace
}  // namespace mv::test
