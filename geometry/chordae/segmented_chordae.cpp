// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/chordae/segmented_chordae.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "geometry/chordae/chordae_network.h"
#include "geometry/chordae/insertion.h"
#include "geometry/chordae/leaflet_probe.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double odd_rest = 3;  // of the length in the segmentation

// The last piece of a chorda, in influence radii, may touch the leaflet it ends on.
constexpr double spared_radii = 1.5;
// A network whose nearest point is further from the leaflets than this share of their extent was given in another unit or space.
constexpr double strange_distance = 0.5;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string place_text(const Vec3& x) { return fmt::format("({:.1f}, {:.1f}, {:.1f}) mm", x.x(), x.y(), x.z()); }

// Tips and heads with the muscle of each.
struct Muscles {
  std::vector<Vec3> points;
  std::vector<int> muscle;

  Muscles(const Papillary& papillary, const std::vector<Vec3>& heads) : points(papillary.tips) {
    if (points.empty()) throw InputError("chordae: there is no papillary tip to hang the chordae on; give the papillary points with the valve");
    for (std::size_t i = 0; i < points.size(); ++i) muscle.push_back(static_cast<int>(i));
    const std::size_t tips = points.size();
    for (const Vec3& h : heads) {
      std::size_t best = 0;
      for (std::size_t t = 1; t < tips; ++t)
        if ((points[t] - h).norm() < (points[best] - h).norm()) best = t;
      points.push_back(h);
      muscle.push_back(static_cast<int>(best));
    }
  }
  std::pair<int, double> nearest(const Vec3& x) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
      if ((points[i] - x).norm() < (points[best] - x).norm()) best = i;
    return {muscle[best], (points[best] - x).norm()};
  }
};

// What a point of the network is, and where it goes.
struct PointRole {
  enum Kind { inner, root, end, loose } kind = inner;
  int muscle = -1;
  LeafletProbe::Place place;  // of an end
};

class Attachment {
 public:
  Attachment(const LeafletMesh& mesh, const Papillary& papillary, const std::vector<Vec3>& heads, const RawChordae& raw, const SegmentedOptions& options,
             SegmentedReport& report)
      : mesh_(mesh), probe_(mesh), muscles_(papillary, heads), network_(raw), options_(options), report_(report) {
    report_.notes = raw.notes;
  }

  Chordae run() {
    check_place();
    find_roles();
    join_gaps();
    settle_loose_ends();
    drop_segments_on_leaflet();
    root_the_rootless();
    settle_pieces();
    count_loops();
    for (const Network::Segment& s : network_.segments) report_.length_total += s.length;
    if (options_.merge_runs) network_.merge_runs([&](int p) { return roles_[at(p)].kind == PointRole::inner; });
    classify();
    return build();
  }

 private:
  void check_place() const {
    Vec3 low = mesh_.points[0], high = low;
    for (const Vec3& x : mesh_.points) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    const double extent = (high - low).norm();
    double nearest = std::numeric_limits<double>::max(), size = 0;
    for (const Vec3& p : network_.points) {
      nearest = std::min(nearest, (p - p.cwiseMax(low).cwiseMin(high)).norm());
      size = std::max(size, (p - network_.points[0]).norm());
    }
    if (nearest > strange_distance * extent || size < 0.05 * extent || size > 20 * extent)
      throw InputError(fmt::format("chordae.file: the network is {:.3g} mm across and starts {:.3g} mm away from leaflets that are {:.1f} mm across; check chordae.file_unit (mm?) and "
                                   "chordae.file_space (ras, lps)",
                                   size, nearest, extent));
  }

