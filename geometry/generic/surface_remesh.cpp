// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/generic/surface_remesh.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/core/errors.h"

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// 1 for an equilateral triangle, 0 for a degenerate one: 4 sqrt(3) area / sum of squared edges.
double quality(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double squares = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return squares > 0 ? 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / squares : 0;
}

}  // namespace

SurfaceRemesh::SurfaceRemesh(SurfaceMap map, std::vector<Vec2> uv, std::vector<Triangle> triangles, std::vector<char> fixed)
    : map_(std::move(map)), uv_(std::move(uv)), triangles_(std::move(triangles)), fixed_(std::move(fixed)) {
  for (const Vec2& p : uv_) x_.push_back(map_.position(p));
  alive_.assign(triangles_.size(), 1);
  star_.resize(uv_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int v : triangles_[t]) star_[at(v)].push_back(static_cast<int>(t));
}

Vec2 SurfaceRemesh::difference(int a, int b) const { return uv_[at(b)] - uv_[at(a)]; }

double SurfaceRemesh::area_uv(int a, int b, int c) const {
  const Vec2 ab = difference(a, b), ac = difference(a, c);
  return 0.5 * (ab.x() * ac.y() - ab.y() * ac.x());
}

double SurfaceRemesh::area_uv(int a, int b, const Vec2& p) const {
  const Vec2 ab = difference(a, b);
  const Vec2 ap = p - uv_[at(a)];
  return 0.5 * (ab.x() * ap.y() - ab.y() * ap.x());
}

int SurfaceRemesh::triangle_holding(const Vec2& p) const {
  auto crossed_edge = [&](int t) {
    const Triangle& tri = triangles_[at(t)];
    for (int k = 0; k < 3; ++k)
      if (!(area_uv(tri[at(k)], tri[at((k + 1) % 3)], p) > 0)) return k;
    return -1;
  };
  // Walk from the last point; a walk can circle in a mesh that is not Delaunay, then every triangle is tried.
  if (last_inserted_ >= 0) {
    int t = star_[at(last_inserted_)].front();
    for (int step = 0; step < 100 && t >= 0; ++step) {
      const int k = crossed_edge(t);
      if (k < 0) return t;
      const std::array<int, 2> both = triangles_of(triangles_[at(t)][at(k)], triangles_[at(t)][at((k + 1) % 3)]);
      t = both[0] == t ? both[1] : both[0];
    }
  }
  for (int t = 0; t < static_cast<int>(triangles_.size()); ++t)
    if (alive_[at(t)] && crossed_edge(t) < 0) return t;
  return -1;
}

bool SurfaceRemesh::insert(const Vec2& uv) {
  const int t = triangle_holding(uv);
  if (t < 0) return false;
  const int m = static_cast<int>(uv_.size());
  uv_.push_back(uv);
  x_.push_back(map_.position(uv));
  fixed_.push_back(0);
  const auto [a, b, c] = triangles_[at(t)];
  const int t1 = static_cast<int>(triangles_.size()), t2 = t1 + 1;
  triangles_[at(t)] = {a, b, m};
  triangles_.push_back({b, c, m});
  triangles_.push_back({c, a, m});
  alive_.insert(alive_.end(), {1, 1});
  std::erase(star_[at(c)], t);
  star_[at(a)].push_back(t2);
  star_[at(b)].push_back(t1);
  star_[at(c)].insert(star_[at(c)].end(), {t1, t2});
  star_.push_back({t, t1, t2});
  last_inserted_ = m;
  return true;
}

double SurfaceRemesh::cosine_at(int a, int b, int c) const {
  const Vec3 ab = x_[at(b)] - x_[at(a)], ac = x_[at(c)] - x_[at(a)];
  return ab.dot(ac) / (ab.norm() * ac.norm());
}

std::array<int, 2> SurfaceRemesh::triangles_of(int a, int b) const {
  std::array<int, 2> found{-1, -1};
  std::size_t count = 0;
  for (int t : star_[at(a)]) {
    const Triangle& tri = triangles_[at(t)];
    if ((tri[0] == b || tri[1] == b || tri[2] == b) && count < 2) found[count++] = t;
  }
  return found;
}

int SurfaceRemesh::opposite(int triangle, int a, int b) const {
  for (int v : triangles_[at(triangle)])
    if (v != a && v != b) return v;
  return -1;
}

