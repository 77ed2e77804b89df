// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/crossing_guard.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <random>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "solver/contact/intersection.h"
#include "solver/contact/relative_motion.h"
#include "solver/contact/self_contact.h"
#include "unit/contact/shapes.h"

namespace mv::test {
namespace {

using contact::FourPoints;

constexpr double mm = 1e-3;

struct Random {
  std::mt19937 engine{7};
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
};

/// Four points, now and then near-degenerate: collinear triangles, parallel, coincident or meeting edges.
FourPoints some_points(Random& random, int k) {
  FourPoints x;
  for (auto& p : x) p = random.vector(1);
  if (k % 5 == 1) x[3] = x[2] + 1e-9 * random.vector(1);
  if (k % 5 == 2) x[3] = x[2] + (x[1] - x[0]) * random(0.2, 2);
  if (k % 5 == 3) x[3] = 0.5 * (x[1] + x[2]) + 1e-7 * random.vector(1);
  return x;
}

double sampled_distance(bool is_edges, const FourPoints& x, int n) {
  double least = 1e300;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double s = static_cast<double>(i) / n, t = static_cast<double>(j) / n;
      if (is_edges) least = std::min(least, (x[0] + s * (x[1] - x[0]) - x[2] - t * (x[3] - x[2])).norm());
      if (!is_edges && s + t <= 1) least = std::min(least, (x[0] - x[1] - s * (x[2] - x[1]) - t * (x[3] - x[1])).norm());
    }
  return least;
}

TEST(PrimitiveDistance, nearest_points_agree_with_dense_samples) {
  Random random;
  double worst = 0;
  for (int k = 0; k < 400; ++k)
    for (bool is_edges : {false, true}) {
      const FourPoints x = some_points(random, k);
      const auto nearest = contact::nearest_points(is_edges, x);
      const double sampled = sampled_distance(is_edges, x, 120), size = 4.0 / 120;
      EXPECT_LE(nearest.separation.norm(), sampled + 1e-12) << k;
      EXPECT_GE(nearest.separation.norm(), sampled - size) << k;
      worst = std::max(worst, sampled - nearest.separation.norm());
      const auto& w = nearest.weight;
      EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], 0, 1e-12);
      EXPECT_NEAR(is_edges ? w[0] + w[1] : w[0], 1, 1e-12);
      const auto in_unit = [](double v) { return v >= -1e-12 && v <= 1 + 1e-12; };
      EXPECT_TRUE(in_unit(is_edges ? w[0] : -w[1]) && in_unit(is_edges ? w[1] : -w[2]) && in_unit(-w[3]));
    }
  std::printf("largest distance of the nearest sample over that of the nearest points: %.4f of edges of 1 to 3\n", worst);
}

TEST(PrimitiveDistance, share_of_approach_stops_before_the_least_distance_and_not_much_earlier) {
  Random random;
  const double least = 0.01;
  int stopped = 0, missed = 0;
  for (int k = 0; k < 4000; ++k)
    for (bool is_edges : {false, true}) {
      const FourPoints x = some_points(random, k);
      FourPoints dx;
      for (auto& d : dx) d = random.vector(1.5);
      const double start = contact::nearest_points(is_edges, x).separation.norm();
      if (start < 2 * least) continue;
      const double share = contact::share_of_approach(is_edges, x, dx, least);
      const double end = share < 1 ? share : 1;
      double nearest = 1e300;
      for (int i = 0; i <= 400; ++i) {
        FourPoints y;
        for (int c = 0; c < 4; ++c) y[c] = x[c] + (end * i / 400) * dx[c];
        nearest = std::min(nearest, contact::nearest_points(is_edges, y).separation.norm());
      }
      if (!(nearest > least)) ++missed;
      if (share < 1) {
        ++stopped;
        EXPECT_LT(nearest - least, 0.1001 * (start - least)) << k;  // a tenth of the clearance may be left
      }
    }
  std::printf("%d motions stopped, %d came nearer than allowed\n", stopped, missed);
  EXPECT_GT(stopped, 500);
  EXPECT_EQ(missed, 0);
}

