// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/guides.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <set>

#include "fibers/leaflet_pattern.h"
#include "geometry/core/errors.h"
#include "geometry/core/unfolded.h"

namespace mv {
namespace {

// The guide counts for nodes closer than this share of the mean edge length, so that it forms an unbroken row.
constexpr double guide_reach = 0.6;
// The guide keeps this share of the lowest border between its ends, so that it passes notches on the annulus side.
constexpr double notch_clearance = 0.8;
// The commissure rule ends here (share of the half width): beyond it the border turns through the fillet of the commissure
// itself.
constexpr double commissure_rule_end = 0.9;
// Outlines are sampled at this share of the mean edge length.
constexpr double outline_step = 0.125;
// A chorda counts where its weight is at least this share of its largest, and where this much of its direction lies in the leaflet.
constexpr double chorda_core = 0.3;
constexpr double chorda_tangent = 0.2;
// Guides found from chordae end within these shares of the half width.
constexpr double end_least = 0.35, end_most = 0.9;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct GuideEnds {
  double left, right;  // share of the half width
};

std::vector<GuidePoint> arc_guides(const LeafletMesh& mesh, const LeafletPattern& leaflet, int region, const ArcShape& arc, GuideEnds ends, double border_middle) {
  const double v_end_left = leaflet.border(-ends.left), v_end_right = leaflet.border(ends.right);
  const double v_apex = std::min(arc.apex * leaflet.tallest(), notch_clearance * leaflet.lowest_border(ends.left, ends.right));
  std::vector<GuidePoint> given;
  const auto give = [&](int i, const Vec3& direction, const char* rule) { given.push_back({{i, direction, 1}, rule, region}); };
  for (int i : leaflet.nodes()) {
    const double t = leaflet.t(i), side = t < 0 ? -1.0 : 1.0, end = t < 0 ? ends.left : ends.right;
    const Vec3 &xu = leaflet.along_u(i), &xv = leaflet.along_v(i);
    if (mesh.on_annulus[at(i)]) give(i, xu, "annulus");
    if (std::abs(t) <= end) {
      const double rise = (t < 0 ? v_end_left : v_end_right) - v_apex, along = std::abs(t) / end;
      const double v_arc = v_apex + rise * std::pow(along, arc.power);
      const double slope = side * rise * arc.power * std::pow(along, arc.power - 1) / (end * leaflet.half_width());
      if (std::abs(leaflet.v(i) - v_arc) / std::hypot(1.0, slope) < guide_reach * leaflet.spacing()) give(i, xu + slope * xv, "guide");
    }
    if (!mesh.on_free_edge[at(i)]) continue;
    if (std::abs(t) <= border_middle) {
      give(i, xu, "border middle");
    } else if (std::abs(t) >= end && std::abs(t) <= commissure_rule_end) {
      const double step = 0.5 * leaflet.spacing() / leaflet.half_width();
      const double slope = (leaflet.border(t + step) - leaflet.border(t - step)) / (2 * step * leaflet.half_width());
      if (side * slope < 0) give(i, leaflet.normal(i).cross(xu + slope * xv), "commissure");
    }
  }
  return given;
}

// Leaflet nodes of one region.
std::vector<char> nodes_of(const LeafletMesh& mesh, const LeafletPattern& leaflet) {
  std::vector<char> is_there(mesh.points.size(), 0);
  for (int i : leaflet.nodes()) is_there[at(i)] = 1;
  return is_there;
}

std::set<int> leaflet_ends(const Chordae& chordae) {
  std::set<int> ends;
  for (const Insertion& i : chordae.insertions) ends.insert(i.point);
  return ends;
}

// Where the two groups of chordae ends of this leaflet lie: mean |t| of the ends left and right of its middle.
GuideEnds ends_of_groups(const LeafletMesh& mesh, const LeafletPattern& leaflet, const Chordae& chordae, const ArcShape& shape) {
  const std::vector<char> is_there = nodes_of(mesh, leaflet);
  std::map<int, Vec2> place;  // end -> sum of (weight t, weight)
  for (const Insertion& i : chordae.insertions)
    if (is_there[at(i.node)]) place.try_emplace(i.point, Vec2::Zero()).first->second += i.weight * Vec2(leaflet.t(i.node), 1);
  double sum[2] = {0, 0};
  int count[2] = {0, 0};
  for (const auto& [end, s] : place) {
    const double t = s.x() / s.y();
    if (std::abs(t) > commissure_rule_end || std::abs(t) < 0.1) continue;
    sum[t > 0] += std::abs(t);
    ++count[t > 0];
  }
  const auto mean = [&](int side) { return count[side] > 0 ? std::clamp(sum[side] / count[side], end_least, end_most) : shape.end; };
  return {mean(0), mean(1)};
}

struct Sample {
  Vec3 x, tangent;
};

// Catmull-Rom through the drawn points, by chord length, sampled evenly.
std::vector<Sample> smooth_samples(const std::vector<Vec3>& drawn, double step) {
  std::vector<Vec3> p;
  for (const Vec3& x : drawn)
    if (p.empty() || (x - p.back()).norm() > 1e-9) p.push_back(x);
  if (p.size() < 2) throw InputError("fibers.outline: a curve needs at least two different points");
  std::vector<Sample> out;
  const auto tangent = [&](std::size_t i) -> Vec3 {
    if (i == 0) return p.size() > 2 ? Vec3(2 * (p[1] - p[0]).normalized() - (p[2] - p[0]).normalized()) : Vec3((p[1] - p[0]).normalized());
    const std::size_t n = p.size();
    if (i + 1 == n) return n > 2 ? Vec3(2 * (p[n - 1] - p[n - 2]).normalized() - (p[n - 1] - p[n - 3]).normalized()) : Vec3((p[n - 1] - p[n - 2]).normalized());
    // Parabola through three points by chord length.
    const double a = (p[i] - p[i - 1]).norm(), b = (p[i + 1] - p[i]).norm();
    return Vec3((b / a * (p[i] - p[i - 1]) + a / b * (p[i + 1] - p[i])) / (a + b));
  };
  for (std::size_t i = 0; i + 1 < p.size(); ++i) {
    const double length = (p[i + 1] - p[i]).norm();
    const Vec3 m0 = length * tangent(i), m1 = length * tangent(i + 1);
    const int steps = std::max(1, static_cast<int>(std::ceil(length / step)));
    for (int k = i == 0 ? 0 : 1; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps, t2 = t * t, t3 = t2 * t;
      const Vec3 x = (2 * t3 - 3 * t2 + 1) * p[i] + (t3 - 2 * t2 + t) * m0 + (-2 * t3 + 3 * t2) * p[i + 1] + (t3 - t2) * m1;
      const Vec3 d = (6 * t2 - 6 * t) * p[i] + (3 * t2 - 4 * t + 1) * m0 + (-6 * t2 + 6 * t) * p[i + 1] + (3 * t2 - 2 * t) * m1;
      out.push_back({x, d.normalized()});
    }
  }
  return out;
}

std::vector<GuidePoint> outline_guides(const LeafletMesh& mesh, const LeafletPattern& leaflet, int region, const FiberOptions& options) {
  std::vector<GuidePoint> given;
  std::vector<Sample> samples;
  const std::vector<char> is_there = nodes_of(mesh, leaflet);
  for (const auto& drawn : options.outlines)
    for (Sample s : smooth_samples(drawn, outline_step * leaflet.spacing())) {
      int best = -1;
      double distance = 1e300;
      for (std::size_t i = 0; i < mesh.points.size(); ++i)
        if (const double d = (mesh.points[i] - s.x).squaredNorm(); d < distance) {
          distance = d;
          best = static_cast<int>(i);
        }
      if (std::sqrt(distance) > options.outline_reach)
        throw InputError(fmt::format("fibers.outline: the curve point ({:.1f}, {:.1f}, {:.1f}) mm lies {:.1f} mm from the leaflets; raise fibers.outline_reach ({:.1f} mm), or check unit and space of the file", s.x.x(),
                                     s.x.y(), s.x.z(), std::sqrt(distance), options.outline_reach));
      if (is_there[at(best)]) samples.push_back(s);
    }
  if (samples.empty()) return given;
  const double reach = guide_reach * leaflet.spacing();
  for (int i : leaflet.nodes()) {
    const Vec3 &x = mesh.points[at(i)], &n = leaflet.normal(i);
    const Sample* nearest = nullptr;
    double closest = reach;
    for (const Sample& s : samples) {
      Vec3 away = s.x - x;
      if (std::abs(away.dot(n)) > options.outline_reach + leaflet.spacing()) continue;
      away -= n * n.dot(away);
      if (const double d = away.norm(); d < closest) {
        closest = d;
        nearest = &s;
      }
    }
    if (!nearest) continue;
    const Vec3 direction = nearest->tangent - n * n.dot(nearest->tangent);
    if (direction.norm() > chorda_tangent) given.push_back({{i, direction.normalized(), 1}, "outline", region});
  }
  return given;
}

// The last segment of every chorda goes on into the leaflet where it holds it.
std::vector<GuidePoint> chordae_guides(const LeafletMesh& mesh, const LeafletPattern& leaflet, int region, const FiberOptions& options) {
  const Chordae& chordae = *options.chordae;
  const std::vector<char> is_there = nodes_of(mesh, leaflet);
  const std::set<int> ends = leaflet_ends(chordae);
  std::map<int, double> largest;
  for (const Insertion& i : chordae.insertions) largest[i.point] = std::max(largest[i.point], i.weight);
  std::map<int, std::vector<Vec3>> directions;
  for (const ChordaSegment& s : chordae.segments)
    for (const auto& [end, other] : {std::pair(s.b, s.a), std::pair(s.a, s.b)})
      if (ends.count(end)) directions[end].push_back((chordae.points[at(end)] - chordae.points[at(other)]).normalized());
  std::vector<GuidePoint> given;
  std::vector<char> is_held(mesh.points.size(), 0);
  for (const Insertion& i : chordae.insertions) {
    is_held[at(i.node)] = 1;
    if (!is_there[at(i.node)] || i.weight < chorda_core * largest[i.point]) continue;
    const Vec3& n = leaflet.normal(i.node);
    for (const Vec3& d : directions[i.point]) {
      const Vec3 tangent = d - n * n.dot(d);
      if (tangent.norm() > chorda_tangent) given.push_back({{i.node, tangent.normalized(), i.weight / largest[i.point] * tangent.norm()}, "chordae", region});
    }
  }
  for (int i : leaflet.nodes()) {
    if (mesh.on_annulus[at(i)]) given.push_back({{i, leaflet.along_u(i), 1}, "annulus", region});
    if (mesh.on_free_edge[at(i)] && !is_held[at(i)] && std::abs(leaflet.t(i)) <= options.border_middle) given.push_back({{i, leaflet.along_u(i), 1}, "border middle", region});
  }
  return given;
}

void check_shape(const ArcShape& a, const char* leaflet) {
  if (!(a.end > 0 && a.end < 1) || !(a.apex > 0 && a.apex < 1) || !(a.power >= 1))
    throw ConfigError(std::string("fibers: arc of the ") + leaflet + " leaflet needs 0 < end < 1, 0 < apex < 1 and power >= 1");
}

}  // namespace

std::vector<GuidePoint> guide_points(const LeafletMesh& mesh, int region, const FiberOptions& options) {
  check_shape(options.anterior, "anterior");
  check_shape(options.posterior, "posterior");
  const std::size_t n = mesh.points.size();
  if (mesh.unfolded.size() != n || mesh.on_annulus.size() != n || mesh.on_free_edge.size() != n || mesh.side.size() != n)
    throw InputError("fibers: arcs need the point arrays unfolded, annulus, free_edge and side; run the mesh stage first");
  const LeafletPattern leaflet(mesh, region, unfolded_period(mesh));
  if (leaflet.elements().empty()) return {};
  const bool needs_chordae = options.model == FiberModel::chordae || options.guide_from_chordae;
  if (needs_chordae && (!options.chordae || options.chordae->insertions.empty()))
    throw InputError("fibers: the case has no chordae to find directions from; run the chordae stage, or use fibers.model = \"arc\" with fibers.guide = \"shape\"");
  if (options.model == FiberModel::chordae) return chordae_guides(mesh, leaflet, region, options);
  const ArcShape& shape = region == anterior ? options.anterior : options.posterior;
  const GuideEnds ends = options.guide_from_chordae ? ends_of_groups(mesh, leaflet, *options.chordae, shape) : GuideEnds{shape.end, shape.end};
  std::vector<GuidePoint> arcs = arc_guides(mesh, leaflet, region, shape, ends, options.border_middle);
  if (options.model != FiberModel::outline) return arcs;
  std::vector<GuidePoint> given = outline_guides(mesh, leaflet, region, options);
  if (given.empty()) return arcs;  // nothing drawn on this leaflet
  // What is drawn replaces the guide and, near it, everything else.
  std::set<int> drawn;
  for (const GuidePoint& g : given) drawn.insert(g.given.node);
  for (const GuidePoint& g : arcs)
    if (std::string(g.rule) != "guide" && !drawn.count(g.given.node)) given.push_back(g);
  return given;
}

std::vector<GuidePoint> all_guide_points(const LeafletMesh& mesh, const Annulus& annulus, const FiberOptions& options) {
  std::vector<GuidePoint> all;
  if (options.model == FiberModel::none) return all;
  if (options.model == FiberModel::parallel) {
    for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
      const Vec3 direction = annulus.normal.normalized().cross(mesh.sheet_normal[e]);
      if (direction.norm() >= flat_sine) all.push_back({{mesh.tets[e][0], direction.normalized(), 1}, "parallel", mesh.region[e]});
    }
    return all;
  }
  for (int region : {static_cast<int>(anterior), static_cast<int>(posterior)})
    for (const GuidePoint& g : guide_points(mesh, region, options)) all.push_back(g);
  return all;
}