std::vector<int> SurfaceRemesh::neighbours(int a) const {
  std::vector<int> result;
  for (int t : star_[at(a)])
    for (int v : triangles_[at(t)])
      if (v != a && std::find(result.begin(), result.end(), v) == result.end()) result.push_back(v);
  return result;
}

std::vector<std::pair<int, int>> SurfaceRemesh::edges() const {
  std::vector<std::pair<int, int>> result;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (!alive_[t]) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      if (a < b && triangles_of(a, b)[1] >= 0) result.emplace_back(a, b);
    }
  }
  return result;
}

void SurfaceRemesh::replace(int triangle, int from, int to) {
  for (int& v : triangles_[at(triangle)])
    if (v == from) v = to;
}

void SurfaceRemesh::split(int a, int b) {
  const std::array<int, 2> both = triangles_of(a, b);
  const int m = static_cast<int>(uv_.size());
  const Vec2 middle = 0.5 * (uv_[at(a)] + uv_[at(b)]);
  uv_.push_back(middle);
  x_.push_back(map_.position(middle));
  fixed_.push_back(0);
  star_.emplace_back();
  for (int t : both) {
    const int c = opposite(t, a, b);
    Triangle second = triangles_[at(t)];
    for (int& v : second)
      if (v == a) v = m;
    replace(t, b, m);
    const int added = static_cast<int>(triangles_.size());
    triangles_.push_back(second);
    alive_.push_back(1);
    std::erase(star_[at(b)], t);
    star_[at(b)].push_back(added);
    star_[at(c)].push_back(added);
    star_[at(m)].push_back(t);
    star_[at(m)].push_back(added);
  }
}

double SurfaceRemesh::face_distance(int a, int b) const {
  auto normal = [&](int i) { return map_.along_u(uv_[at(i)]).cross(map_.along_v(uv_[at(i)])).normalized(); };
  const Vec3 d = x_[at(b)] - x_[at(a)];
  const Vec3 turn = map_.half_thickness_at ? Vec3(map_.half_thickness_at(uv_[at(b)]) * normal(b) - map_.half_thickness_at(uv_[at(a)]) * normal(a))
                                           : Vec3(map_.half_thickness * (normal(b) - normal(a)));
  return std::max((d + turn).norm(), (d - turn).norm());
}

int SurfaceRemesh::split_where(const std::function<double(int, int)>& excess) {
  std::vector<std::pair<double, std::pair<int, int>>> candidates;
  for (const auto& [a, b] : edges())
    if (const double e = excess(a, b); e > 0) candidates.push_back({e, {a, b}});
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& p, const auto& q) { return p.first > q.first; });
  for (const auto& [e, edge] : candidates) split(edge.first, edge.second);
  return static_cast<int>(candidates.size());
}

int SurfaceRemesh::split_longer_than(double length) {
  return split_where([&](int a, int b) { return distance(a, b) - length; });
}

int SurfaceRemesh::split_longer_on_faces(double length) {
  // Offsetting lengthens an edge by at most its share of half the thickness over the radius of curvature; well below, it is not
  // looked at.
  return split_where([&](int a, int b) { return distance(a, b) > 0.75 * length ? face_distance(a, b) - length : 0.0; });
}

int SurfaceRemesh::split_border_chords(double length) {
  return split_where([&](int a, int b) { return fixed_[at(a)] && fixed_[at(b)] ? distance(a, b) - length : 0.0; });
}

bool SurfaceRemesh::collapse(int a, int b, double longest) {
  if (fixed_[at(a)]) return false;
  const std::vector<int> of_a = neighbours(a), of_b = neighbours(b);
  int common = 0;
  for (int v : of_a) common += std::find(of_b.begin(), of_b.end(), v) != of_b.end();
  if (common != 2) return false;
  for (int v : of_a)
    if (v != b && distance(v, b) > longest) return false;
  for (int t : star_[at(a)]) {
    Triangle tri = triangles_[at(t)];
    if (tri[0] == b || tri[1] == b || tri[2] == b) continue;
    for (int& v : tri)
      if (v == a) v = b;
    if (!(area_uv(tri[0], tri[1], tri[2]) > 0) || quality(x_[at(tri[0])], x_[at(tri[1])], x_[at(tri[2])]) < 0.3) return false;
  }
  for (int t : std::vector<int>(star_[at(a)])) {
    const Triangle tri = triangles_[at(t)];
    if (tri[0] == b || tri[1] == b || tri[2] == b) {
      alive_[at(t)] = 0;
      for (int v : tri) std::erase(star_[at(v)], t);
    } else {
      replace(t, a, b);
      star_[at(b)].push_back(t);
    }
  }
  star_[at(a)].clear();
  return true;
}

