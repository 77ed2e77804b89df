// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/leaflet_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "geometry/core/errors.h"
#include "geometry/generic/pattern_mesh.h"
#include "geometry/unfold/leaflet_roles.h"
#include "geometry/unfold/smooth_leaflets.h"
#include "geometry/unfold/strip_map.h"
#include "geometry/unfold/surface_distance.h"
#include "geometry/unfold/thickness_limit.h"

namespace mv {
namespace {

/// A leaflet border further than this from the annulus curve, over more than this share of it, is torn off.
constexpr double torn_distance = 4, torn_share = 0.08;  // mm, of the perimeter
/// Natural notches of the free edge: minima by this share of the largest height.
constexpr double annulus_step = 0.75;  // mm by which smoothing may move it without a word
constexpr double notch_prominence = 0.1;
constexpr int outline_bins = 360;
constexpr double outline_smoothing = 2.5;  // mm, along u
constexpr double sample_edge = 0.6;        // mm, distance of samples
constexpr double commissure_off_annulus = 12;  // mm, of a given commissure

std::size_t at(long i) { return static_cast<std::size_t>(i); }
double wrapped(double u, double period) { return u - period * std::floor(u / period); }
double nearest(double u, double to, double period) { return u - period * std::round((u - to) / period); }

void check(const RawLeaflets& raw, const LeafletSurfaceOptions& o) {
  if (!(o.spacing > 0) || !(o.thickness > 0)) throw ConfigError("mesh.spacing and mesh.thickness must be positive");
  if (!(o.thickness_min > 0) || o.thickness_max < o.thickness_min)
    throw ConfigError("patient.thickness_min must be positive and not above patient.thickness_max");
  if (!(o.smoothing >= 0)) throw ConfigError("patient.smoothing must not be negative");
  if (!raw.commissures.empty() && raw.commissures.size() != 2)
    throw InputError(fmt::format("leaflets: {} commissures; expected two or none", raw.commissures.size()));
  if (!raw.annulus_seen.empty() && (raw.annulus_seen.size() != raw.annulus_curve.size() || std::count(raw.annulus_seen.begin(), raw.annulus_seen.end(), 0) == std::ssize(raw.annulus_seen)))
    throw InputError(fmt::format("leaflets: {} marks of what was seen for {} points of the annulus; expected one each, and one seen", raw.annulus_seen.size(), raw.annulus_curve.size()));
  if (!raw.papillary_names.empty() && raw.papillary_names.size() != raw.papillary_points.size())
    throw InputError(fmt::format("leaflets: {} papillary names for {} points", raw.papillary_names.size(), raw.papillary_points.size()));
  for (const auto* list : {&raw.annulus_curve, &raw.commissures, &raw.papillary_points})
    for (const Vec3& p : *list)
      if (!p.allFinite()) throw InputError("leaflets: a point of annulus, commissures or papillary muscles is not finite");
  for (const auto& hint : {raw.anterior_hint, raw.ventricle_direction})
    if (hint && !hint->allFinite()) throw InputError("leaflets: the anterior point or the direction to the ventricle is not finite");
}

/// Border further off the given curve than can be bridged.
void check_attachment(const Ring& ring, const ClosedCurve& curve, std::vector<std::string>& notes) {
  const std::size_t n = ring.annulus.size();
  double run = 0, longest = 0, farthest = 0;
  Vec3 where = Vec3::Zero();
  for (std::size_t k = 0; k < 2 * n; ++k) {
    const Vec3 &x = ring.mesh.points[at(ring.annulus[k % n])], &next = ring.mesh.points[at(ring.annulus[(k + 1) % n])];
    const double d = (curve.at(curve.closest(x)) - x).norm();
    if (d > farthest) {
      farthest = d;
      where = x;
    }
    run = d > torn_distance ? run + (next - x).norm() : 0;
    longest = std::max(longest, run);
  }
  longest = std::min(longest, curve.length());
  if (longest > torn_share * curve.length())
    throw InputError(fmt::format("leaflets: the leaflets are torn off the annulus over {:.0f} mm, by up to {:.1f} mm near ({:.1f}, {:.1f}, {:.1f}) mm; "
                                 "complete them in the source or correct the annulus curve",
                                 longest, farthest, where.x(), where.y(), where.z()));
  if (farthest > 1.5)
    notes.push_back(fmt::format("the leaflets' border lies up to {:.1f} mm off the annulus curve and was drawn to it", farthest));
}

/// The given curve; where it was bridged the leaflets' border is the better witness: it runs along it there, by the distance that curve and border have
/// at the ends of the stretch.
std::vector<Vec3> curve_with_border(const Ring& ring, const RawLeaflets& raw) {
  std::vector<Vec3> points = raw.annulus_curve, border_points;
  const std::vector<char>& seen = raw.annulus_seen;
  if (std::count(seen.begin(), seen.end(), 0) == 0) return points;
  for (int v : ring.annulus) border_points.push_back(ring.mesh.points[at(v)]);
  const ClosedCurve border(border_points);
  const auto foot = [&](std::size_t i) { return border.at(border.closest(raw.annulus_curve[i])); };
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (seen[i]) continue;
    std::size_t back = 1, forth = 1;
    while (!seen[(i + n - back) % n]) ++back;
    while (!seen[(i + forth) % n]) ++forth;
    const std::size_t a = (i + n - back) % n, b = (i + forth) % n;
    const double s = static_cast<double>(back) / static_cast<double>(back + forth);
    points[i] = foot(i) + (1 - s) * (raw.annulus_curve[a] - foot(a)) + s * (raw.annulus_curve[b] - foot(b));
  }
  return points;
}

struct AnnulusFound {
  Annulus annulus;
  std::string normal_rule;
  double moved_rms = 0, moved_max = 0;
};

AnnulusFound find_annulus(const Ring& ring, const RawLeaflets& raw, const LeafletSurfaceOptions& options, std::vector<std::string>& notes) {
  std::vector<Vec3> points = curve_with_border(ring, raw);
  if (points.empty())
    for (int v : ring.annulus) points.push_back(ring.mesh.points[at(v)]);
  CurveReport report;
  std::vector<Vec3> curve = clean_closed_curve(points, &report);
  if (report.spikes_removed > 0) notes.push_back(fmt::format("{} spikes of the annulus were removed", report.spikes_removed));
  if (options.annulus_harmonics > 0) curve = smooth_closed_curve(curve, options.annulus_harmonics, 720, &report);
  const Annulus plane = fit_annulus_plane(curve);
  Vec3 hang = Vec3::Zero();
  for (int v : ring.free_edge) hang += (ring.mesh.points[at(v)] - plane.origin) / static_cast<double>(ring.free_edge.size());
  NormalHints hints;
  AnnulusFound found;
  hints.ventricle_direction = raw.ventricle_direction;
  hints.papillary_points = raw.papillary_points;
  const bool by_leaflets = !raw.ventricle_direction && raw.papillary_points.empty();
  if (by_leaflets) hints.ventricle_direction = hang;
  found.annulus = fit_annulus(curve, hints);
  if (by_leaflets) found.annulus.sign_rule = fmt::format("the free edge hangs {:.1f} mm on this side", hang.dot(found.annulus.normal));
  found.normal_rule = found.annulus.sign_rule;
  if (hang.dot(found.annulus.normal) < -1)
    notes.push_back(fmt::format("the free edge lies {:.1f} mm on the atrial side of the annulus, by the rule '{}': prolapse, or the wrong side",
                                -hang.dot(found.annulus.normal), found.normal_rule));
  if (report.smoothing_max > annulus_step)
    notes.push_back(fmt::format("the annulus has a step or corner near ({:.1f}, {:.1f}, {:.1f}) mm, which smoothing moved by {:.1f} mm: is a piece of a leaflet missing there? "
                                "patient.annulus_harmonics = 0 keeps the border as it is, patient.annulus replaces it",
                                report.smoothing_max_at.x(), report.smoothing_max_at.y(), report.smoothing_max_at.z(), report.smoothing_max));
  found.moved_rms = report.smoothing_rms;
  found.moved_max = report.smoothing_max;
  return found;
}

/// Turns ring and curve so that both run counter-clockwise seen from the atrium.
void turn(Ring& ring, Annulus& annulus) {
  const auto twice_area = [&](std::size_t n, auto&& point) {
    double area = 0;
    for (std::size_t i = 0; i < n; ++i)
      area -= annulus.normal.dot((point(i) - annulus.origin).cross(point((i + 1) % n) - annulus.origin));
    return area;
  };
  if (twice_area(annulus.points.size(), [&](std::size_t i) { return annulus.points[i]; }) < 0)
    std::reverse(annulus.points.begin(), annulus.points.end());
  if (twice_area(ring.annulus.size(), [&](std::size_t i) { return ring.mesh.points[at(ring.annulus[i])]; }) < 0) {
    for (auto& t : ring.mesh.triangles) std::swap(t[1], t[2]);
    std::reverse(ring.annulus.begin(), ring.annulus.end());
    std::reverse(ring.free_edge.begin(), ring.free_edge.end());
  }
}

/// u of the border points on the annulus: arc length of the border, plus the smooth part of what the nearest point of the curve says.
std::vector<double> u_on_annulus(const Ring& ring, const ClosedCurve& curve) {
  const double period = curve.length(), length = loop_length(ring.mesh, ring.annulus);
  const std::size_t n = ring.annulus.size();
  std::vector<double> s(n), shift(n);
  double arc = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& x = ring.mesh.points[at(ring.annulus[i])];
    s[i] = period * arc / length;
    shift[i] = curve.closest(x) - s[i];
    shift[i] = i == 0 ? shift[i] : nearest(shift[i], shift[i - 1], period);
    arc += (ring.mesh.points[at(ring.annulus[(i + 1) % n])] - x).norm();
  }
  const double turns = std::round((shift[0] - nearest(shift[0], shift.back(), period)) / period);
  if (turns != 0) throw InputError("leaflets: the annulus curve and the leaflets' border do not run round each other once");
  // Low-pass of the shift over the arc, six harmonics.
  constexpr int modes = 6;
  std::vector<double> u(n);
  std::array<double, modes + 1> a{}, b{};
  for (std::size_t i = 0; i < n; ++i) {
    const double ds = 0.5 * ((i + 1 < n ? s[i + 1] : period + s[0]) - (i > 0 ? s[i - 1] : s[n - 1] - period)) / period;
    for (int k = 0; k <= modes; ++k) {
      const double angle = 2 * std::numbers::pi * k * s[i] / period;
      a[at(k)] += (k ? 2 : 1) * ds * shift[i] * std::cos(angle);
      b[at(k)] += 2 * ds * shift[i] * std::sin(angle);
    }
  }
  bool grows = true;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] = s[i];
    for (int k = 0; k <= modes; ++k) {
      const double angle = 2 * std::numbers::pi * k * s[i] / period;
      u[i] += a[at(k)] * std::cos(angle) + b[at(k)] * std::sin(angle);
    }
    grows = grows && (i == 0 || u[i] > u[i - 1]);
  }
  if (!grows || !(u[0] + period > u.back()))
    for (std::size_t i = 0; i < n; ++i) u[i] = s[i] + a[0];
  return u;
}

