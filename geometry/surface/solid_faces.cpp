// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/solid_faces.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "geometry/surface/surface_query.h"

namespace mv {
namespace {

using Triangle = std::array<int, 3>;
using Sparse = Eigen::SparseMatrix<double>;

std::size_t at(long i) { return static_cast<std::size_t>(i); }
std::uint64_t edge_key(int a, int b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | static_cast<std::uint32_t>(std::max(a, b));
}

// An opposite counts when the inner ball touches the two faces at points this far apart, seen from its centre, and their normals
// look away from each other. On a round rim all separations occur; there only the points next to the faces find an opposite. The corners
// of a flat rim, where the averaged normal stands at 45 degrees, find none.
constexpr double smallest_separation = 130 * M_PI / 180;
constexpr double largest_normal_product = -0.8;
// Contacts closer than this to the point itself, seen from the centre of the ball, are roughness of the surface around the point.
constexpr double roughness_separation = 40 * M_PI / 180;
constexpr double largest_over_median = 4;   // thickness beyond this many medians is no leaflet's
constexpr double across_rim_weight = 0.01;  // of a neighbour without an opposite, against one with

struct Opposite {
  int triangle = -1;  // -1: none
  Vec3 weights = Vec3::Zero();
  double thickness = 0;
};

Vec3 interpolate(const std::vector<Vec3>& values, const Triangle& t, const Vec3& w) {
  return w[0] * values[at(t[0])] + w[1] * values[at(t[1])] + w[2] * values[at(t[2])];
}

/// Shrinking ball (Ma, Bae, Choi 2012): the largest ball that touches the surface at p from inside, found from above. The first ball is
/// doubled until it meets something: far from the surface the nearest point is expensive to find.
Opposite look_across(const SurfaceQuery& query, const std::vector<Vec3>& normals, const std::vector<Triangle>& triangles,
                     const Vec3& p, const Vec3& n, double largest_radius) {
  double r = largest_radius / 128;
  while (query.nearest(p - r * n).distance >= r * (1 - 1e-3))
    if ((r *= 2) > largest_radius) return {};
  SurfaceQuery::Nearest touch;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Vec3 centre = p - r * n;
    const auto q = query.nearest(centre);
    if (q.distance >= r * (1 - 1e-3)) break;
    const Vec3 chord = p - q.point;
    const double depth = chord.dot(n);
    if (depth <= 0) break;
    const double smaller = chord.squaredNorm() / (2 * depth);
    const Vec3 c = p - smaller * n;
    const double separation = std::acos(std::clamp(n.dot((q.point - c) / smaller), -1.0, 1.0));
    if (separation < roughness_separation && touch.triangle >= 0) break;
    touch = q;
    if (smaller >= r) break;
    r = smaller;
  }
  if (touch.triangle < 0) return {};
  const Vec3 c = p - r * n;
  const double separation = std::acos(std::clamp(n.dot((touch.point - c).normalized()), -1.0, 1.0));
  const Vec3 other = interpolate(normals, triangles[at(touch.triangle)], touch.weights).normalized();
  if (separation < smallest_separation || other.dot(n) > largest_normal_product) return {};
  return {touch.triangle, touch.weights, 2 * r};
}

double area_of(const std::vector<Vec3>& points, const Triangle& t) {
  return 0.5 * (points[at(t[1])] - points[at(t[0])]).cross(points[at(t[2])] - points[at(t[0])]).norm();
}

/// Value below which `share` of the weight lies; pairs of (value, weight).
double weighted_quantile(std::vector<std::pair<double, double>> pairs, double share) {
  if (pairs.empty()) return 0;
  std::sort(pairs.begin(), pairs.end());
  double total = 0, sum = 0;
  for (const auto& [value, weight] : pairs) total += weight;
  for (const auto& [value, weight] : pairs)
    if ((sum += weight) >= share * total) return value;
  return pairs.back().first;
}

/// Positions without roughness shorter than about `radius`, for looking across only: Taubin's pairs of a shrinking and a swelling step.
std::vector<Vec3> smoothed(const SolidFaces& f, double radius) {
  std::vector<Vec3> x = f.points;
  double length = 0;
  for (const Triangle& t : f.triangles)
    for (std::size_t k = 0; k < 3; ++k) length += (x[at(t[k])] - x[at(t[(k + 1) % 3])]).norm();
  const double mean_edge = length / (3.0 * static_cast<double>(f.triangles.size()));
  const int passes = std::clamp(static_cast<int>(std::lround(4 * std::pow(radius / mean_edge, 2))), 2, 30);
  std::vector<Vec3> sum(x.size());
  std::vector<double> count(x.size());
  for (int pass = 0; pass < 2 * passes; ++pass) {
    std::fill(sum.begin(), sum.end(), Vec3::Zero());
    std::fill(count.begin(), count.end(), 0.0);
    for (const Triangle& t : f.triangles)
      for (std::size_t k = 0; k < 3; ++k) sum[at(t[k])] += x[at(t[(k + 1) % 3])], count[at(t[k])] += 1;
    const double step = pass % 2 == 0 ? 0.5 : -0.53;
    for (std::size_t i = 0; i < x.size(); ++i)
      if (count[i] > 0) x[i] += step * (sum[i] / count[i] - x[i]);
  }
  return x;
}

void average_normals(SolidFaces& f, double radius) {
  double length = 0;
  long edges = 0;
  f.normals.assign(f.points.size(), Vec3::Zero());
  for (const Triangle& t : f.triangles) {
    const Vec3 n = (f.points[at(t[1])] - f.points[at(t[0])]).cross(f.points[at(t[2])] - f.points[at(t[0])]);
    for (int v : t) f.normals[at(v)] += n;
    for (std::size_t k = 0; k < 3; ++k) length += (f.points[at(t[k])] - f.points[at(t[(k + 1) % 3])]).norm(), ++edges;
  }
  const double mean_edge = length / static_cast<double>(edges);
  const int passes = std::clamp(static_cast<int>(std::lround(std::pow(radius / mean_edge, 2))), 0, 20);
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<Vec3> sum = f.normals;
    for (const Triangle& t : f.triangles)
      for (std::size_t k = 0; k < 3; ++k) sum[at(t[k])] += 0.5 * (f.normals[at(t[(k + 1) % 3])] + f.normals[at(t[(k + 2) % 3])]);
    f.normals.swap(sum);
  }
  for (Vec3& n : f.normals) n = n.norm() > 0 ? Vec3(n.normalized()) : Vec3::UnitZ();
}