int SurfaceRemesh::collapse_shorter_than(double length, double longest) {
  std::vector<std::pair<int, int>> candidates = edges();
  std::erase_if(candidates, [&](const auto& e) { return distance(e.first, e.second) >= length; });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const auto& p, const auto& q) { return distance(p.first, p.second) < distance(q.first, q.second); });
  int count = 0;
  for (const auto& [a, b] : candidates) {
    if (star_[at(a)].empty() || star_[at(b)].empty()) continue;
    const std::array<int, 2> both = triangles_of(a, b);
    if (both[1] < 0 || distance(a, b) >= length) continue;
    if (collapse(a, b, longest) || collapse(b, a, longest)) ++count;
  }
  return count;
}

bool SurfaceRemesh::flip(int a, int b, int t0, int t1) {
  const int c = opposite(t0, a, b), d = opposite(t1, a, b);
  if (triangles_of(c, d)[0] >= 0) return false;
  // t0 is (a, b, c) in its orientation; when it runs b, a the roles of the two triangles swap.
  const Triangle& tri = triangles_[at(t0)];
  bool forward = false;
  for (std::size_t k = 0; k < 3; ++k) forward = forward || (tri[k] == a && tri[(k + 1) % 3] == b);
  const int left = forward ? c : d, right = forward ? d : c;
  if (!(area_uv(a, right, left) > 0) || !(area_uv(right, b, left) > 0)) return false;
  triangles_[at(t0)] = {a, right, left};
  triangles_[at(t1)] = {right, b, left};
  std::erase(star_[at(a)], t1);
  std::erase(star_[at(b)], t0);
  star_[at(c)].push_back(t1);
  star_[at(d)].push_back(t0);
  return true;
}

int SurfaceRemesh::flip_to_delaunay() {
  int total = 0;
  for (int pass = 0; pass < 50; ++pass) {
    int count = 0;
    for (const auto& [a, b] : edges()) {
      const std::array<int, 2> both = triangles_of(a, b);
      if (both[1] < 0) continue;
      const int c = opposite(both[0], a, b), d = opposite(both[1], a, b);
      const double angles =
          std::acos(std::clamp(cosine_at(c, a, b), -1.0, 1.0)) + std::acos(std::clamp(cosine_at(d, a, b), -1.0, 1.0));
      if (angles > std::acos(-1.0) + 1e-6) count += flip(a, b, both[0], both[1]);
    }
    total += count;
    if (count == 0) break;
  }
  return total;
}

double SurfaceRemesh::worst_quality(int a) const {
  double worst = 1;
  for (int t : star_[at(a)]) {
    const Triangle& tri = triangles_[at(t)];
    if (!(area_uv(tri[0], tri[1], tri[2]) > 0)) return -1;
    worst = std::min(worst, quality(x_[at(tri[0])], x_[at(tri[1])], x_[at(tri[2])]));
  }
  return worst;
}

bool SurfaceRemesh::move(int a, const Vec3& target, double relaxation) {
  const Vec2 old_uv = uv_[at(a)];
  const Vec3 old_x = x_[at(a)];
  const double before = worst_quality(a);
  const Vec3 du = map_.along_u(old_uv), dv = map_.along_v(old_uv), step = target - old_x;
  Eigen::Matrix2d metric;
  metric << du.dot(du), du.dot(dv), du.dot(dv), dv.dot(dv);
  const Vec2 shift = metric.inverse() * Vec2(du.dot(step), dv.dot(step));
  for (double factor = relaxation; factor > 0.1 * relaxation; factor *= 0.5) {
    uv_[at(a)] = old_uv + factor * shift;
    x_[at(a)] = map_.position(uv_[at(a)]);
    // A move may cost some quality while that is ample: the sum of neighbouring moves gains more than it loses.
    const double after = worst_quality(a);
    if (after > 0 && (after >= before || after > 0.65)) return true;
  }
  uv_[at(a)] = old_uv;
  x_[at(a)] = old_x;
  return false;
}