/// Mean of scattered values at equal steps of u, empty bins bridged, smoothed by a Gaussian.
std::vector<double> binned(const std::vector<std::pair<double, double>>& values, double period, int bins, double width) {
  const double step = period / bins;
  std::vector<double> sum(at(bins), 0), weight(at(bins), 0), out(at(bins), 0);
  for (const auto& [u, x] : values) {
    const auto i = at(std::min(static_cast<long>(wrapped(u, period) / step), static_cast<long>(bins) - 1));
    sum[i] += x;
    weight[i] += 1;
  }
  for (long i = 0; i < bins; ++i) {
    double s = 0, w = 0;
    for (long reach = std::lround(3 * width / step) + 1; w == 0; reach *= 2) {
      reach = std::min(reach, static_cast<long>(bins) / 2);
      for (long k = -reach; k <= reach; ++k) {
        const auto j = at(((i + k) % bins + bins) % bins);
        const double g = std::exp(-0.5 * std::pow(static_cast<double>(k) * step / std::max(width, step), 2)) + 1e-12;
        if (weight[j] == 0) continue;
        s += g * sum[j] / weight[j];
        w += g;
      }
    }
    out[at(i)] = s / w;
  }
  return out;
}

struct Frame {
  Vec3 origin, e1, e2;
  explicit Frame(const Annulus& a) : origin(a.origin), e1(a.axis_major), e2(a.normal.cross(a.axis_major)) {}
  Vec2 direction(const Vec3& d) const { return Vec2(d.dot(e1), d.dot(e2)).normalized(); }
};

