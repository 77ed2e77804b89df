// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/leaflet_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/side_faces.h"
#include "geometry/core/unfolded.h"

namespace mv {
namespace {

constexpr double notch_prominence = 0.1;  // share of the leaflet's height
constexpr long bin_count = 128;           // strips of u in which a point of the pattern is looked for

std::size_t at_index(int i) { return static_cast<std::size_t>(i); }

long bin_of(double u, double period) { return static_cast<long>(std::floor(u / period * static_cast<double>(bin_count))); }

// Barycentric coordinates of the point of triangle (a, b, c) nearest to p, all in the plane.
Vec3 nearest_barycentric(const Vec2& p, const Vec2& a, const Vec2& b, const Vec2& c) {
  const auto cross = [](const Vec2& x, const Vec2& y) { return x.x() * y.y() - x.y() * y.x(); };
  const double area = cross(b - a, c - a);
  if (area != 0) {
    const Vec3 inside(cross(b - p, c - p) / area, cross(c - p, a - p) / area, cross(a - p, b - p) / area);
    if (inside.minCoeff() >= 0) return inside;
  }
  const std::array<const Vec2*, 3> corner{&a, &b, &c};
  Vec3 best = Vec3::UnitX();
  double best_distance = std::numeric_limits<double>::max();
  for (int i = 0; i < 3; ++i) {
    const Vec2 &from = *corner[at_index(i)], &to = *corner[at_index((i + 1) % 3)];
    const double length2 = (to - from).squaredNorm();
    const double t = length2 > 0 ? std::clamp((p - from).dot(to - from) / length2, 0.0, 1.0) : 0.0;
    const double distance = (from + t * (to - from) - p).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best = Vec3::Zero();
      best[i] = 1 - t;
      best[(i + 1) % 3] = t;
    }
  }
  return best;
}

}  // namespace

LeafletChart::LeafletChart(const LeafletMesh& mesh) : points_(mesh.points), unfolded_(mesh.unfolded) {
  const std::size_t n = mesh.points.size();
  if (n == 0 || mesh.tets.empty()) throw InputError("chordae: the leaflet mesh is empty; run the mesh stage first");
  if (mesh.unfolded.size() != n || mesh.side.size() != n || mesh.on_annulus.size() != n || mesh.on_free_edge.size() != n ||
      mesh.region.size() != mesh.tets.size())
    throw InputError(
        "chordae: leaflet arrays unfolded, side, annulus, free_edge and region must be complete; run the mesh stage first");
  period_ = unfolded_period(mesh);
  if (!(period_ > 0))
    throw InputError("chordae: the leaflets do not form a closed ring (the unfolded coordinate u is not periodic)");
  atrial_ = side_face(mesh, atrial);
  ventricular_ = side_face(mesh, ventricular);
  if (atrial_.triangles.empty() || ventricular_.triangles.empty())
    throw InputError("chordae: the leaflet mesh has no atrial or no ventricular face (point array 'side')");
  sort_into_bins(atrial_);
  sort_into_bins(ventricular_);
  build_border(mesh);
  find_junctions();
}

LeafletChart::Face LeafletChart::side_face(const LeafletMesh& mesh, int side) {
  Face face;
  for (const SideTriangle& t : side_triangles(mesh, side)) {
    face.triangles.push_back(t.nodes);
    face.regions.push_back(mesh.region[t.element]);
  }
  return face;
}

void LeafletChart::sort_into_bins(Face& face) const {
  face.bins.assign(bin_count, {});
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    const double first = unfolded_[at_index(face.triangles[t][0])].x();
    double low = first, high = first;
    for (int p : face.triangles[t]) {
      const double u = nearest_image(unfolded_[at_index(p)].x(), first, period_);
      low = std::min(low, u);
      high = std::max(high, u);
    }
    for (long k = bin_of(low, period_); k <= bin_of(high, period_); ++k)
      face.bins[static_cast<std::size_t>((k % bin_count + bin_count) % bin_count)].push_back(static_cast<int>(t));
  }
}