std::vector<std::array<int, 2>> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<std::array<int, 2>> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (t[k] < t[(k + 1) % 3]) edges.push_back({t[k], t[(k + 1) % 3]});
  return edges;
}

struct SignedEdge {
  int a, b;
  double weight;  // > 0: same face, < 0: opposite
};

std::vector<int> parts_of(std::size_t n, const std::vector<SignedEdge>& edges) {
  std::vector<int> root(n);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[at(i)] != i) i = root[at(i)] = root[at(root[at(i)])];
    return i;
  };
  for (const SignedEdge& e : edges) root[at(find(e.a))] = find(e.b);
  for (std::size_t i = 0; i < n; ++i) root[i] = find(static_cast<int>(i));
  return root;
}

Sparse signed_laplacian(std::size_t n, const std::vector<SignedEdge>& edges, double shift) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const SignedEdge& e : edges) {
    entries.emplace_back(e.a, e.b, -e.weight);
    entries.emplace_back(e.b, e.a, -e.weight);
    entries.emplace_back(e.a, e.a, std::abs(e.weight));
    entries.emplace_back(e.b, e.b, std::abs(e.weight));
  }
  for (std::size_t i = 0; i < n; ++i) entries.emplace_back(i, i, shift);
  Sparse matrix(static_cast<long>(n), static_cast<long>(n));
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Lowest eigenvector of the signed Laplacian, one for each connected part, by inverse iteration from a fixed start.
Eigen::VectorXd two_colouring(std::size_t n, const std::vector<SignedEdge>& edges) {
  const std::vector<int> part = parts_of(n, edges);
  const Eigen::SimplicialLDLT<Sparse> solver(signed_laplacian(n, edges, 1e-7));
  if (solver.info() != Eigen::Success) throw InputError("surface: the graph of its opposite points could not be solved");
  Eigen::VectorXd x(static_cast<long>(n));
  for (long i = 0; i < x.size(); ++i) x[i] = std::sin(1.0 + 12.9898 * static_cast<double>(i)) * std::cos(78.233 * static_cast<double>(i));
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Eigen::VectorXd before = x;
    x = solver.solve(x).eval();
    std::vector<double> largest(n, 0.0);
    for (long i = 0; i < x.size(); ++i) largest[at(part[at(i)])] = std::max(largest[at(part[at(i)])], std::abs(x[i]));
    for (long i = 0; i < x.size(); ++i)
      if (largest[at(part[at(i)])] > 0) x[i] /= largest[at(part[at(i)])];
    if ((x - before).lpNorm<Eigen::Infinity>() < 1e-6) break;
  }
  return x;
}