std::vector<RuleDeviation> deviation_from_rules(const LeafletMesh& mesh, const std::vector<GuidePoint>& guides) {
  // Tensor of the field around every node and leaflet: sum of volume f f^T, and the mean normal.
  std::map<int, std::vector<Mat3>> tensor;
  std::map<int, std::vector<Vec3>> normal;
  std::set<int> regions;
  for (const GuidePoint& g : guides) regions.insert(g.region);
  for (int r : regions) {
    tensor[r].assign(mesh.points.size(), Mat3::Zero());
    normal[r].assign(mesh.points.size(), Vec3::Zero());
  }
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    if (!regions.count(mesh.region[e])) continue;
    const auto& t = mesh.tets[e];
    const Vec3& x0 = mesh.points[at(t[0])];
    const double volume = std::abs((mesh.points[at(t[1])] - x0).cross(mesh.points[at(t[2])] - x0).dot(mesh.points[at(t[3])] - x0)) / 6;
    for (std::size_t k = 0; k < 4; ++k) {
      tensor[mesh.region[e]][at(t[k])] += volume * mesh.fibre[e] * mesh.fibre[e].transpose();
      normal[mesh.region[e]][at(t[k])] += volume * mesh.sheet_normal[e];
    }
  }
  std::vector<RuleDeviation> rows;
  for (const GuidePoint& g : guides) {
    const Vec3 n = normal[g.region][at(g.given.node)].normalized();
    const Vec3 a = (g.given.direction - n * n.dot(g.given.direction)).normalized(), b = n.cross(a);
    const Mat3& f = tensor[g.region][at(g.given.node)];
    // Nematic angle from the rule's direction a.
    const double angle = 0.5 * std::atan2(2 * a.dot(f * b), a.dot(f * a) - b.dot(f * b));
    auto row = std::find_if(rows.begin(), rows.end(), [&](const RuleDeviation& r) { return r.rule == g.rule && r.region == g.region; });
    if (row == rows.end()) row = rows.insert(rows.end(), {g.rule, g.region, 0, 0, 0});
    const double degrees = std::abs(angle) * 180 / std::numbers::pi;
    ++row->points;
    row->mean_deg += degrees;
    row->max_deg = std::max(row->max_deg, degrees);
  }
  for (RuleDeviation& r : rows) r.mean_deg /= r.points;
  return rows;
}

double mean_angle_to_annulus(const LeafletMesh& mesh, const Annulus& annulus, int region) {
  double sum = 0;
  long count = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    if (mesh.region[e] == region) {
      sum += std::asin(std::min(1.0, std::abs(mesh.fibre[e].dot(annulus.normal)))) * 180 / std::numbers::pi;
      ++count;
    }
  return count > 0 ? sum / static_cast<double>(count) : 0.0;
}

}  // namespace mv