LeafletChart::Hit LeafletChart::locate(const Face& face, const Vec2& uv) const {
  Hit hit{Vec3::Zero(), 0};
  double best = std::numeric_limits<double>::max();
  int best_triangle = -1;
  const auto visit = [&](int triangle) {
    const std::size_t t = at_index(triangle);
    std::array<Vec2, 3> p;
    double gap_v = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = unfolded_[at_index(face.triangles[t][i])];
      p[i].x() = nearest_image(p[i].x(), i == 0 ? uv.x() : p[0].x(), period_);
    }
    // A triangle cannot be nearer than its bounding box in v.
    const double low = std::min({p[0].y(), p[1].y(), p[2].y()}), high = std::max({p[0].y(), p[1].y(), p[2].y()});
    gap_v = std::max({low - uv.y(), uv.y() - high, 0.0});
    if (gap_v * gap_v > best) return;
    const Vec3 w = nearest_barycentric(uv, p[0], p[1], p[2]);
    const double distance = (w[0] * p[0] + w[1] * p[1] + w[2] * p[2] - uv).squaredNorm();
    // Of equally near triangles the first counts, whatever the order in which they are met.
    if (distance < best || (distance == best && triangle < best_triangle)) {
      best = distance;
      best_triangle = triangle;
      hit.region = face.regions[t];
      hit.position.setZero();
      for (int i = 0; i < 3; ++i)
        hit.position += w[i] * points_[at_index(face.triangles[t][at_index(i)])];
    }
  };
  const long middle = bin_of(uv.x(), period_);
  const double width = period_ / bin_count, within = uv.x() - static_cast<double>(middle) * width;
  for (long k = 0; 2 * k <= bin_count; ++k) {
    // Everything within k - 1 strips has been met.
    const double clear = static_cast<double>(k - 1) * width + std::min(within, width - within);
    if (k > 0 && clear > 0 && clear * clear > best) break;
    for (const long bin : {middle - k, middle + k}) {
      for (int t : face.bins[static_cast<std::size_t>((bin % bin_count + bin_count) % bin_count)]) visit(t);
      if (k == 0) break;
    }
  }
  return hit;
}

LeafletChart::SurfacePoint LeafletChart::at(const Vec2& uv) const {
  const Hit a = locate(atrial_, uv), b = locate(ventricular_, uv);
  return {0.5 * (a.position + b.position), (a.position - b.position).normalized(), a.region};
}

void LeafletChart::build_border(const LeafletMesh& mesh) {
  // Edges of the atrial face that only one triangle uses; those between free-edge points make up the border.
  std::map<std::pair<int, int>, std::pair<int, int>> edges;  // edge -> uses, region
  for (std::size_t t = 0; t < atrial_.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = atrial_.triangles[t][i], b = atrial_.triangles[t][(i + 1) % 3];
      auto& entry = edges[{std::min(a, b), std::max(a, b)}];
      ++entry.first;
      entry.second = atrial_.regions[t];
    }
  std::map<int, std::vector<std::pair<int, int>>> links;  // point -> (next point, region)
  std::size_t count = 0;
  for (const auto& [edge, use] : edges) {
    if (use.first != 1 || !mesh.on_free_edge[at_index(edge.first)] || !mesh.on_free_edge[at_index(edge.second)]) continue;
    links[edge.first].emplace_back(edge.second, use.second);
    links[edge.second].emplace_back(edge.first, use.second);
    ++count;
  }
  if (links.empty()) throw InputError("chordae: the leaflets have no free border (point array 'free_edge')");
  for (const auto& [point, list] : links)
    if (list.size() != 2)
      throw InputError("chordae: the free border is not one closed curve: " + std::to_string(list.size()) +
                       " border edges meet at leaflet point " + std::to_string(point));
  std::vector<int> loop;
  std::vector<int> region;  // of the edge after each point
  int previous = -1, current = links.begin()->first;
  do {
    const auto& list = links.at(current);
    const auto& next = previous >= 0 && list[0].first == previous ? list[1] : list[0];
    loop.push_back(current);
    region.push_back(next.second);
    previous = current;
    current = next.first;
  } while (current != loop.front() && loop.size() <= count);
  if (loop.size() != count) throw InputError("chordae: the leaflets have more than one free border");

  double turn = 0;
  const std::size_t n = loop.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double u = unfolded_[at_index(loop[i])].x();
    turn += nearest_image(unfolded_[at_index(loop[(i + 1) % n])].x(), u, period_) - u;
  }
  if (std::abs(std::abs(turn) - period_) > 0.5 * period_)
    throw InputError("chordae: the free border does not run once round the unfolded valve");
  if (turn < 0) {
    std::reverse(loop.begin(), loop.end());
    std::rotate(region.begin(), region.end() - 1, region.end());
    std::reverse(region.begin(), region.end());
  }
  std::size_t first = n;
  int changes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const int before = region[(i + n - 1) % n];
    changes += before != region[i];
    if (before != anterior && region[i] == anterior) first = i;
  }
  if (changes != 2 || first == n)
    throw InputError("chordae: the free border must pass one anterior and one posterior leaflet, but its region changes " +
                     std::to_string(changes) + " times");
  std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(first), loop.end());
  std::rotate(region.begin(), region.begin() + static_cast<std::ptrdiff_t>(first), region.end());
  for (std::size_t i = 0; i < n; ++i) {
    BorderPoint p;
    p.uv = unfolded_[at_index(loop[i])];
    if (i > 0) p.uv.x() = nearest_image(p.uv.x(), border_.back().uv.x(), period_);
    p.position = at(p.uv).position;
    p.arc = i > 0 ? border_.back().arc + (p.position - border_.back().position).norm() : 0.0;
    p.region = region[i];
    border_.push_back(p);
  }
  border_length_ = border_.back().arc + (border_.front().position - border_.back().position).norm();
}