/// Patches of one sign smaller than a disc of the thickness' radius are no faces: their points are left to be interpolated.
void release_small_patches(const SolidFaces& f, const std::vector<std::array<int, 2>>& edges, std::vector<int>& sign) {
  std::vector<SignedEdge> same;
  for (const auto& [a, b] : edges)
    if (sign[at(a)] != 0 && sign[at(a)] == sign[at(b)]) same.push_back({a, b, 1});
  const std::vector<int> patch = parts_of(f.points.size(), same);
  std::vector<double> area(f.points.size(), 0.0);
  for (const Triangle& t : f.triangles)
    for (int v : t) area[at(patch[at(v)])] += area_of(f.points, t) / 3;
  const double smallest = M_PI * 0.25 * f.thickness_median * f.thickness_median;
  for (std::size_t i = 0; i < sign.size(); ++i)
    if (area[at(patch[i])] < smallest) sign[i] = 0;
}

/// s = sign where there is one, harmonic between. A part of the surface without any sign gets 0.
std::vector<double> fill_in(const SolidFaces& f, const std::vector<std::array<int, 2>>& edges, const std::vector<int>& sign) {
  std::vector<int> row(sign.size(), -1);
  int free = 0;
  for (std::size_t i = 0; i < sign.size(); ++i)
    if (sign[i] == 0) row[i] = free++;
  std::vector<double> colour(sign.begin(), sign.end());
  if (free == 0) return colour;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(free);
  for (int i = 0; i < free; ++i) entries.emplace_back(i, i, 1e-9);
  for (const auto& [a, b] : edges) {
    const double w = f.thickness_median / std::max((f.points[at(a)] - f.points[at(b)]).norm(), 1e-6 * f.thickness_median);
    for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
      if (row[at(i)] < 0) continue;
      entries.emplace_back(row[at(i)], row[at(i)], w);
      if (row[at(j)] >= 0)
        entries.emplace_back(row[at(i)], row[at(j)], -w);
      else
        rhs[row[at(i)]] += w * sign[at(j)];
    }
  }
  Sparse matrix(free, free);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Sparse> solver(matrix);
  const Eigen::VectorXd x = solver.solve(rhs);
  for (std::size_t i = 0; i < sign.size(); ++i)
    if (row[i] >= 0) colour[i] = std::clamp(x[row[i]], -1.0, 1.0);
  return colour;
}

}  // namespace

