// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/map_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace mv {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
using Edge = std::pair<int, int>;

Edge edge_of(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

/// Joins segments that share end keys into polylines. Keys are any ordered type; `place` gives their coordinates.
template <class Key, class Place>
std::vector<MapLine> chain(const std::vector<std::pair<Key, Key>>& segments, Place&& place) {
  std::multimap<Key, std::size_t> at;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    at.insert({segments[s].first, s});
    at.insert({segments[s].second, s});
  }
  std::vector<char> used(segments.size(), 0);
  const auto follow = [&](Key key, MapLine& line) {
    for (;;) {
      const auto [begin, end] = at.equal_range(key);
      auto next = begin;
      while (next != end && used[next->second] != 0) ++next;
      if (next == end) return;
      used[next->second] = 1;
      const auto& s = segments[next->second];
      key = s.first == key ? s.second : s.first;
      line.push_back(place(key));
    }
  };
  std::vector<MapLine> lines;
  for (std::size_t s = 0; s < segments.size(); ++s) {
    if (used[s] != 0) continue;
    used[s] = 1;
    MapLine back{place(segments[s].second), place(segments[s].first)}, line;
    follow(segments[s].first, back);
    line.assign(back.rbegin(), back.rend());
    follow(segments[s].second, line);
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<MapLine> boundary(const ContactMap& map) {
  std::map<Edge, int> count;
  for (const auto& t : map.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++count[edge_of(t[k], t[(k + 1) % 3])];
  std::vector<std::pair<int, int>> segments;
  for (const auto& [edge, faces] : count)
    if (faces == 1) segments.push_back(edge);
  return chain(segments, [&](int p) { return map.points[static_cast<std::size_t>(p)]; });
}

/// Lines that part the points with flag from those without, through the middles of the edges between them.
std::vector<MapLine> contour(const ContactMap& map, const std::vector<char>& flag) {
  std::vector<std::pair<Edge, Edge>> segments;
  for (const auto& t : map.triangles) {
    std::vector<Edge> cut;
    for (std::size_t k = 0; k < 3; ++k)
      if ((flag[static_cast<std::size_t>(t[k])] != 0) != (flag[static_cast<std::size_t>(t[(k + 1) % 3])] != 0))
        cut.push_back(edge_of(t[k], t[(k + 1) % 3]));
    if (cut.size() == 2) segments.emplace_back(cut[0], cut[1]);
  }
  return chain(segments, [&](const Edge& e) {
    return Vec2((map.points[static_cast<std::size_t>(e.first)] + map.points[static_cast<std::size_t>(e.second)]) / 2);
  });
}

/// Leaflet ends along the annulus: [first, last] u of the anterior leaflet. nullopt when one leaflet is missing.
std::optional<std::array<double, 2>> anterior_range(const ContactMap& map) {
  double a0 = std::numeric_limits<double>::infinity(), a1 = -a0;
  bool has_posterior = false;
  for (const auto& t : map.triangles) {
    bool is_anterior = true;
    for (int p : t) is_anterior = is_anterior && map.region[static_cast<std::size_t>(p)] == anterior;
    if (!is_anterior) {
      has_posterior = true;
      continue;
    }
    for (int p : t) {
      a0 = std::min(a0, map.points[static_cast<std::size_t>(p)].x());
      a1 = std::max(a1, map.points[static_cast<std::size_t>(p)].x());
    }
  }
  if (!has_posterior || a0 >= a1) return std::nullopt;
  return std::array<double, 2>{a0, a1};
}

/// Height of the leaflets over u: lowest cell of each column of the sampled map.
struct Profile {
  static constexpr double step = 0.5;  // mm
  double u0 = 0;
  std::vector<double> height;
  explicit Profile(const ContactMap& map) {
    const MapGrid grid = sample_map(map, step);
    u0 = grid.u0;
    height.assign(static_cast<std::size_t>(grid.columns), 0.0);
    for (int j = 0; j < grid.rows; ++j)
      for (int i = 0; i < grid.columns; ++i)
        if (grid.region[static_cast<std::size_t>(j * grid.columns + i)] != 0)
          height[static_cast<std::size_t>(i)] = grid.v0 + step * j;
  }
  double at(double u) const {
    return height[static_cast<std::size_t>(std::clamp((u - u0) / step, 0.0, static_cast<double>(height.size() - 1)))];
  }
};

/// Middles of the scallops between u0 and u1: the profile is cut at its notches, which lie at least a sixth of its height below
/// the crests on both sides.
std::vector<double> scallop_middles(const Profile& profile, double u0, double u1) {
  std::vector<double> h;
  for (double u = u0 + Profile::step / 2; u < u1; u += Profile::step) h.push_back(profile.at(u));
  if (h.empty()) return {};
  const double depth = *std::max_element(h.begin(), h.end()) / 6;
  std::vector<double> cuts{u0};
  double crest = h[0], floor = h[0];
  std::size_t floor_at = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    if (h[i] < floor) {
      floor = h[i];
      floor_at = i;
    }
    if (crest - floor > depth && h[i] - floor > depth) {
      cuts.push_back(u0 + Profile::step * (0.5 + static_cast<double>(floor_at)));
      crest = floor = h[i];
    } else if (h[i] > crest) {
      crest = floor = h[i];
    }
  }
  cuts.push_back(u1);
  std::vector<double> middles;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) middles.push_back((cuts[i] + cuts[i + 1]) / 2);
  return middles;
}

/// +1 when u grows from the anterolateral to the posteromedial commissure along the anterior leaflet, -1 the other way, 0
/// unknown.
int direction_from_anterolateral(const ContactMap& map, const std::array<double, 2>& range,
                                 const std::optional<LeafletsFrame>& open, const std::optional<ChordaeFrame>& chordae) {
  if (!open || !chordae || map.mesh_point.size() != map.points.size()) return 0;
  const Vec3* tip = nullptr;
  bool has_two = false;
  for (std::size_t i = 0; i < chordae->points.size(); ++i) {
    if (chordae->muscle_of_point[i] == 0) tip = &chordae->points[i];
    has_two = has_two || chordae->muscle_of_point[i] == 1;
  }
  if (tip == nullptr || !has_two) return 0;
  std::array<double, 2> distance{};
  for (std::size_t end = 0; end < 2; ++end) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < map.points.size(); ++i) {
      const double d = (map.points[i] - Vec2(range[end], 0)).norm();
      if (d >= nearest || static_cast<std::size_t>(map.mesh_point[i]) >= open->mesh.points.size()) continue;
      nearest = d;
      distance[end] = (open->mesh.points[static_cast<std::size_t>(map.mesh_point[i])] - *tip).norm();
    }
  }
  return distance[0] < distance[1] ? 1 : -1;
}

}  // namespace