Outline outline_of(const Ring& ring, const ClosedCurve& curve, const Frame& frame, const std::vector<double>& u, const std::vector<double>& t,
                   const std::vector<double>& distance) {
  Outline o;
  o.period = curve.length();
  std::vector<std::pair<double, double>> heights;
  for (int v : ring.free_edge) heights.emplace_back(u[at(v)], distance[at(v)]);
  o.height = binned(heights, o.period, outline_bins, outline_smoothing);
  for (int i = 0; i < outline_bins; ++i) o.direction.push_back(frame.direction(curve.at(o.period * (i + 0.5) / outline_bins) - frame.origin));
  for (auto* list : {&o.label_all, &o.label_annulus, &o.label_free_edge}) list->assign(outline_bins, 0);
  for (std::size_t k = 0; k < ring.mesh.triangles.size(); ++k) {
    if (ring.mesh.region[k] == 0) continue;
    const auto& tri = ring.mesh.triangles[k];
    double centre = 0, depth = 0;
    for (int v : tri) {
      centre += nearest(u[at(v)], u[at(tri[0])], o.period) / 3;
      depth += t[at(v)] / 3;
    }
    const auto bin = at(std::min(static_cast<long>(wrapped(centre, o.period) / o.period * outline_bins), static_cast<long>(outline_bins) - 1));
    const double area = ring.mesh.area(k), signed_area = ring.mesh.region[k] == anterior ? area : -area;
    o.labelled_area += area;
    o.label_all[bin] += signed_area;
    if (depth < 0.3) o.label_annulus[bin] += signed_area;
    if (depth > 0.7) o.label_free_edge[bin] += signed_area;
  }
  return o;
}