OppositeFaces opposite_faces(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles, bool inwards) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : points) box.extend(p);
  const SurfaceQuery query(points, triangles);
  std::vector<Vec3> normals;  // three equal "corner" normals a triangle
  std::vector<Triangle> corners;
  for (const Triangle& t : triangles) {
    const Vec3 n = (points[at(t[1])] - points[at(t[0])]).cross(points[at(t[2])] - points[at(t[0])]).normalized();
    const int i = static_cast<int>(normals.size());
    normals.push_back(inwards ? n : Vec3(-n));
    corners.push_back({i, i, i});
  }
  const std::size_t stride = std::max<std::size_t>(1, triangles.size() / 3000);
  std::vector<std::pair<double, double>> seen;
  double paired = 0, whole = 0;
  for (std::size_t t = 0; t < triangles.size(); t += stride) {
    const Triangle& tri = triangles[t];
    const double area = area_of(points, tri);
    if (!(area > 0)) continue;
    const Vec3 middle = (points[at(tri[0])] + points[at(tri[1])] + points[at(tri[2])]) / 3;
    const Opposite o = look_across(query, normals, corners, middle, normals[t], 0.5 * box.diagonal().norm());
    whole += area;
    if (o.triangle < 0) continue;
    paired += area;
    seen.emplace_back(o.thickness, area);
  }
  return {whole > 0 ? paired / whole : 0, weighted_quantile(std::move(seen), 0.5)};
}

double check_closed_surface(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  if (points.empty() || triangles.empty()) throw InputError("surface: it is empty; expected a closed triangle surface");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite()) throw InputError(fmt::format("surface: point {} is not finite", i));
  const int n = static_cast<int>(points.size());
  std::unordered_map<std::uint64_t, std::pair<int, int>> sides;  // uses of each edge upwards and downwards
  double volume = 0;
  const Vec3 origin = points[0];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int v : triangles[t])
      if (v < 0 || v >= n) throw InputError(fmt::format("surface: triangle {} refers to point {} of {}", t, v, n));
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      if (a == b) throw InputError(fmt::format("surface: triangle {} names point {} twice", t, a));
      auto& uses = sides[edge_key(a, b)];
      ++(a < b ? uses.first : uses.second);
    }
    volume += (points[at(triangles[t][0])] - origin)
                  .dot((points[at(triangles[t][1])] - origin).cross(points[at(triangles[t][2])] - origin)) / 6;
  }
  long open = 0, turned = 0, crowded = 0;
  for (const auto& [key, uses] : sides) {
    if (uses.first + uses.second == 1) ++open;
    else if (uses.first + uses.second > 2) ++crowded;
    else if (uses.first != uses.second) ++turned;
  }
  if (open + turned + crowded > 0)
    throw InputError(fmt::format("surface: not closed and oriented: {} border edges, {} edges whose two triangles are oriented against each "
                                 "other, {} edges with more than two triangles; repair it first", open, turned, crowded));
  if (!(volume > 0)) throw InputError(fmt::format("surface: it encloses {:.3g} mm3; expected a closed surface oriented outwards", volume));
  return volume;
}

void halve_long_edges(std::vector<Vec3>& points, std::vector<Triangle>& triangles, std::vector<int>& parent, double longest,
                      std::size_t max_points) {
  parent.resize(triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (int pass = 0; pass < 20 && points.size() < max_points; ++pass) {
    std::unordered_map<std::uint64_t, int> middle;
    const auto split = [&](int a, int b) {
      if ((points[at(a)] - points[at(b)]).norm() <= longest) return -1;
      const auto [entry, added] = middle.try_emplace(edge_key(a, b), static_cast<int>(points.size()));
      if (added) points.push_back(0.5 * (points[at(a)] + points[at(b)]));
      return entry->second;
    };
    std::vector<Triangle> next;
    std::vector<int> next_parent;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      Triangle v = triangles[t];
      std::array<int, 3> m{};
      for (std::size_t k = 0; k < 3; ++k) m[k] = split(v[k], v[(k + 1) % 3]);
      const auto add = [&](int a, int b, int c) { next.push_back({a, b, c}), next_parent.push_back(parent[t]); };
      const auto count = std::count_if(m.begin(), m.end(), [](int i) { return i >= 0; });
      if (count == 0) { add(v[0], v[1], v[2]); continue; }
      if (count == 3) {
        add(v[0], m[0], m[2]), add(m[0], v[1], m[1]), add(m[2], m[1], v[2]), add(m[0], m[1], m[2]);
        continue;
      }
      std::size_t k = 0;  // one: the halved edge; two: the edge left whole
      while ((m[k] >= 0) != (count == 1)) ++k;
      const int a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3], mb = m[(k + 1) % 3], mc = m[(k + 2) % 3];
      if (count == 1) {
        add(a, m[k], c), add(m[k], b, c);
      } else {
        add(mb, c, mc);
        if ((points[at(a)] - points[at(mb)]).norm() < (points[at(b)] - points[at(mc)]).norm())
          add(a, b, mb), add(a, mb, mc);
        else
          add(a, b, mc), add(b, mb, mc);
      }
    }
    if (middle.empty()) return;
    triangles.swap(next), parent.swap(next_parent);
  }
}