double round_up_nicely(double x) {
  if (!(x > 0)) return 1;
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (double step : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
    if (x <= step * power * (1 + 1e-12)) return step * power;
  return 10 * power;
}

MapView make_map_view(const ContactMap& map, const std::optional<LeafletsFrame>& open,
                      const std::optional<ChordaeFrame>& chordae) {
  MapView view;
  view.lower = view.upper = map.points[0];
  for (const Vec2& p : map.points) {
    view.lower = view.lower.cwiseMin(p);
    view.upper = view.upper.cwiseMax(p);
  }
  view.outline = boundary(map);
  std::vector<char> flag = map.in_belt;
  if (flag.empty())
    for (double p : map.contact_pressure) flag.push_back(p > 0);
  view.belt = contour(map, flag);

  const auto range = anterior_range(map);
  if (!range) return view;
  const Profile profile(map);
  const int direction = direction_from_anterolateral(map, *range, open, chordae);
  const auto name = [&](const char* letter, std::size_t i, std::size_t count, bool is_along) {
    return letter + std::to_string(is_along ? i + 1 : count - i);
  };
  const auto [a0, a1] = *range;
  for (std::size_t i = 0; i < 3; ++i) {
    const double u = a0 + (a1 - a0) * (static_cast<double>(i) + 0.5) / 3;
    view.labels.push_back({name("A", i, 3, direction >= 0), u, profile.at(u) / 2});
  }
  // the posterior leaflet runs back from the other commissure; it may lie on both sides of the anterior one on the map
  std::vector<double> middles = scallop_middles(profile, a1, view.upper.x());
  if (a0 - view.lower.x() > 2) {
    const std::vector<double> before = scallop_middles(profile, view.lower.x(), a0);
    middles.insert(middles.end(), before.begin(), before.end());
  }
  for (std::size_t i = 0; i < middles.size(); ++i)
    view.labels.push_back({name("P", i, middles.size(), direction < 0), middles[i], profile.at(middles[i]) / 2});
  const char* names[] = {"anterolateral commissure", "posteromedial commissure"};
  const auto commissure = [&](double u, int which) {
    view.labels.push_back({direction == 0 ? "commissure" : names[which], u, 0, true});
    view.commissures.push_back({Vec2(u, 0), Vec2(u, std::min({profile.at(u - 1), profile.at(u), profile.at(u + 1)}))});
  };
  commissure(a0, direction < 0 ? 1 : 0);
  commissure(a1, direction < 0 ? 0 : 1);
  if (a0 - view.lower.x() < 1 && view.upper.x() - a1 > 2) commissure(view.upper.x(), direction < 0 ? 1 : 0);
  return view;
}

MapGrid sample_map(const ContactMap& map, double step) {
  Vec2 lower = map.points[0], upper = map.points[0];
  for (const Vec2& p : map.points) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  MapGrid grid;
  grid.step = step;
  grid.u0 = lower.x() + step / 2;
  grid.v0 = lower.y() + step / 2;
  grid.columns = std::max(1, static_cast<int>(std::ceil((upper.x() - lower.x()) / step)));
  grid.rows = std::max(1, static_cast<int>(std::ceil((upper.y() - lower.y()) / step)));
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  grid.pressure.assign(cells, nan);
  grid.gap.assign(cells, nan);
  grid.region.assign(cells, 0);
  for (const auto& t : map.triangles) {
    const auto p = [&](std::size_t k) -> const Vec2& { return map.points[static_cast<std::size_t>(t[k])]; };
    const Vec2 e1 = p(1) - p(0), e2 = p(2) - p(0);
    const double area = e1.x() * e2.y() - e1.y() * e2.x();
    if (area == 0) continue;
    const Vec2 lo = p(0).cwiseMin(p(1)).cwiseMin(p(2)), hi = p(0).cwiseMax(p(1)).cwiseMax(p(2));
    const int i0 = std::max(0, static_cast<int>(std::floor((lo.x() - grid.u0) / step))),
              i1 = std::min(grid.columns - 1, static_cast<int>(std::ceil((hi.x() - grid.u0) / step)));
    const int j0 = std::max(0, static_cast<int>(std::floor((lo.y() - grid.v0) / step))),
              j1 = std::min(grid.rows - 1, static_cast<int>(std::ceil((hi.y() - grid.v0) / step)));
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) {
        const Vec2 d = Vec2(grid.u0 + step * i, grid.v0 + step * j) - p(0);
        const double w1 = (d.x() * e2.y() - d.y() * e2.x()) / area, w2 = (e1.x() * d.y() - e1.y() * d.x()) / area,
                     w0 = 1 - w1 - w2;
        constexpr double edge = -1e-9;
        if (w0 < edge || w1 < edge || w2 < edge) continue;
        const std::array<double, 3> w{w0, w1, w2};
        const auto cell = static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.columns) + static_cast<std::size_t>(i);
        const auto nearest =
            static_cast<std::size_t>(t[static_cast<std::size_t>(std::max_element(w.begin(), w.end()) - w.begin())]);
        // contact ends half way between a point with pressure and one without, as the belt's outline is drawn
        double pressure = 0, touching = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const double at_corner = map.contact_pressure[static_cast<std::size_t>(t[k])];
          pressure += w[k] * at_corner;
          touching += at_corner > 0 ? w[k] : 0;
        }
        grid.pressure[cell] = touching >= 0.5 ? pressure : 0;
        grid.gap[cell] = map.gap[nearest];
        grid.region[cell] = map.region[nearest];
      }
  }
  return grid;
}

}  // namespace mv