AnteriorEvidence evidence_of(const RawLeaflets& raw, const Annulus& annulus, const Frame& frame, std::vector<std::string>& notes) {
  AnteriorEvidence e;
  if (raw.anterior_hint) {
    const Vec3 d = *raw.anterior_hint - annulus.origin, flat = d - d.dot(annulus.normal) * annulus.normal;
    if (flat.norm() > 2)
      e.hint = frame.direction(flat);
    else
      notes.push_back("the anterior point lies on the annulus' axis and tells nothing");
  }
  if (raw.papillary_points.size() >= 2) {
    try {
      const AnteriorDirection found = find_anterior_direction(annulus, raw.papillary_points);
      if (found.confidence >= 1) {
        e.papillary = frame.direction(found.direction);
        e.papillary_rule = found.rule;
      }
    } catch (const InputError& error) {
      notes.push_back(error.what());
    }
  }
  return e;
}

/// u of the free edge's points (in the order of ring.free_edge): arc length between commissures and notches, which keep their natural place.
std::vector<double> u_on_free_edge(const Ring& ring, const std::vector<double>& natural, const Outline& outline, const Commissures& c) {
  const double period = outline.period;
  const std::vector<int> order(ring.free_edge.rbegin(), ring.free_edge.rend());  // growing u
  const std::size_t n = order.size();
  std::vector<double> arc{0}, u{natural[at(order[0])]};
  for (std::size_t i = 1; i <= n; ++i) {
    arc.push_back(arc.back() + (ring.mesh.points[at(order[i % n])] - ring.mesh.points[at(order[i - 1])]).norm());
    const double next = i < n ? natural[at(order[i])] : u[0] + period;
    u.push_back(std::max(u.back(), i < n ? nearest(next, u.back(), period) : next));
  }
  for (std::size_t i = n; i-- > 0;) u[i] = std::min(u[i], u[i + 1]);
  struct Control {
    double arc, target;
  };
  const auto control = [&](double natural_u, double target) {
    const double x = natural_u - period * std::floor((natural_u - u[0]) / period);
    std::size_t k = 0;
    while (k + 1 < n && u[k + 1] < x) ++k;
    const double share = u[k + 1] > u[k] ? std::clamp((x - u[k]) / (u[k + 1] - u[k]), 0.0, 1.0) : 0;
    return Control{arc[k] + share * (arc[k + 1] - arc[k]), nearest(target, x, period)};
  };
  std::vector<Control> fixed{control(c.free_edge_begin, c.annulus_begin), control(c.free_edge_end, c.annulus_end)};
  const double highest = *std::max_element(outline.height.begin(), outline.height.end());
  for (int i : periodic_minima(outline.height, notch_prominence * highest)) {
    const double at_u = (i + 0.5) * period / outline_bins;
    const auto far = [&](double x) { return std::abs(nearest(at_u, x, period) - x) > 0.05 * period; };
    if (far(c.free_edge_begin) && far(c.free_edge_end) && far(c.annulus_begin) && far(c.annulus_end)) fixed.push_back(control(at_u, at_u));
  }
  std::stable_sort(fixed.begin(), fixed.end(), [](const Control& a, const Control& b) { return a.arc < b.arc; });
  const double length = arc.back();
  std::vector<double> result(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t k = 0;
    while (k < fixed.size() && fixed[k].arc <= arc[i]) ++k;
    Control a = k > 0 ? fixed[k - 1] : Control{fixed.back().arc - length, fixed.back().target - period};
    Control b = k < fixed.size() ? fixed[k] : Control{fixed.front().arc + length, fixed.front().target + period};
    if (!(b.target > a.target))
      throw InputError("leaflets: commissures and notches of the free edge do not follow those of the annulus; give the commissures");
    const double share = b.arc > a.arc ? (arc[i] - a.arc) / (b.arc - a.arc) : 0;
    // Back to the image of u in which the strip's map sees this point.
    const double image = period * std::round((natural[at(order[i])] - u[i]) / period);
    result[n - 1 - i] = a.target + share * (b.target - a.target) + image;
  }
  return result;
}

