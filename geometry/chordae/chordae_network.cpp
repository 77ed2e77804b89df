// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/chordae_network.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

namespace mv {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Union {
 public:
  explicit Union(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  /// False when they were one already.
  bool unite(int i, int j) {
    i = find(i);
    j = find(j);
    parent_[at(std::max(i, j))] = std::min(i, j);
    return i != j;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

Network::Network(const RawChordae& raw) : points(raw.points), is_root(raw.is_root), is_leaflet_end(raw.is_leaflet_end) {
  for (std::size_t s = 0; s < raw.segments.size(); ++s) {
    const auto [a, b] = raw.segments[s];
    segments.push_back({a, b, raw.area[s], raw.rest_length[s], (points[at(a)] - points[at(b)]).norm(), raw.kind[s]});
  }
}

void Network::index() const {
  if (is_indexed_) return;
  at_.assign(points.size(), {});
  for (std::size_t s = 0; s < segments.size(); ++s) {
    at_[at(segments[s].a)].push_back(static_cast<int>(s));
    at_[at(segments[s].b)].push_back(static_cast<int>(s));
  }
  is_indexed_ = true;
}

const std::vector<int>& Network::segments_at(int point) const {
  index();
  return at_[at(point)];
}

std::vector<int> Network::degrees() const {
  index();
  std::vector<int> out;
  for (const auto& list : at_) out.push_back(static_cast<int>(list.size()));
  return out;
}

int Network::other(int segment, int point) const {
  const Segment& s = segments[at(segment)];
  return s.a == point ? s.b : s.a;
}

std::vector<int> Network::pieces() const {
  Union sets(points.size());
  for (const Segment& s : segments) sets.unite(s.a, s.b);
  std::vector<int> out;
  for (std::size_t p = 0; p < points.size(); ++p) out.push_back(sets.find(static_cast<int>(p)));
  return out;
}

std::vector<int> Network::pieces_of_segments(const Ask& cuts) const {
  Union sets(points.size() + 2 * segments.size());
  int extra = static_cast<int>(points.size());
  std::vector<int> first;
  for (const Segment& s : segments) {
    const int a = cuts(s.a) ? extra++ : s.a, b = cuts(s.b) ? extra++ : s.b;
    sets.unite(a, b);
    first.push_back(a);
  }
  for (int& p : first) p = sets.find(p);
  return first;
}

void Network::join(int a, int b) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  segments.push_back({a, b, nan, nan, (points[at(a)] - points[at(b)]).norm(), -1});
  is_indexed_ = false;
}

int Network::erase_segments(const std::function<bool(const Segment&)>& goes) {
  const auto before = segments.size();
  std::erase_if(segments, goes);
  is_indexed_ = false;
  return static_cast<int>(before - segments.size());
}

int Network::prune(int loose_end, const Ask& keeps) {
  int removed = 0;
  for (int p = loose_end; !keeps(p) && segments_at(p).size() == 1;) {
    const int s = segments_at(p)[0], next = other(s, p);
    segments.erase(segments.begin() + s);
    is_indexed_ = false;
    ++removed;
    p = next;
  }
  return removed;
}

int Network::loops(const Ask& cuts) const {
  Union sets(points.size() + 2 * segments.size());
  int loops = 0, extra = static_cast<int>(points.size());
  for (const Segment& s : segments) {
    // A cut point is a point of its own for every segment.
    const int a = cuts(s.a) ? extra++ : s.a, b = cuts(s.b) ? extra++ : s.b;
    loops += !sets.unite(a, b);
  }
  return loops;
}

void Network::merge_runs(const Ask& may_vanish) {
  const auto degree = degrees();
  const auto vanishes = [&](int p) { return degree[at(p)] == 2 && may_vanish(p); };
  std::vector<char> is_done(segments.size(), 0);
  std::vector<Segment> merged;
  const auto follow = [&](int from, int first) {
    Segment run = segments[at(first)];
    run.a = from;
    double flexibility = 0;  // length over area
    run.length = 0;
    double rest = 0;
    int pieces = 0;
    bool is_rest_known = true;
    int s = first, p = from;
    while (true) {
      is_done[at(s)] = 1;
      ++pieces;
      const Segment& piece = segments[at(s)];
      run.length += piece.length;
      flexibility += piece.length / piece.area;
      is_rest_known = is_rest_known && !std::isnan(piece.rest_length);
      rest += piece.rest_length;
      if (piece.kind >= 0) run.kind = piece.kind;
      p = other(s, p);
      if (!vanishes(p) || p == from) break;
      s = segments_at(p)[0] == s ? segments_at(p)[1] : segments_at(p)[0];
      if (is_done[at(s)]) break;
    }
    run.b = p;
    if (pieces > 1) {
      run.area = run.length / flexibility;
      run.rest_length = is_rest_known ? rest : std::numeric_limits<double>::quiet_NaN();
    }
    if (run.a != run.b) merged.push_back(run);  // a run back to where it started carries nothing
  };
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (vanishes(static_cast<int>(p))) continue;
    for (int s : segments_at(static_cast<int>(p)))
      if (!is_done[at(s)]) follow(static_cast<int>(p), s);
  }
  segments = std::move(merged);
  is_indexed_ = false;
}

Network::Paths Network::paths_from(const Ask& is_root_point, const Ask& blocks) const {
  Paths paths;
  paths.distance.assign(points.size(), std::numeric_limits<double>::max());
  paths.segment_towards_root.assign(points.size(), -1);
  paths.root_of.assign(points.size(), -1);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::size_t p = 0; p < points.size(); ++p)
    if (is_root_point(static_cast<int>(p))) {
      paths.distance[p] = 0;
      paths.root_of[p] = static_cast<int>(p);
      queue.emplace(0.0, static_cast<int>(p));
    }
  while (!queue.empty()) {
    const auto [d, p] = queue.top();
    queue.pop();
    if (d > paths.distance[at(p)] || blocks(p)) continue;
    for (int s : segments_at(p)) {
      const int q = other(s, p);
      const double through = d + segments[at(s)].length;
      if (through < paths.distance[at(q)]) {
        paths.distance[at(q)] = through;
        paths.segment_towards_root[at(q)] = s;
        paths.root_of[at(q)] = paths.root_of[at(p)];
        queue.emplace(through, q);
      }
    }
  }
  return paths;
}

}  // namespace mv