/// Folded, wavy sheets in layers.
TriangleMesh layers(int count, double gap, double waves = 0.3 * mm) {
  TriangleMesh mesh;
  for (int k = 0; k < count; ++k)
    mesh.add_sheet(
        8 + k, 7, 4 * mm, 3.5 * mm,
        [&](const Vec3& p) { return Vec3(p[0] + 0.1 * mm * k, p[1] - 0.07 * mm * k, k * gap + waves * std::sin(p[0] / mm) * std::cos(p[1] / mm)); }, k % 2 == 1);
  return mesh;
}

std::vector<ClosePair> all_pairs(const TriangleMesh& mesh, double radius) {
  std::vector<ClosePair> out;
  std::vector<std::array<int, 2>> edges;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto near = [&](bool is_edges, const std::array<int, 4>& n) {
    return contact::nearest_points(is_edges, {mesh.point(n[0]), mesh.point(n[1]), mesh.point(n[2]), mesh.point(n[3])}).separation.norm() < radius;
  };
  for (int v = 0; v < mesh.node_count(); ++v)
    for (const auto& t : mesh.triangles)
      if (v != t[0] && v != t[1] && v != t[2] && near(false, {v, t[0], t[1], t[2]})) out.push_back({{v, t[0], t[1], t[2]}, false, 0});
  for (const auto& [a, b] : edges)
    for (const auto& [c, d] : edges)
      if (a != c && a != d && b != c && b != d && std::pair(a, b) < std::pair(c, d) && near(true, {a, b, c, d})) out.push_back({{a, b, c, d}, true, 0});
  return out;
}