std::vector<StripSample> samples_of(const Ring& ring, const std::vector<double>& u, const std::vector<double>& t, double period,
                                    double uniform_thickness) {
  std::vector<StripSample> samples;
  for (std::size_t k = 0; k < ring.mesh.triangles.size(); ++k) {
    if (!(ring.mesh.weight[k] > 0)) continue;
    const auto& tri = ring.mesh.triangles[k];
    std::array<StripSample, 3> corner;
    double longest = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t v = at(tri[c]);
      corner[c].u = nearest(u[v], u[at(tri[0])], period);
      corner[c].t = t[v];
      corner[c].value << ring.mesh.points[v], ring.mesh.thickness.empty() ? uniform_thickness : ring.mesh.thickness[v];
      longest = std::max(longest, (ring.mesh.points[v] - ring.mesh.points[at(tri[(c + 1) % 3])]).norm());
    }
    const int n = std::max(1, static_cast<int>(std::ceil(longest / sample_edge)));
    const double weight = ring.mesh.weight[k] * ring.mesh.area(k) / (n * n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2 * (n - i) - 1; ++j) {  // centres of the n^2 equal parts
        const double x = (i + (j % 2 ? 2.0 : 1.0) / 3) / n, y = (j / 2 + (j % 2 ? 2.0 : 1.0) / 3) / n, z = 1 - x - y;
        samples.push_back({z * corner[0].u + x * corner[1].u + y * corner[2].u, z * corner[0].t + x * corner[1].t + y * corner[2].t,
                           z * corner[0].value + x * corner[1].value + y * corner[2].value, weight});
      }
  }
  return samples;
}