void SurfaceRemesh::smooth(int sweeps, double relaxation, int first) {
  std::vector<char> moves(uv_.size(), first == 0);
  for (int a = first; a < size(); ++a) {
    moves[at(a)] = 1;
    for (int b : neighbours(a)) moves[at(b)] = 1;
  }
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (int a = 0; a < size(); ++a) {
      if (!moves[at(a)] || fixed_[at(a)] || star_[at(a)].empty()) continue;
      Vec3 centre = Vec3::Zero();
      double area = 0;
      for (int t : star_[at(a)]) {
        const Triangle& tri = triangles_[at(t)];
        const Vec3 &p = x_[at(tri[0])], &q = x_[at(tri[1])], &r = x_[at(tri[2])];
        const double w = (q - p).cross(r - p).norm();
        centre += w * (p + q + r) / 3;
        area += w;
      }
      // The centroid of the ring contains the point itself with weight 1/3; removing it gives the ring's own centre.
      move(a, (centre / area - x_[at(a)] / 3) * 1.5, relaxation);
    }
}

void SurfaceRemesh::equalise_edges(int sweeps, double power) {
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (int a = 0; a < static_cast<int>(uv_.size()); ++a) {
      if (fixed_[at(a)] || star_[at(a)].empty()) continue;
      const std::vector<int> ring = neighbours(a);
      double longest = 0;
      for (int b : ring) longest = std::max(longest, distance(a, b));
      Vec3 centre = Vec3::Zero();
      double sum = 0;
      for (int b : ring) {
        const double w = std::pow(distance(a, b) / longest, power);
        centre += w * x_[at(b)];
        sum += w;
      }
      move(a, centre / sum, 1.5 / (1.5 + power));
    }
}

void SurfaceRemesh::compact() {
  std::vector<int> index(uv_.size(), -1);
  std::vector<Vec2> uv;
  std::vector<Vec3> x;
  for (std::size_t i = 0; i < uv_.size(); ++i) {
    if (star_[i].empty()) continue;
    index[i] = static_cast<int>(uv.size());
    uv.push_back(uv_[i]);
    x.push_back(x_[i]);
  }
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    if (alive_[t]) kept.push_back({index[at(triangles_[t][0])], index[at(triangles_[t][1])], index[at(triangles_[t][2])]});
  uv_ = std::move(uv);
  x_ = std::move(x);
  triangles_ = std::move(kept);
  alive_.assign(triangles_.size(), 1);
  star_.assign(uv_.size(), {});
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (int v : triangles_[t]) star_[at(v)].push_back(static_cast<int>(t));
  // Fixed points come first and are never removed, so they keep their indices.
  fixed_.resize(uv_.size());
}

std::vector<std::array<int, 3>> triangulate_polygon(const std::vector<Vec2>& polygon) {
  std::vector<int> ring(polygon.size());
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = static_cast<int>(i);
  auto cross = [&](int a, int b, int c) {
    const Vec2 ab = polygon[at(b)] - polygon[at(a)], ac = polygon[at(c)] - polygon[at(a)];
    return ab.x() * ac.y() - ab.y() * ac.x();
  };
  auto ear_quality = [&](std::size_t i) {
    const std::size_t n = ring.size();
    const int a = ring[(i + n - 1) % n], b = ring[i], c = ring[(i + 1) % n];
    const double area = cross(a, b, c);
    if (!(area > 0)) return -1.0;
    for (int p : ring) {
      if (p == a || p == b || p == c) continue;
      if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return -1.0;
    }
    return area / (polygon[at(c)] - polygon[at(a)]).squaredNorm();
  };
  std::vector<std::array<int, 3>> triangles;
  std::vector<double> score(ring.size());
  for (std::size_t i = 0; i < ring.size(); ++i) score[i] = ear_quality(i);
  while (ring.size() > 3) {
    std::size_t i = static_cast<std::size_t>(std::max_element(score.begin(), score.end()) - score.begin());
    if (score[i] < 0) {
      // Ears may have become free when the point that blocked them was cut off.
      for (std::size_t k = 0; k < ring.size(); ++k) score[k] = ear_quality(k);
      i = static_cast<std::size_t>(std::max_element(score.begin(), score.end()) - score.begin());
    }
    if (score[i] < 0) throw GateError("flat pattern: its outline crosses itself and cannot be triangulated");
    const std::size_t n = ring.size();
    triangles.push_back({ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
    score.erase(score.begin() + static_cast<std::ptrdiff_t>(i));
    const std::size_t m = ring.size();
    score[i % m] = ear_quality(i % m);
    score[(i + m - 1) % m] = ear_quality((i + m - 1) % m);
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

}  // namespace mv