std::vector<std::pair<bool, std::array<int, 4>>> sorted_keys(std::span<const ClosePair> pairs) {
  std::vector<std::pair<bool, std::array<int, 4>>> keys;
  for (ClosePair p : pairs) {
    if (p.is_edges && p.node[2] < p.node[0]) std::swap(p.node[0], p.node[2]), std::swap(p.node[1], p.node[3]);
    if (p.is_edges && p.node[2] == p.node[0] && p.node[3] < p.node[1]) std::swap(p.node[1], p.node[3]);
    keys.push_back(p.key());
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

TEST(ClosePairs, search_finds_what_comparing_all_finds) {
  // With the first two radii most surroundings of vertices count as flat.
  const TriangleMesh mesh = layers(3, 0.13 * mm);
  for (double radius : {0.1 * mm, 0.16 * mm, 0.45 * mm}) {
    ClosePairs search(mesh.x, mesh.triangles);
    search.update(mesh.x, radius);
    const auto expected = sorted_keys(all_pairs(mesh, radius)), found = sorted_keys(search.pairs());
    std::printf("radius %.2f mm: %zu pairs found, all against all %zu\n", 1e3 * radius, found.size(), expected.size());
    EXPECT_GT(expected.size(), 20U);
    EXPECT_EQ(found, expected);
    std::size_t nearer = 0, nearer_within = 0;
    for (const ClosePair& p : search.pairs()) nearer += p.distance < 0.5 * radius;
    for (const ClosePair& p : search.pairs_within(0.5 * radius)) nearer_within += p.distance < 0.5 * radius;
    EXPECT_EQ(nearer, nearer_within);
    EXPECT_LT(search.pairs_within(0.5 * radius).size(), found.size());
  }
}

TEST(ClosePairs, flat_surroundings_hide_nothing) {
  // From smooth to steep, radii up to more than the height of the triangles: the rule of the flat vertices ends somewhere in between.
  for (double waves : {0.1 * mm, 0.5 * mm, 0.8 * mm, 1.3 * mm}) {
    TriangleMesh mesh = layers(2, 0.3 * mm, waves);
    Random random;
    for (std::size_t n = 0; n < mesh.x.size() / 3; ++n) Eigen::Map<Vec3>(mesh.x.data() + 3 * n) += random.vector(0.12 * mm);
    ClosePairs search(mesh.x, mesh.triangles);
    for (double radius = 0.04 * mm; radius < 0.55 * mm; radius *= 1.1) {
      search.update(mesh.x, radius);
      ASSERT_EQ(sorted_keys(search.pairs()), sorted_keys(all_pairs(mesh, radius))) << "waves " << 1e3 * waves << " mm, radius " << 1e3 * radius << " mm";
    }
  }
}

TEST(ClosePairs, wrong_input_is_refused) {
  const std::vector<std::array<int, 3>> triangles{{0, 1, 3}};
  EXPECT_THROW(ClosePairs(std::vector<double>(9, 0.0), triangles), InputError);
}

TEST(RelativeMotion, bound_holds_for_all_neighbours_and_ignores_common_motion) {
  const TriangleMesh mesh = layers(3, 0.45 * mm);
  Random random;
  std::vector<int> vertices;
  std::vector<Vec3> u;
  for (int n = 0; n < mesh.node_count(); ++n) {
    vertices.push_back(n);
    const Vec3 p = mesh.point(n);
    // Turning about a far axis, and some noise: far vertices move apart, near ones hardly.
    u.push_back(Vec3(30 * mm, 0, 0) + 0.2 * Vec3(-p[1], p[0], 0) + random.vector(0.01 * mm));
  }
  RelativeMotion motion;
  for (double cell : {0.5 * mm, 1 * mm}) {
    motion.place(mesh.x, vertices, cell);
    const double bound = motion.bound(u);
    double near = 0, any = 0;
    for (std::size_t i = 0; i < u.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double apart = (u[i] - u[j]).norm();
        any = std::max(any, apart);
        if ((mesh.point(vertices[i]) - mesh.point(vertices[j])).norm() < cell) near = std::max(near, apart);
      }
    std::printf("cells of %.1f mm: neighbours move apart by %.3f mm, bound %.3f mm; any two by %.3f mm, all by 30 mm\n", 1e3 * cell, 1e3 * near, 1e3 * bound, 1e3 * any);
    EXPECT_GE(bound, near);
    EXPECT_LT(bound, any);
  }
}

struct Motion {
  std::vector<double> start, end, mass;
  std::vector<char> fixed;
  Motion(const TriangleMesh& mesh, Random& random, const std::function<Vec3(int)>& move) : start(mesh.x), end(mesh.x), fixed(mesh.x.size() / 3, 0) {
    for (int n = 0; n < mesh.node_count(); ++n) {
      mass.push_back(1e-6 * random(0.5, 2));
      Eigen::Map<Vec3>(end.data() + 3 * n) += move(n);
    }
  }
  Vec3 momentum(const std::vector<double>& to) const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t n = 0; n < mass.size(); ++n) sum += mass[n] * (Vec3::Map(to.data() + 3 * n) - Vec3::Map(start.data() + 3 * n));
    return sum;
  }
  double energy(const std::vector<double>& to) const {
    double sum = 0;
    for (std::size_t n = 0; n < mass.size(); ++n) sum += 0.5 * mass[n] * (Vec3::Map(to.data() + 3 * n) - Vec3::Map(start.data() + 3 * n)).squaredNorm();
    return sum;
  }
};

std::size_t crossings(const TriangleMesh& mesh, const std::vector<double>& x) {
  std::vector<Vec3> points;
  for (std::size_t n = 0; n < x.size() / 3; ++n) points.push_back(Vec3::Map(x.data() + 3 * n));
  return self_intersections(points, mesh.triangles).size();
}