  void find_roles() {
    roles_.assign(network_.points.size(), {});
    const auto degree = network_.degrees();
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      const Vec3& x = network_.points[p];
      const bool is_said = network_.is_root[p] || network_.is_leaflet_end[p];
      if (!is_said && degree[p] != 1) continue;
      const auto [muscle, to_muscle] = muscles_.nearest(x);
      if (network_.is_root[p]) {
        if (to_muscle > options_.root_reach)
          throw InputError(fmt::format("chordae.file: the root at {} lies {:.1f} mm from the nearest papillary point; raise chordae.root_reach ({:.1f} mm) or check the papillary points",
                                       place_text(x), to_muscle, options_.root_reach));
        roles_[p] = {PointRole::root, muscle, {}};
      } else {
        const auto place = probe_.nearest(x);
        if (place.distance <= options_.end_reach)
          roles_[p] = {PointRole::end, -1, place};
        else if (network_.is_leaflet_end[p])
          throw InputError(fmt::format("chordae.file: the leaflet end at {} lies {:.1f} mm from the leaflets; raise chordae.end_reach ({:.1f} mm) or check that file and valve show the "
                                       "same instant",
                                       place_text(x), place.distance, options_.end_reach));
        else if (to_muscle <= options_.root_reach)
          roles_[p] = {PointRole::root, muscle, {}};
        else
          roles_[p] = {PointRole::loose, -1, place};
      }
    }
  }

  // A loose end goes on to the nearest point of another piece. So does one that passes for a root but lies nearer to the inside of another
  // piece than to its muscle.
  void join_gaps() {
    const auto piece = network_.pieces();
    const auto degree = network_.degrees();
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      const bool may_be_root = roles_[p].kind == PointRole::root && !network_.is_root[p] && degree[p] == 1;
      if (roles_[p].kind != PointRole::loose && !may_be_root) continue;
      int best = -1;
      double distance = may_be_root ? std::min(options_.gap, muscles_.nearest(network_.points[p]).second) : options_.gap;
      for (std::size_t q = 0; q < roles_.size(); ++q) {
        const double d = (network_.points[q] - network_.points[p]).norm();
        if (piece[q] == piece[p] || (may_be_root && roles_[q].kind != PointRole::inner)) continue;
        if (d < distance) {
          distance = d;
          best = static_cast<int>(q);
        }
      }
      if (best < 0) continue;
      network_.join(static_cast<int>(p), best);
      roles_[p].kind = PointRole::inner;
      if (roles_[at(best)].kind == PointRole::loose) roles_[at(best)].kind = PointRole::inner;
      ++report_.joined_gaps;
    }
    if (report_.joined_gaps > 0) report_.notes.push_back(fmt::format("{} gaps of less than {:.2g} mm joined", report_.joined_gaps, options_.gap));
  }

  void settle_loose_ends() {
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      if (roles_[p].kind != PointRole::loose) continue;
      const Vec3& x = network_.points[p];
      if (options_.defects == NetworkDefects::refuse)
        throw InputError(fmt::format("chordae.file: the network ends at {}, {:.1f} mm from the leaflets (chordae.end_reach {:.1f} mm), {:.1f} mm from a papillary point (chordae.root_reach "
                                     "{:.1f} mm) and not within {:.2g} mm of another piece (chordae.gap); mend the segmentation, raise one of these, or set chordae.file_defects = \"drop\"",
                                     place_text(x), roles_[p].place.distance, options_.end_reach, muscles_.nearest(x).second, options_.root_reach, options_.gap));
      const int dropped = network_.prune(static_cast<int>(p), [&](int q) { return roles_[at(q)].kind == PointRole::root || roles_[at(q)].kind == PointRole::end; });
      report_.dropped_segments += dropped;
      report_.notes.push_back(fmt::format("loose end at {} dropped with {} segments", place_text(x), dropped));
      roles_[p].kind = PointRole::inner;
    }
  }

  void drop_segments_on_leaflet() {
    const int dropped = network_.erase_segments([&](const Network::Segment& s) { return roles_[at(s.a)].kind == PointRole::end && roles_[at(s.b)].kind == PointRole::end; });
    if (dropped == 0) return;
    report_.dropped_segments += dropped;
    report_.notes.push_back(fmt::format("{} segments that run from leaflet to leaflet left out", dropped));
  }

  // A muscle's point where several chordae spring is no loose end: in a piece without root the point nearest to a muscle is one.
  void root_the_rootless() {
    const auto piece = network_.pieces_of_segments([&](int p) { return roles_[at(p)].kind == PointRole::end; });
    struct Nearest {
      bool has_root = false;
      int point = -1, muscle = -1;
      double distance = std::numeric_limits<double>::max();
    };
    std::map<int, Nearest> pieces;
    for (std::size_t s = 0; s < piece.size(); ++s)
      for (int p : {network_.segments[s].a, network_.segments[s].b}) {
        Nearest& n = pieces[piece[s]];
        n.has_root |= roles_[at(p)].kind == PointRole::root;
        const auto [muscle, distance] = muscles_.nearest(network_.points[at(p)]);
        if (roles_[at(p)].kind == PointRole::inner && distance < n.distance) {
          n.point = p;
          n.muscle = muscle;
          n.distance = distance;
        }
      }
    for (const auto& [id, n] : pieces)
      if (!n.has_root && n.point >= 0 && n.distance <= options_.root_reach) roles_[at(n.point)] = {PointRole::root, n.muscle, {}};
  }

  // Trees part at leaflet ends and roots: what hangs on the leaflet alone is no chorda.
  void settle_pieces() {
    const auto parts = [&](int p) { return roles_[at(p)].kind == PointRole::end || roles_[at(p)].kind == PointRole::root; };
    const auto piece = network_.pieces_of_segments(parts);
    struct Tally {
      int roots = 0, ends = 0, segments = 0;
      Vec3 nearest_to_muscle = Vec3::Zero();
      double distance = std::numeric_limits<double>::max();
    };
    std::map<int, Tally> tally;
    for (std::size_t s = 0; s < network_.segments.size(); ++s) {
      Tally& t = tally[piece[s]];
      ++t.segments;
      for (int p : {network_.segments[s].a, network_.segments[s].b}) {
        t.roots += roles_[at(p)].kind == PointRole::root;
        t.ends += roles_[at(p)].kind == PointRole::end;
        if (const double d = muscles_.nearest(network_.points[at(p)]).second; d < t.distance) {
          t.distance = d;
          t.nearest_to_muscle = network_.points[at(p)];
        }
      }
    }
    std::vector<char> goes(network_.segments.size(), 0);
    for (const auto& [id, t] : tally) {
      if (t.roots > 0 && t.ends > 0) {
        ++report_.trees;
        continue;
      }
      const std::string what = fmt::format("the piece of {} segments near {} has no {}", t.segments, place_text(t.nearest_to_muscle), t.roots == 0 ? "root" : "leaflet end");
      if (options_.defects == NetworkDefects::refuse)
        throw InputError(fmt::format("chordae.file: {}; its nearest point lies {:.1f} mm from a papillary point (chordae.root_reach {:.1f} mm); join it to the others, raise "
                                     "chordae.root_reach or chordae.end_reach, or set chordae.file_defects = \"drop\"",
                                     what, t.distance, options_.root_reach));
      ++report_.dropped_pieces;
      report_.dropped_segments += t.segments;
      report_.notes.push_back(what + ": dropped");
      for (std::size_t s = 0; s < piece.size(); ++s) goes[s] |= piece[s] == id;
    }
    if (report_.trees == 0) throw InputError("chordae.file: no tree joins a papillary muscle to a leaflet");
    if (report_.dropped_pieces > 0) {
      std::size_t next = 0;
      network_.erase_segments([&](const Network::Segment&) { return goes[next++] != 0; });
    }
  }

  void count_loops() {
    report_.loops = network_.loops([&](int p) { return roles_[at(p)].kind == PointRole::end || roles_[at(p)].kind == PointRole::root; });
    if (report_.loops == 0) return;
    report_.notes.push_back(fmt::format("{} loops (anastomoses) kept", report_.loops));
    if (options_.refuse_loops)
      throw InputError(fmt::format("chordae.file: the network holds {} loops; a tree has none. Cut them, or set chordae.file_loops = \"keep\"", report_.loops));
  }

  ChordaKind kind_at(const LeafletProbe::Place& place, double area) const {
    if (place.to_border < options_.border_band) return ChordaKind::primary;
    if (place.to_annulus < options_.basal_share * place.height()) return ChordaKind::basal;
    if (place.region == anterior && area >= options_.strut_area) return ChordaKind::strut;
    return ChordaKind::secondary;
  }

  // Direction, muscle, leaflet and kind of every segment by the shortest ways from the ends to the roots.
  void classify() {
    const auto paths = network_.paths_from([&](int p) { return roles_[at(p)].kind == PointRole::root; }, [&](int p) { return roles_[at(p)].kind == PointRole::end; });
    const std::size_t n = network_.segments.size();
    std::vector<std::array<int, 5>> kinds(n, {0, 0, 0, 0, 0});
    std::vector<std::map<int, int>> regions(n);
    is_branched_.assign(roles_.size(), 0);
    const auto degree = network_.degrees();
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      if (roles_[p].kind != PointRole::end) continue;
      for (int s : network_.segments_at(static_cast<int>(p))) {
        const ChordaKind kind = network_.segments[at(s)].kind >= 0 ? static_cast<ChordaKind>(network_.segments[at(s)].kind)
                                                                    : kind_at(roles_[p].place, std::isnan(network_.segments[at(s)].area) ? 0.0 : network_.segments[at(s)].area);
        int current = static_cast<int>(p), through = s;
        while (through >= 0) {
          ++kinds[at(through)][static_cast<std::size_t>(kind)];
          ++regions[at(through)][roles_[p].place.region];
          current = network_.other(through, current);
          if (roles_[at(current)].kind == PointRole::root) break;
          if (degree[at(current)] > 2) is_branched_[p] = 1;
          through = paths.segment_towards_root[at(current)];
        }
      }
    }
    leaflet_.assign(n, 0);
    for (std::size_t s = 0; s < n; ++s) {
      Network::Segment& segment = network_.segments[s];
      const bool is_reversed = paths.distance[at(segment.b)] < paths.distance[at(segment.a)] || roles_[at(segment.b)].kind == PointRole::root || roles_[at(segment.a)].kind == PointRole::end;
      if (is_reversed) std::swap(segment.a, segment.b);
      if (segment.kind < 0) segment.kind = static_cast<int>(std::max_element(kinds[s].begin(), kinds[s].end()) - kinds[s].begin());
      int most = 0;
      for (const auto& [region, count] : regions[s])
        if (count > most) {
          most = count;
          leaflet_[s] = region;
        }
      if (most == 0) leaflet_[s] = probe_.nearest(network_.points[at(segment.b)]).region;  // within a loop
      const int from = paths.root_of[at(segment.a)];
      muscle_.push_back(from >= 0 ? roles_[at(from)].muscle : 0);
    }
  }

  Chordae build() {
    const LeafletGraph graph(mesh_);
    std::vector<char> is_used(roles_.size(), 0);
    for (const auto& s : network_.segments) is_used[at(s.a)] = is_used[at(s.b)] = 1;
    int border_ends = 0;
    for (std::size_t p = 0; p < roles_.size(); ++p)
      border_ends += is_used[p] && roles_[p].kind == PointRole::end && roles_[p].place.to_border < options_.border_band;
    Chordae out;
    std::vector<int> index(roles_.size(), -1);
    std::vector<double> radius_of(roles_.size(), 0);
    for (std::size_t p = 0; p < roles_.size(); ++p) {
      if (!is_used[p]) continue;
      index[p] = static_cast<int>(out.points.size());
      const PointRole& role = roles_[p];
      out.muscle_of_point.push_back(role.kind == PointRole::root ? role.muscle : -1);
      out.points.push_back(network_.points[p]);
      if (role.kind == PointRole::root) {
        ++report_.roots;
        report_.root_distance_max = std::max(report_.root_distance_max, muscles_.nearest(network_.points[p]).second);
      }
      if (role.kind == PointRole::inner) report_.branch_points += network_.segments_at(static_cast<int>(p)).size() > 2;
      if (role.kind != PointRole::end) continue;
      const double whole = options_.radius.value_or(influence_radius(probe_.border_length(), border_ends, role.place.height()));
      GrownSphere grown;
      const auto sphere = sphere_at(graph, role.place.position, role.place.position, role.place.normal, is_branched_[p] ? 0.5 * whole : whole, &grown);
      out.points.back() = sphere.end;
      radius_of[p] = grown.radius;
      for (const auto& [node, weight] : sphere.weights) out.insertions.push_back({index[p], node, weight});
      ++report_.ends;
      report_.radius_enlarged += grown.was_enlarged;
      const double moved = (sphere.end - network_.points[p]).norm();
      report_.end_moved_mean += moved;
      report_.end_moved_max = std::max(report_.end_moved_max, moved);
    }
    report_.end_moved_mean /= std::max(report_.ends, 1);
    if (report_.radius_enlarged > 0)
      report_.notes.push_back(fmt::format("{} influence spheres enlarged until they hold both faces of the leaflet", report_.radius_enlarged));
    int taut = 0;
    double most_taut = 0;
    int long_rests = 0;
    for (std::size_t s = 0; s < network_.segments.size(); ++s) {
      const Network::Segment& segment = network_.segments[s];
      ChordaSegment c;
      c.a = index[at(segment.a)];
      c.b = index[at(segment.b)];
      c.kind = static_cast<ChordaKind>(segment.kind);
      c.muscle = muscle_[s];
      c.leaflet = leaflet_[s];
      const bool is_primary = c.kind == ChordaKind::primary || c.kind == ChordaKind::marginal;
      c.area = std::isnan(segment.area) ? (is_primary ? options_.area_primary : options_.area_secondary) : segment.area;
      const double initial = (out.points[at(c.a)] - out.points[at(c.b)]).norm();
      c.rest_length = std::isnan(segment.rest_length) ? std::max(options_.slack * segment.length, initial) : options_.slack * segment.rest_length;
      taut += c.rest_length < initial * (1 - 1e-6);
      most_taut = std::max(most_taut, initial / c.rest_length - 1);
      long_rests += !std::isnan(segment.rest_length) && c.rest_length > odd_rest * initial;
      out.segments.push_back(c);
      const double spared = roles_[at(segment.b)].kind == PointRole::end ? spared_radii * radius_of[at(segment.b)] : 0;
      if (const auto place = probe_.crossing(out.points[at(c.a)], out.points[at(c.b)], spared)) {
        if (report_.crossings++ < 5) report_.notes.push_back("a chorda passes through a leaflet at " + place_text(*place));
      }
    }
    if (long_rests > 0)
      report_.notes.push_back(fmt::format("{} segments have rest lengths of more than {:.0f} times their length: they may never carry; is the unit right (chordae.file_unit)?", long_rests, odd_rest));
    if (taut > 0) report_.notes.push_back(fmt::format("{} segments are stretched at the start, by {:.0f} % at most: their rest length in the file is below their length", taut, 100 * most_taut));
    return out;
  }

  const LeafletMesh& mesh_;
  LeafletProbe probe_;
  Muscles muscles_;
  Network network_;
  const SegmentedOptions& options_;
  SegmentedReport& report_;
  std::vector<PointRole> roles_;
  std::vector<char> is_branched_;
  std::vector<int> leaflet_, muscle_;
};

}  // namespace

Chordae attach_chordae(const LeafletMesh& mesh, const Papillary& papillary, const std::vector<Vec3>& heads, const RawChordae& raw,
                       const SegmentedOptions& options, SegmentedReport* report) {
  if (!(options.slack > 0)) throw ConfigError("chordae.slack must be positive, got " + std::to_string(options.slack));
  SegmentedReport own;
  return Attachment(mesh, papillary, heads, raw, options, report ? *report : own).run();
}

}  // namespace mv