/// Thickness that the mesh has to expect on its faces: measured or uniform, less where the surface bends.
class ThicknessTable {
 public:
  ThicknessTable(const SmoothLeaflets& smooth, bool is_uniform, const LeafletSurfaceOptions& options)
      : is_uniform_(is_uniform), options_(options), period_(smooth.period()) {
    for (int i = 0; i < columns; ++i)
      for (int j = 0; j <= rows; ++j) {
        const double u = period_ * i / columns;
        const Vec2 uv(u, smooth.height(u) * j / rows);
        const double kappa = smooth.curvature(uv), wanted = measured(smooth, uv);
        value_.push_back(kappa > 0 ? std::min(wanted, std::max(2 * fold_share / kappa, std::min(wanted, options.thickness_min))) : wanted);
      }
  }
  double measured(const SmoothLeaflets& smooth, const Vec2& uv) const {
    return is_uniform_ ? options_.thickness : std::clamp(smooth.thickness(uv), options_.thickness_min, options_.thickness_max);
  }
  double at(const SmoothLeaflets& smooth, const Vec2& uv) const {
    const double x = wrapped(uv.x(), period_) / period_ * columns, y = std::clamp(uv.y() / smooth.height(uv.x()), 0.0, 1.0) * rows;
    const int i = std::min(static_cast<int>(x), columns - 1), j = std::min(static_cast<int>(y), rows - 1);
    const auto value = [&](int a, int b) { return value_[mv::at((a % columns) * (rows + 1) + b)]; };
    const double p = x - i, q = y - j;
    return (1 - p) * ((1 - q) * value(i, j) + q * value(i, j + 1)) + p * ((1 - q) * value(i + 1, j) + q * value(i + 1, j + 1));
  }

 private:
  static constexpr int columns = 240, rows = 32;
  bool is_uniform_;
  LeafletSurfaceOptions options_;
  double period_;
  std::vector<double> value_;
};

Papillary papillary_of(const RawLeaflets& raw, const Annulus& annulus, const Vec3& ahead, std::vector<std::string>& notes) {
  if (raw.papillary_points.size() < 2) {
    if (!raw.papillary_points.empty()) notes.push_back("one papillary point only: it is not used");
    return {};
  }
  Papillary tips;
  for (const char* name : {"anterolateral", "posteromedial"}) {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (std::size_t i = 0; i < raw.papillary_names.size(); ++i)
      if (raw.papillary_names[i] == name) {
        sum += raw.papillary_points[i];
        ++count;
      }
    if (count > 0) {
      tips.tips.push_back(sum / count);
      tips.names.emplace_back(name);
    }
  }
  if (tips.tips.size() < 2) return group_papillary_points(raw.papillary_points, annulus, ahead);
  if ((tips.tips[0] - tips.tips[1]).dot(ahead.cross(annulus.normal)) < 0)
    notes.push_back("the papillary muscles' names contradict the anterior direction (seen from the atrium with the anterior leaflet up, the anterolateral "
                    "one lies on the left)");
  return tips;
}