TEST(CrossingGuard, edges_that_nodes_do_not_see_are_stopped_and_keep_momentum) {
  // Two large triangles at right angles, border towards border: each edge's middle meets the other's, no node is near a face.
  TriangleMesh mesh;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const int n = mesh.node_count();
    for (const Vec3& p : {a, b, c}) mesh.x.insert(mesh.x.end(), {p[0], p[1], p[2]});
    mesh.triangles.push_back({n, n + 1, n + 2});
  };
  add({-5 * mm, 0, -0.1 * mm}, {5 * mm, 0, -0.1 * mm}, {0, 0, -6 * mm});
  add({0, 5 * mm, 0.1 * mm}, {0, -5 * mm, 0.1 * mm}, {0, 0, 6 * mm});
  const ContactSurface surface = contact_surface_from_triangles(mesh.x, mesh.triangles);
  ContactOptions options;
  options.thickness = 0;
  SelfContact contact(surface, options);
  std::vector<double> forces(mesh.x.size(), 0.0), rest(mesh.x.size(), 0.0);
  EXPECT_EQ(contact.evaluate(mesh.x, rest, 1e-5, forces).active_nodes, 0) << "the case must be one that node to face does not see";

  Random random;
  const Motion motion(mesh, random, [](int n) { return n < 3 ? Vec3(0.02 * mm, 0, 0.2 * mm) : Vec3(0, 0.01 * mm, -0.2 * mm); });
  EXPECT_GT(crossings(mesh, motion.end), 0U) << "unguarded they must cross";
  CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
  std::vector<double> x = motion.end;
  const GuardResult result = guard.apply(motion.start, x);
  EXPECT_EQ(crossings(mesh, x), 0U);
  EXPECT_EQ(result.locked, 0);
  const double change = (motion.momentum(x) - motion.momentum(motion.end)).norm(), scale = 1e-6 * 0.2 * mm;
  std::printf("%d impulses, %d sweeps; momentum changes by %.1e of a vertex's, energy from %.4g to %.4g\n", result.stopped, result.sweeps, change / scale,
              motion.energy(motion.end), motion.energy(x));
  EXPECT_LT(change, 1e-12 * scale);
  EXPECT_LT(motion.energy(x), motion.energy(motion.end));
  // Tangential motion is left alone: only the normal one is taken.
  EXPECT_NEAR(motion.momentum(x)[0], motion.momentum(motion.end)[0], 1e-18);
  double kept = 0;
  for (int n = 0; n < 3; ++n) kept = std::max(kept, std::abs(x[3 * n] - motion.end[3 * n]));
  EXPECT_LT(kept, 1e-3 * mm);
}

TEST(CrossingGuard, angular_momentum_of_impulses_is_kept) {
  TriangleMesh mesh;
  mesh.x = {-5 * mm, 0.3 * mm, -1e-6, 5 * mm, -0.2 * mm, -1e-6, 0, 0, -6 * mm, 0.4 * mm, 5 * mm, 1e-6, 0, -5 * mm, 1e-6, 0, 0, 6 * mm};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  Random random;
  // Motions much smaller than arms: the impulse acts at one point, and the moment of x0 x m dx is kept but for second order.
  const Motion motion(mesh, random, [&](int n) { return n < 3 ? Vec3(0, 0, 4e-6) : Vec3(1e-6, 0, -4e-6); });
  CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
  std::vector<double> x = motion.end;
  const GuardResult result = guard.apply(motion.start, x);
  EXPECT_GT(result.stopped, 0);
  Vec3 change = Vec3::Zero();
  double scale = 0;
  for (std::size_t n = 0; n < 6; ++n) {
    const Vec3 p = motion.mass[n] * (Vec3::Map(x.data() + 3 * n) - Vec3::Map(motion.end.data() + 3 * n));
    change += Vec3::Map(x.data() + 3 * n).cross(p);
    scale += x[3 * n] * x[3 * n] > 0 ? 5 * mm * p.norm() : 0;
  }
  std::printf("moment of the impulses %.1e of its parts\n", change.norm() / scale);
  EXPECT_LT(change.norm(), 2e-3 * scale);
}