SolidFaces colour_solid_faces(const SolidSurface& solid) {
  check_closed_surface(solid.points, solid.triangles);
  const double first = opposite_faces(solid.points, solid.triangles, true).thickness;
  if (!(first > 0))
    throw InputError("surface: no two opposite faces found, so it is no thick sheet; expected closed thick leaflets, outward oriented");

  SolidFaces f;
  f.points = solid.points, f.triangles = solid.triangles;
  f.thickness_median = first;
  halve_long_edges(f.points, f.triangles, f.parent, first / 4, 400'000);
  std::vector<Vec3> original = f.points;
  f.points = smoothed(f, first / 4);
  average_normals(f, first / 4);

  const std::size_t n = f.points.size();
  const SurfaceQuery query(f.points, f.triangles);
  std::vector<Opposite> opposite(n);
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) {
    opposite[at(i)] = look_across(query, f.normals, f.triangles, f.points[at(i)], f.normals[at(i)], largest_over_median * first);
  });
  f.points = std::move(original);
  std::vector<double> area(n, 0.0);
  for (const Triangle& t : f.triangles)
    for (int v : t) area[at(v)] += area_of(f.points, t) / 3;
  std::vector<std::pair<double, double>> seen;
  double paired = 0, whole = 0;
  for (std::size_t i = 0; i < n; ++i) {
    whole += area[i];
    if (opposite[i].triangle < 0) continue;
    paired += area[i];
    seen.emplace_back(opposite[i].thickness, area[i]);
  }
  f.paired_share = paired / whole;
  f.thickness_thin = weighted_quantile(seen, 0.1);
  f.thickness_median = weighted_quantile(std::move(seen), 0.5);

  const auto edges = edges_of(f.triangles);
  std::vector<SignedEdge> graph;
  for (const auto& [a, b] : edges) {
    const bool both = opposite[at(a)].triangle >= 0 && opposite[at(b)].triangle >= 0;
    const double agree = std::max(f.normals[at(a)].dot(f.normals[at(b)]), 0.0);
    graph.push_back({a, b, (both ? 1 : across_rim_weight) * std::max(agree * agree, 1e-3)});
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (opposite[i].triangle < 0) continue;
    const Triangle& t = f.triangles[at(opposite[i].triangle)];
    for (int k = 0; k < 3; ++k) {
      const double w = std::max(opposite[i].weights[k], 0.0);
      if (w > 0 && t[at(k)] != static_cast<int>(i)) graph.push_back({static_cast<int>(i), t[at(k)], -w});
    }
  }
  const Eigen::VectorXd x = two_colouring(n, graph);

  std::vector<int> sign(n, 0);
  f.thickness.assign(n, 0.0);
  double frustrated = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (opposite[i].triangle < 0) continue;
    const Triangle& t = f.triangles[at(opposite[i].triangle)];
    const Vec3& w = opposite[i].weights;
    const double across = w[0] * x[t[0]] + w[1] * x[t[1]] + w[2] * x[t[2]];
    if (x[static_cast<long>(i)] * across < 0) {
      sign[i] = x[static_cast<long>(i)] > 0 ? 1 : -1;
      f.thickness[i] = opposite[i].thickness;
    } else {
      frustrated += area[i];
    }
  }
  f.frustrated_share = paired > 0 ? frustrated / paired : 1;
  release_small_patches(f, edges, sign);
  f.colour = fill_in(f, edges, sign);
  return f;
}

}  // namespace mv