void measure(const Ring& ring, const RawMesh& raw_mesh, const LeafletSurface& result, LeafletSurfaceReport& r) {
  const MidSurface& s = result.surface;
  std::array<double, 3> area{};
  std::set<std::pair<int, int>> border;  // directed edges between free-edge points that no second triangle runs back
  for (std::size_t k = 0; k < s.triangles.size(); ++k) {
    const auto& t = s.triangles[k];
    const double a = 0.5 * (s.points[at(t[1])] - s.points[at(t[0])]).cross(s.points[at(t[2])] - s.points[at(t[0])]).norm();
    area[at(s.region[k])] += a;
    const std::array<Vec2, 3> p = unfolded_triangle(s, static_cast<int>(k));
    const Vec2 d = p[1] - p[0], e = p[2] - p[0];
    const double flat = 0.5 * std::abs(d.x() * e.y() - d.y() * e.x());
    r.area_distortion_max = std::max({r.area_distortion_max, flat / a, a / flat});
    for (std::size_t c = 0; c < 3; ++c) {
      const int from = t[c], to = t[(c + 1) % 3];
      if (s.on_free_edge[at(from)] && s.on_free_edge[at(to)] && !border.erase({to, from})) border.insert({from, to});
    }
  }
  for (const auto& [from, to] : border) r.free_edge_length += (s.points[at(to)] - s.points[at(from)]).norm();
  r.area_anterior = area[anterior];
  r.area_posterior = area[posterior];
  // Measured points only: what was made up has no raw surface.
  std::vector<char> measured(ring.mesh.points.size(), 0);
  for (std::size_t k = 0; k < ring.mesh.triangles.size(); ++k)
    if (ring.mesh.weight[k] == 1)
      for (int v : ring.mesh.triangles[k]) measured[at(v)] = 1;
  std::vector<Vec3> from;
  for (std::size_t v = 0; v < measured.size(); ++v)
    if (measured[v]) from.push_back(ring.mesh.points[v]);
  double sum = 0, forth_max = 0, back = 0;
  const auto forth = distances_to_surface(from, s.points, s.triangles), towards = distances_to_surface(s.points, raw_mesh.points, raw_mesh.triangles);
  for (double d : forth) {
    sum += d / static_cast<double>(forth.size());
    forth_max = std::max(forth_max, d);
  }
  for (double d : towards) {
    back += d / static_cast<double>(towards.size());
    r.surface_moved_max = std::max(r.surface_moved_max, d);
  }
  r.surface_moved_mean = 0.5 * (sum + back);
  r.surface_moved_max = std::max(r.surface_moved_max, forth_max);
}

}  // namespace