TEST(CrossingGuard, sheets_thrown_through_each_other_do_not_cross) {
  Random random;
  const TriangleMesh mesh = layers(4, 0.45 * mm);
  ASSERT_EQ(crossings(mesh, mesh.x), 0U);
  for (double speed : {0.05, 0.3, 0.45}) {
    // Every layer moves by its own amount, the vertices by up to `speed` mm each on top of that.
    const Motion motion(mesh, random, [&](int n) { return Vec3(random.vector(speed * mm) - Vec3(0, 0, speed * (mesh.x[3 * n + 2] - 0.7 * mm))); });
    const std::size_t unguarded = crossings(mesh, motion.end);
    CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
    std::vector<double> x = motion.end;
    const GuardResult result = guard.apply(motion.start, x);
    const double drift = (motion.momentum(x) - motion.momentum(motion.end)).norm();
    double scale = 0;
    for (double m : motion.mass) scale += m * speed * mm;
    std::printf("speed %.2f: %zu crossings without, %zu with; %d impulses, %d sweeps, %d vertices as one; momentum changes by %.0e\n", speed, unguarded,
                crossings(mesh, x), result.stopped, result.sweeps, result.locked, drift / scale);
    EXPECT_EQ(crossings(mesh, x), 0U);
    EXPECT_LT(drift, 1e-12 * scale);
    if (speed < 0.1) {
      EXPECT_EQ(x, motion.end);
      continue;
    }
    EXPECT_GT(unguarded, 20U);
    EXPECT_LT(motion.energy(x), motion.energy(motion.end));
  }
}

TEST(CrossingGuard, what_sweeps_do_not_settle_moves_as_one) {
  Random random;
  const TriangleMesh mesh = layers(4, 0.45 * mm);
  const Motion motion(mesh, random, [&](int n) { return Vec3(random.vector(0.4 * mm) - Vec3(0, 0, 0.5 * (mesh.x[3 * n + 2] - 0.7 * mm))); });
  GuardOptions options;
  options.sweeps_max = 1;
  CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed, options);
  std::vector<double> x = motion.end;
  const GuardResult result = guard.apply(motion.start, x);
  const double drift = (motion.momentum(x) - motion.momentum(motion.end)).norm();
  std::printf("%d vertices as one, momentum changes by %.1e N s\n", result.locked, drift);
  EXPECT_GT(result.locked, 10);
  EXPECT_EQ(crossings(mesh, x), 0U);
  EXPECT_LT(drift, 1e-12 * 1e-6 * mm * static_cast<double>(mesh.node_count()));
}

TEST(CrossingGuard, pressing_for_long_neither_crosses_nor_creeps) {
  const TriangleMesh mesh = layers(2, 0.45 * mm);
  Random random;
  Motion motion(mesh, random, [](int) { return Vec3(Vec3::Zero()); });
  const int lower = 9 * 8;  // vertices of the first sheet are held
  for (int n = 0; n < lower; ++n) motion.fixed[static_cast<std::size_t>(n)] = 1;
  CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
  std::vector<double> x = mesh.x, before;
  double last = 0;
  long locked = 0;
  for (int step = 0; step < 300; ++step) {
    before = x;
    for (int n = lower; n < mesh.node_count(); ++n) x[3 * n + 2] -= 0.01 * mm;
    locked += guard.apply(before, x).locked;
    last = 0;
    for (std::size_t a = 0; a < x.size(); ++a) last = std::max(last, std::abs(x[a] - before[a]));
    for (std::size_t n = 0; n < static_cast<std::size_t>(lower); ++n) ASSERT_EQ(x[3 * n], mesh.x[3 * n]);
  }
  ClosePairs pairs(mesh.x, mesh.triangles);
  pairs.update(x, 0.2 * mm);
  double least = 1;
  for (const ClosePair& p : pairs.pairs()) least = std::min(least, static_cast<double>(p.distance));
  std::printf("after 300 steps: least distance %.3f of that asked for, %zu crossings, %ld vertices as one\n", least / guard.options().least_distance,
              crossings(mesh, x), locked);
  EXPECT_EQ(crossings(mesh, x), 0U);
  EXPECT_GT(least, 0.4 * guard.options().least_distance);
}

TEST(CrossingGuard, nothing_is_changed_where_nothing_comes_near) {
  const TriangleMesh mesh = layers(3, 0.6 * mm);
  Random random;
  const Motion motion(mesh, random, [&](int) { return Vec3(0.3 * mm, -0.2 * mm, 5 * mm); });
  CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
  std::vector<double> x = motion.end;
  EXPECT_EQ(guard.apply(motion.start, x).stopped, 0);
  EXPECT_EQ(x, motion.end);
  EXPECT_TRUE(guard.moved().empty());
}