void LeafletChart::find_junctions() {
  const int n = static_cast<int>(border_.size());
  const auto v = [&](int i) { return border_[at_index(i)].uv.y(); };
  int second = 0;
  while (border_[at_index(second)].region == anterior)
    ++second;
  junctions_.push_back({0, true});
  const auto add_notches = [&](int begin, int end) {  // border points begin..end (end may be n, the first point again)
    const auto value = [&](int i) { return v(i % n); };
    double highest = 0;
    for (int i = begin; i <= end; ++i)
      highest = std::max(highest, value(i));
    for (int i = begin + 1; i < end; ++i) {
      double left = value(i), right = value(i);
      for (int k = i - 1; k >= begin && value(k) >= value(i); --k)
        left = std::max(left, value(k));
      // Of several equal minima in one notch the last counts.
      for (int k = i + 1; k <= end && value(k) > value(i); ++k)
        right = std::max(right, value(k));
      if (std::min(left, right) - value(i) >= notch_prominence * highest) junctions_.push_back({i, false});
    }
  };
  add_notches(0, second);
  junctions_.push_back({second, true});
  add_notches(second, n);
}

Vec2 LeafletChart::border_uv(double arc) const {
  arc -= border_length_ * std::floor(arc / border_length_);
  const auto after =
      std::upper_bound(border_.begin(), border_.end(), arc, [](double s, const BorderPoint& p) { return s < p.arc; });
  const BorderPoint& a = *(after - 1);
  Vec2 b_uv = border_.front().uv + Vec2(period_, 0);
  double b_arc = border_length_;
  if (after != border_.end()) {
    b_uv = after->uv;
    b_arc = after->arc;
  }
  return a.uv + (b_uv - a.uv) * ((arc - a.arc) / (b_arc - a.arc));
}

double LeafletChart::height(double u) const {
  double highest = 0;
  for (std::size_t i = 0; i < border_.size(); ++i) {
    const Vec2 a = border_[i].uv;
    const Vec2 b = i + 1 < border_.size() ? border_[i + 1].uv : Vec2(border_.front().uv + Vec2(period_, 0));
    const double x = nearest_image(u, 0.5 * (a.x() + b.x()), period_);
    const double low = std::min(a.x(), b.x()), high = std::max(a.x(), b.x());
    if (x < low || x > high) continue;
    const double t = high > low ? (x - a.x()) / (b.x() - a.x()) : 0.5;
    highest = std::max(highest, high > low ? a.y() + t * (b.y() - a.y()) : std::max(a.y(), b.y()));
  }
  return highest;
}

}  // namespace mv