LeafletSurface build_leaflet_surface(const RawLeaflets& raw, const LeafletSurfaceOptions& options) {
  check(raw, options);
  LeafletSurface result;
  LeafletSurfaceReport& report = result.report;
  report.notes = raw.notes;
  const RawMesh clean = clean_mesh(raw, report.notes);
  Ring ring = make_ring(clean, raw, options, report.notes);
  report.annulus_rule = ring.annulus_rule;

  const AnnulusFound found = find_annulus(ring, raw, options, report.notes);
  result.annulus = found.annulus;
  report.normal_rule = found.normal_rule;
  report.annulus_moved_rms = found.moved_rms;
  report.annulus_moved_max = found.moved_max;
  turn(ring, result.annulus);
  const ClosedCurve first_curve(result.annulus.points);
  if (!raw.annulus_curve.empty()) check_attachment(ring, first_curve, report.notes);

  // First the natural pattern, in which commissures and notches are found; then the one in which the free edge is matched to the annulus.
  const double period = first_curve.length();
  const StripMap strip(ring, period);
  const std::vector<double> u_annulus = u_on_annulus(ring, first_curve);
  const std::vector<double> natural = strip.along(u_annulus, {}), t = strip.across();
  const Frame frame(result.annulus);
  const Outline outline = outline_of(ring, first_curve, frame, natural, t, edge_distances(ring.mesh, ring.annulus));
  std::vector<double> given;
  for (const Vec3& p : raw.commissures) {
    given.push_back(first_curve.closest(p));
    const double off = (first_curve.at(given.back()) - p).norm();
    if (off > commissure_off_annulus)
      throw InputError(fmt::format("leaflets: the given commissure (patient.commissures) at ({:.1f}, {:.1f}, {:.1f}) mm lies {:.1f} mm off the annulus; expected at most {:.0f} mm",
                                   p.x(), p.y(), p.z(), off, commissure_off_annulus));
  }
  const Commissures commissures = find_commissures(outline, given, ring.has_regions, ring.has_names,
                                                   evidence_of(raw, result.annulus, frame, report.notes), report.notes);
  report.region_rule = commissures.rule;
  const std::vector<double> u = strip.along(u_annulus, u_on_free_edge(ring, natural, outline, commissures));
  if (const long folds = strip.folds(u, t); folds > 0)
    throw GateError(fmt::format("leaflets: the flat pattern has {} folds; the surface has triangles too flat to unfold, remesh it first", folds));

  // The anterior leaflet starts at u = 0.
  const ClosedCurve curve(first_curve.resampled(static_cast<int>(result.annulus.points.size()), commissures.annulus_begin));
  result.annulus.points = curve.resampled(static_cast<int>(result.annulus.points.size()));
  const double stretch = curve.length() / period;
  std::vector<double> shifted(u);
  for (double& x : shifted) x = (x - commissures.annulus_begin) * stretch;
  std::vector<std::pair<double, double>> heights;
  const std::vector<double> distance = edge_distances(ring.mesh, ring.annulus);
  for (int v : ring.free_edge) heights.emplace_back(shifted[at(v)], distance[at(v)]);
  const PeriodicTable first_height(curve.length(), binned(heights, curve.length(), outline_bins, outline_smoothing));
  const double cell = std::clamp(0.5 * options.smoothing, 0.8, 2.5);
  const SmoothLeaflets smooth(curve, samples_of(ring, shifted, t, curve.length(), options.thickness), first_height, options.smoothing, cell);

  PatternSurface pattern;
  pattern.perimeter = curve.length();
  pattern.anterior_end = wrapped((commissures.annulus_end - commissures.annulus_begin) * stretch, curve.length());
  pattern.height = [&](double x) { return smooth.height(x); };
  pattern.free_edge = [&](double step) { return smooth.free_edge(step); };
  pattern.normal = [&](const Vec2& p) { return smooth.normal(p); };
  const ThicknessTable thickness(smooth, raw.thickness.empty(), options);
  pattern.map = {[&](const Vec2& p) { return smooth.position(p); }, [&](const Vec2& p) { return smooth.along_u(p); },
                 [&](const Vec2& p) { return smooth.along_v(p); }, 0.5 * options.thickness,
                 [&](const Vec2& p) { return 0.5 * thickness.at(smooth, p); }};
  SurfaceMeshReport mesh;
  result.surface = mesh_pattern(pattern, options.spacing, &mesh);
  result.surface.axis = result.annulus.normal;
  report.edge_min = mesh.edge_min;
  report.edge_mean = mesh.edge_mean;
  report.edge_max = mesh.edge_max;
  report.angle_min = mesh.angle_min;
  report.angle_max = mesh.angle_max;

  for (const Vec2& uv : result.surface.unfolded)
    result.surface.thickness.push_back(raw.thickness.empty() ? options.thickness : thickness.measured(smooth, uv));
  const std::vector<std::string> limited = limit_thickness(result.surface, std::min(options.thickness_min, options.thickness), options.layers, options.dihedral_min);
  report.notes.insert(report.notes.end(), limited.begin(), limited.end());
  if (raw.thickness.empty() && limited.empty()) result.surface.thickness.clear();

  const Vec3 middle = curve.at(0.5 * pattern.anterior_end) - result.annulus.origin;
  result.anterior_direction = (middle - middle.dot(result.annulus.normal) * result.annulus.normal).normalized();
  result.papillary = papillary_of(raw, result.annulus, result.anterior_direction, report.notes);
  measure(ring, ring.mesh, result, report);
  return result;
}

}  // namespace mv