TEST(CrossingGuard, same_bytes_for_any_thread_count_and_any_past) {
  const TriangleMesh mesh = layers(4, 0.45 * mm);
  const auto run = [&](int threads, bool has_past) {
    const int before = thread_count();
    set_thread_count(threads);
    Random random;
    const Motion motion(mesh, random, [&](int n) { return Vec3(random.vector(0.2 * mm) - Vec3(0, 0, 0.3 * (mesh.x[3 * n + 2] - 0.7 * mm))); });
    CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
    if (has_past) {  // lists of another, wider search
      std::vector<double> x = mesh.x;
      for (std::size_t n = 0; n < x.size() / 3; ++n) x[3 * n] += 0.03 * mm * std::sin(static_cast<double>(n));
      guard.apply(mesh.x, x);
    }
    std::vector<double> x = motion.end;
    const GuardResult result = guard.apply(motion.start, x);
    EXPECT_GT(result.stopped, 10);
    set_thread_count(before);
    return x;
  };
  const auto reference = run(1, false);
  for (int threads : {1, 2, 3})
    for (bool has_past : {false, true}) {
      const auto x = run(threads, has_past);
      EXPECT_EQ(std::memcmp(x.data(), reference.data(), x.size() * sizeof(double)), 0) << threads << " threads, past " << has_past;
    }
}

// build/tests/unit_contact --gtest_also_run_disabled_tests --gtest_filter='*guard_timing*'
TEST(CrossingGuard, DISABLED_guard_timing) {
  // The size of the demo: two leaflets of 1 mm, half a millimetre between nodes, the inner faces 0.15 mm apart.
  TriangleMesh mesh;
  const double heights[] = {0, 1, 1.15, 2.15};
  for (int k = 0; k < 4; ++k)
    mesh.add_sheet(
        63, 63, 31.5 * mm, 31.5 * mm, [&](const Vec3& p) { return Vec3(p + Vec3(0.03 * mm * k, 0, heights[k] * mm + 0.5 * mm * std::sin(0.3 * p[0] / mm))); }, k % 2 == 0);
  Random random;
  const auto milliseconds = [](const std::function<void()>& work) {
    double best = 1e300;
    for (int i = 0; i < 5; ++i) {
      const auto start = std::chrono::steady_clock::now();
      work();
      best = std::min(best, std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    return best;
  };
  ClosePairs search(mesh.x, mesh.triangles);
  for (double radius : {0.03, 0.1, 0.2, 0.3}) {
    const double ms = milliseconds([&] { search.update(mesh.x, radius * mm); });
    std::printf("search, radius %.2f mm: %.2f ms, %zu pairs\n", radius, ms, search.pairs().size());
  }
  for (double speed : {0.0001, 0.001, 0.01}) {
    const Motion motion(mesh, random, [&](int n) { return Vec3(0, 0, speed * mm * std::sin(n)); });
    CrossingGuard guard(mesh.x, mesh.triangles, motion.mass, motion.fixed);
    std::vector<double> x = motion.end;
    guard.apply(motion.start, x);
    const double ms = milliseconds([&] {
      x = motion.end;
      guard.apply(motion.start, x);
    });
    std::printf("step of %.4f mm without search: %.3f ms\n", speed, ms);
  }
}

TEST(CrossingGuard, wrong_input_is_refused) {
  const TriangleMesh mesh = layers(1, mm);
  const std::vector<char> fixed(mesh.x.size() / 3, 0);
  std::vector<double> mass(mesh.x.size() / 3, 1.0);
  EXPECT_THROW(CrossingGuard(mesh.x, mesh.triangles, std::span<const double>(mass).first(3), fixed), InputError);
  CrossingGuard guard(mesh.x, mesh.triangles, mass, fixed);
  std::vector<double> x = mesh.x;
  x[4] = std::nan("");
  EXPECT_THROW(guard.apply(mesh.x, x), TrustError);
  mass[2] = 0;
  EXPECT_THROW(CrossingGuard(mesh.x, mesh.triangles, mass, fixed), InputError);
}

}  // namespace
}  // namespace mv::test
