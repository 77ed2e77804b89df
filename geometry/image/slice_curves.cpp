// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/slice_curves.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/image/leaflet_groups.h"
#include "geometry/image/medial_path.h"
#include "geometry/loft/open_curve.h"

namespace mv {
namespace {

constexpr double fine_cells = 4;        // per pixel side
constexpr double grazing_share = 0.6;   // height over contact length, below which the slice only grazes the sheet
constexpr double shortest_curve = 2.5;  // mm
constexpr double parallel_angle = 1;    // degrees
constexpr double pixel_noise = 0.5;     // pixels, of a mask's middle line
constexpr double outer_share = 1.0 / 3; // of the slices, in which leaflets that meet can be an arch on either side

const char* name_of(SlicePart part) {
  return part == SlicePart::anterior ? "anterior leaflet" : part == SlicePart::posterior ? "posterior leaflet" : "leaflet";
}

/// A group of pixels on a square grid fine enough for distances and paths.
struct FineMask {
  const Slice* slice;
  double cell;   // mm
  double x0, y0; // pixel coordinates of cell (0, 0)'s centre
  MaskPaths paths;

  Vec2 to_cells(const Vec2& pixel) const {
    return {(pixel.x() - x0) * slice->step_x.norm() / cell, (pixel.y() - y0) * slice->step_y.norm() / cell};
  }
  Vec3 world(const Vec2& c) const { return slice->world(x0 + c.x() * cell / slice->step_x.norm(), y0 + c.y() * cell / slice->step_y.norm()); }
};

FineMask refine(const Slice& slice, const PixelMask& mask) {
  int low_x = slice.width, low_y = slice.height, high_x = 0, high_y = 0;
  for (int j = 0; j < slice.height; ++j)
    for (int i = 0; i < slice.width; ++i)
      if (mask[static_cast<std::size_t>(j * slice.width + i)])
        low_x = std::min(low_x, i), high_x = std::max(high_x, i), low_y = std::min(low_y, j), high_y = std::max(high_y, j);
  const double sx = slice.step_x.norm(), sy = slice.step_y.norm(), cell = std::min(sx, sy) / fine_cells;
  const double x0 = low_x - 0.5 + 0.5 * cell / sx, y0 = low_y - 0.5 + 0.5 * cell / sy;
  const int w = static_cast<int>(std::lround((high_x - low_x + 1) * sx / cell)), h = static_cast<int>(std::lround((high_y - low_y + 1) * sy / cell));
  std::vector<std::uint8_t> inside;
  for (int j = 0; j < h; ++j)
    for (int i = 0; i < w; ++i) {
      const int x = std::clamp(static_cast<int>(std::lround(x0 + i * cell / sx)), low_x, high_x), y = std::clamp(static_cast<int>(std::lround(y0 + j * cell / sy)), low_y, high_y);
      inside.push_back(mask[static_cast<std::size_t>(y * slice.width + x)]);
    }
  return {&slice, cell, x0, y0, MaskPaths(w, h, inside)};
}

struct Contact {
  Vec2 center;    // pixels
  double length;  // mm, largest distance of two of its pixels
  std::vector<int> pixels;
};

std::vector<Contact> contacts_of(const Slice& slice, const PixelMask& group, const PixelMask& contact) {
  PixelMask mine(group.size(), 0);
  for (std::size_t p = 0; p < group.size(); ++p) mine[p] = group[p] && contact[p];
  std::vector<Contact> contacts;
  const double sx = slice.step_x.norm(), sy = slice.step_y.norm();
  for (const auto& cluster : contact_clusters(slice, mine)) {
    if (!contacts.empty() && cluster.size() < 2) continue;
    Contact c{Vec2::Zero(), 0, cluster};
    for (const int p : cluster) c.center += Vec2(p % slice.width, p / slice.width) / static_cast<double>(cluster.size());
    for (const int p : cluster)
      for (const int q : cluster) c.length = std::max(c.length, std::hypot(sx * (p % slice.width - q % slice.width), sy * (p / slice.width - q / slice.width)));
    contacts.push_back(c);
  }
  return contacts;
}

int farthest(const MaskPaths& paths, const std::vector<double>& distance) {
  int best = -1;
  for (int c = 0; c < static_cast<int>(distance.size()); ++c) {
    if (!paths.is_inside(c) || !std::isfinite(distance[static_cast<std::size_t>(c)])) continue;
    if (best < 0 || distance[static_cast<std::size_t>(c)] > distance[static_cast<std::size_t>(best)]) best = c;
  }
  return best;
}

std::vector<Vec2> positions(const MaskPaths& paths, const std::vector<int>& cells) {
  std::vector<Vec2> result;
  for (const int c : cells) result.push_back(paths.position(c));
  return result;
}

std::vector<Vec2> reversed(std::vector<Vec2> path) {
  std::reverse(path.begin(), path.end());
  return path;
}

/// Points about one pixel apart: closer ones share the stair steps of the same pixels.
std::vector<Vec3> thinned(const FineMask& fine, const std::vector<Vec2>& path) {
  std::vector<Vec3> points = {fine.world(path.front())};
  const double step = fine.cell * fine_cells;
  for (std::size_t i = 1; i + 1 < path.size(); ++i) {
    const Vec3 x = fine.world(path[i]);
    if ((x - points.back()).norm() >= step && (x - fine.world(path.back())).norm() >= 0.5 * step) points.push_back(x);
  }
  points.push_back(fine.world(path.back()));
  return points;
}

/// Twice the depth under each point, averaged over 2 mm and scaled to the group's area.
std::vector<double> thickness_along(const FineMask& fine, const std::vector<Vec3>& points, double area) {
  std::vector<double> raw, s = {0};
  const Slice& slice = *fine.slice;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 d = points[i] - slice.origin;
    const Vec2 pixel(d.dot(slice.step_x) / slice.step_x.squaredNorm(), d.dot(slice.step_y) / slice.step_y.squaredNorm());
    const Vec2 c = fine.to_cells(pixel);
    // Off the middle the depth is less: the deepest cell within a pixel is meant.
    double depth = 0;
    const int reach = static_cast<int>(fine_cells) / 2 + 1;
    for (int dj = -reach; dj <= reach; ++dj)
      for (int di = -reach; di <= reach; ++di) {
        const int x = static_cast<int>(std::lround(c.x())) + di, y = static_cast<int>(std::lround(c.y())) + dj;
        if (x >= 0 && y >= 0 && x < fine.paths.width() && y < fine.paths.height()) depth = std::max(depth, fine.paths.depth(y * fine.paths.width() + x));
      }
    raw.push_back(std::max(1.0, 2 * depth - 1) * fine.cell);
    if (i > 0) s.push_back(s.back() + (points[i] - points[i - 1]).norm());
  }
  std::vector<double> smooth(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    double sum = 0, n = 0;
    for (std::size_t k = 0; k < raw.size(); ++k)
      if (std::abs(s[k] - s[i]) <= 1) sum += raw[k], ++n;
    smooth[i] = sum / n;
  }
  double under = 0;
  for (std::size_t i = 1; i < smooth.size(); ++i) under += 0.5 * (smooth[i] + smooth[i - 1]) * (s[i] - s[i - 1]);
  const double factor = under > 0 ? std::clamp(area / under, 0.7, 1.4) : 1;
  for (double& t : smooth) t *= factor;
  return smooth;
}

LeafletCurve make_curve(const FineMask& fine, const std::vector<Vec2>& path, double area, double pixel) {
  LeafletCurve curve;
  curve.points = smooth_open_curve(thinned(fine, path), pixel_noise * pixel, pixel);
  curve.thickness = thickness_along(fine, curve.points, area);
  return curve;
}

double area_of(const Slice& slice, const PixelMask& group) {
  return static_cast<double>(std::count(group.begin(), group.end(), 1)) * slice.step_x.cross(slice.step_y).norm();
}

double thickest(const MaskPaths& paths) {
  double depth = 0;
  for (int c = 0; c < paths.width() * paths.height(); ++c) depth = std::max(depth, paths.depth(c));
  return 2 * depth;
}

/// What one group of pixels gives: a curve, or a point on the annulus only.
void curve_of_group(const Slice& slice, const PixelMask& group, const PixelMask& contact, LeafletCurve curve, CurveSet& set, const SliceCurveOptions& options) {
  (void)options;
  const FineMask fine = refine(slice, group);
  const MaskPaths& paths = fine.paths;
  const std::vector<Contact> contacts = contacts_of(slice, group, contact);
  const double area = area_of(slice, group), pixel = std::max(slice.step_x.norm(), slice.step_y.norm());
  const auto take = [&](const std::vector<Vec2>& path, CurveEnd end, bool is_hinge_first) {
    const LeafletCurve made = make_curve(fine, path, area, pixel);
    curve.points = made.points;
    curve.thickness = made.thickness;
    curve.end = end;
    curve.is_hinge_first = is_hinge_first;
    set.curves.push_back(curve);
  };
  if (contacts.empty()) {
    const int a = farthest(paths, paths.distances({paths.nearest_inside(Vec2::Zero())}));
    const int b = farthest(paths, paths.distances({a}));
    const auto distance = paths.distances({a});
    if (distance[static_cast<std::size_t>(b)] * fine.cell < shortest_curve) {
      set.notes.push_back(curve.name + ": no longer than thick; left out");
      return;
    }
    auto path = paths.extended_end(positions(paths, paths.middle_path(a, b)));
    path = reversed(paths.extended_end(reversed(path)));
    take(path, CurveEnd::free_edge, false);
    return;
  }
  std::vector<int> starts, touching;
  for (const Contact& c : contacts) {
    starts.push_back(paths.nearest_inside(fine.to_cells(c.center)));
    for (const int p : c.pixels) touching.push_back(paths.nearest_inside(fine.to_cells(Vec2(p % slice.width, p / slice.width))));
  }
  const auto from_contact = paths.distances(touching);
  const int tip = farthest(paths, from_contact);
  const double height = from_contact[static_cast<std::size_t>(tip)] * fine.cell;
  if (contacts.size() > 1) {
    // Two hinges: an arch, unless the mask goes on far beyond the line between them.
    std::size_t other = 1;
    const auto from_first = paths.distances({starts[0]});
    for (std::size_t k = 1; k < starts.size(); ++k)
      if (from_first[static_cast<std::size_t>(starts[k])] > from_first[static_cast<std::size_t>(starts[other])]) other = k;
    const auto path = paths.middle_path(starts[0], starts[other]);
    const double span = from_first[static_cast<std::size_t>(starts[other])];
    const double beyond = path.empty() ? HUGE_VAL : paths.distances(path)[static_cast<std::size_t>(tip)];
    if (!path.empty() && span > 3 * thickest(paths) && beyond < thickest(paths)) {
      take(positions(paths, path), CurveEnd::annulus, true);
      return;
    }
  }
  const Contact& hinge = contacts.front();
  if (height < shortest_curve || height < grazing_share * hinge.length) {
    const Vec2 c = paths.position(paths.nearest_inside(fine.to_cells(hinge.center)));
    set.annulus_points.push_back(fine.world(c));
    return;
  }
  const auto path = paths.middle_path(starts.front(), tip);
  if (path.size() < 4) return;
  take(paths.extended_end(positions(paths, path)), CurveEnd::free_edge, true);
}

/// Whether the sheet goes on beyond the curve's end in the other leaflet's pixels.
bool runs_into(const Slice& slice, const LeafletCurve& curve, SlicePart other, double reach) {
  const std::size_t n = curve.points.size();
  if (n < 4) return false;
  const std::size_t back = std::min<std::size_t>(n - 1, 4);
  const Vec3 direction = (curve.points[n - 1] - curve.points[n - 1 - back]).normalized();
  const double pixel = slice.step_x.norm();
  for (double s = 0.5 * pixel; s <= reach + pixel; s += 0.5 * pixel) {
    const Vec3 d = curve.points.back() + s * direction - slice.origin;
    const long i = std::lround(d.dot(slice.step_x) / slice.step_x.squaredNorm()), j = std::lround(d.dot(slice.step_y) / slice.step_y.squaredNorm());
    if (i < 0 || j < 0 || i >= slice.width || j >= slice.height) return false;
    if (slice.at(static_cast<int>(i), static_cast<int>(j)) == other) return true;
  }
  return false;
}

void mark_joined(const Slice& slice, CurveSet& set, std::size_t first, const SliceCurveOptions& options) {
  for (std::size_t i = first; i < set.curves.size(); ++i)
    for (std::size_t j = first; j < set.curves.size(); ++j) {
      LeafletCurve &a = set.curves[i], &b = set.curves[j];
      if (a.region != posterior || b.region != anterior || a.end == CurveEnd::annulus || b.end == CurveEnd::annulus) continue;
      if (!a.is_hinge_first || !b.is_hinge_first) continue;
      const bool meet = runs_into(slice, a, SlicePart::anterior, options.join_gap) || runs_into(slice, b, SlicePart::posterior, options.join_gap);
      if (meet && (a.points.back() - b.points.back()).norm() < 2 * options.join_gap) a.end = b.end = CurveEnd::joined;
    }
  // One leaflet's end inside an arch that belongs to the other one's label.
  for (std::size_t i = first; i < set.curves.size(); ++i) {
    LeafletCurve& a = set.curves[i];
    if (a.end != CurveEnd::free_edge || a.region == 0) continue;
    const bool has_arch = std::any_of(set.curves.begin() + static_cast<std::ptrdiff_t>(first), set.curves.end(),
                                      [&](const LeafletCurve& b) { return b.end == CurveEnd::annulus && b.region != a.region; });
    if (has_arch && runs_into(slice, a, a.region == anterior ? SlicePart::posterior : SlicePart::anterior, options.join_gap)) a.end = CurveEnd::joined;
  }
}

/// Leaflets that meet are an arch only in an unbroken row of slices from the outermost one, up to a third of all; elsewhere they coapt.
void undo_coaptation(CurveSet& set, int slices) {
  std::vector<char> is_open(static_cast<std::size_t>(slices), 0), has_any = is_open;
  for (const auto& c : set.curves) {
    has_any[static_cast<std::size_t>(c.slice)] = 1;
    if (c.end == CurveEnd::free_edge) is_open[static_cast<std::size_t>(c.slice)] = 1;
  }
  const auto first = std::find(has_any.begin(), has_any.end(), 1) - has_any.begin();
  auto last = static_cast<std::ptrdiff_t>(slices) - 1;
  while (last > first && !has_any[static_cast<std::size_t>(last)]) --last;
  const double most = outer_share * static_cast<double>(last - first + 1);
  std::vector<char> may_join(static_cast<std::size_t>(slices), 0);
  std::ptrdiff_t low = first, high = last;
  while (low <= last && !is_open[static_cast<std::size_t>(low)]) ++low;
  while (high >= first && !is_open[static_cast<std::size_t>(high)]) --high;
  if (static_cast<double>(low - first) <= most)
    for (auto k = first; k < low; ++k) may_join[static_cast<std::size_t>(k)] = 1;
  if (static_cast<double>(last - high) <= most)
    for (auto k = high + 1; k <= last; ++k) may_join[static_cast<std::size_t>(k)] = 1;
  int undone = 0;
  for (auto& c : set.curves)
    if (c.end == CurveEnd::joined && !may_join[static_cast<std::size_t>(c.slice)]) c.end = CurveEnd::free_edge, ++undone;
  if (undone > 0) set.notes.push_back(fmt::format("the leaflets touch each other in {} slices that are not the outermost: taken as coaptation, their ends as free edge", (undone + 1) / 2));
}

/// Without names and walls: a single curve beyond the slices that show two is an arch.
void mark_nameless_arches(CurveSet& set, int slices) {
  std::vector<int> count(static_cast<std::size_t>(slices), 0);
  for (const auto& c : set.curves)
    if (c.region == 0 && !c.is_hinge_first) ++count[static_cast<std::size_t>(c.slice)];
  int low = 0, high = slices - 1;
  while (low < slices && count[static_cast<std::size_t>(low)] < 2) ++low;
  while (high >= 0 && count[static_cast<std::size_t>(high)] < 2) --high;
  for (auto& c : set.curves)
    if (c.region == 0 && !c.is_hinge_first && (c.slice < low || c.slice > high)) c.end = CurveEnd::annulus;
}

void sort_slices(std::vector<Slice>& slices, CurveSet& set) {
  const Vec3 n = slices.front().normal();
  const double limit = std::cos(parallel_angle * M_PI / 180);
  if (!std::all_of(slices.begin(), slices.end(), [&](const Slice& s) { return std::abs(s.normal().dot(n)) > limit; })) return;
  set.stack_normal = n;
  const auto depth = [&](const Slice& s) { return n.dot(s.world(0.5 * (s.width - 1), 0.5 * (s.height - 1))); };
  const auto is_before = [&](const Slice& a, const Slice& b) { return depth(a) < depth(b); };
  if (!std::is_sorted(slices.begin(), slices.end(), is_before) && !std::is_sorted(slices.rbegin(), slices.rend(), is_before))
    set.notes.push_back("the slices were not in the order of their positions; sorted");
  std::stable_sort(slices.begin(), slices.end(), is_before);
  for (std::size_t k = 1; k < slices.size(); ++k)
    if (depth(slices[k]) - depth(slices[k - 1]) < 0.01)
      throw InputError(fmt::format("{} and {} lie in the same place (within 0.01 mm); expected slices at different positions", slices[k - 1].name, slices[k].name));
}

void add_muscles(const std::vector<Slice>& slices, CurveSet& set) {
  for (const auto& [part, name] : {std::pair(SlicePart::papillary_anterolateral, "anterolateral"), std::pair(SlicePart::papillary_posteromedial, "posteromedial")}) {
    std::vector<Vec3> cloud;
    for (const Slice& s : slices)
      for (int j = 0; j < s.height; ++j)
        for (int i = 0; i < s.width; ++i)
          if (s.at(i, j) == part) cloud.push_back(s.world(i, j));
    if (cloud.empty()) continue;
    set.papillary_clouds.push_back(cloud);
    set.papillary_cloud_names.emplace_back(name);
  }
}

}  // namespace

CurveSet curves_of_slices(std::vector<Slice> slices, const SliceCurveOptions& options) {
  if (slices.empty()) throw InputError("no slices");
  CurveSet set;
  sort_slices(slices, set);
  add_muscles(slices, set);
  int with_leaflet = 0;
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const Slice& slice = slices[k];
    set.resolution += 0.5 * (slice.step_x.norm() + slice.step_y.norm()) / static_cast<double>(slices.size());
    const auto to_atrium = distance_to_mask(slice, mask_of(slice, SlicePart::atrium)), to_ventricle = distance_to_mask(slice, mask_of(slice, SlicePart::ventricle));
    const std::size_t first = set.curves.size(), first_point = set.annulus_points.size();
    bool is_empty = true;
    for (const SlicePart part : {SlicePart::posterior, SlicePart::anterior, SlicePart::leaflet}) {
      const PixelMask mask = mask_of(slice, part);
      if (std::none_of(mask.begin(), mask.end(), [](std::uint8_t x) { return x != 0; })) continue;
      is_empty = false;
      PixelMask atrial(mask.size()), any(mask.size());
      for (std::size_t p = 0; p < mask.size(); ++p) {
        atrial[p] = mask[p] && to_atrium[p] <= options.wall_reach;
        any[p] = atrial[p] || (mask[p] && to_ventricle[p] <= options.wall_reach);
      }
      LeafletCurve curve;
      curve.name = fmt::format("{}, {}", slice.name, name_of(part));
      curve.region = part == SlicePart::posterior ? posterior : part == SlicePart::anterior ? anterior : 0;
      curve.slice = static_cast<int>(k);
      curve.plane_normal = slice.normal();
      const auto groups = leaflet_groups(slice, mask, any, options, curve.name, set.notes);
      for (const PixelMask& group : groups) {
        bool touches_atrium = false;
        for (std::size_t p = 0; p < group.size(); ++p) touches_atrium = touches_atrium || (group[p] && atrial[p]);
        curve_of_group(slice, group, touches_atrium ? atrial : any, curve, set, options);
      }
      if (groups.size() > 1) set.notes.push_back(fmt::format("{}: the slice cuts it {} times", curve.name, groups.size()));
    }
    mark_joined(slice, set, first, options);
    if (set.curves.size() > first || set.annulus_points.size() > first_point) ++with_leaflet;
    if (is_empty) set.empty_slices.push_back(slice.world(0.5 * (slice.width - 1), 0.5 * (slice.height - 1)));
  }
  if (with_leaflet == 0)
    throw InputError(fmt::format("none of the {} slices shows a leaflet; check the labels (mask: any value but 0 is leaflet), and that the slices cut the valve", slices.size()));
  if (with_leaflet < 3)
    throw InputError(fmt::format("only {} of {} slices shows a leaflet; a surface needs at least 3, better 8 or more", with_leaflet, slices.size()));
  undo_coaptation(set, static_cast<int>(slices.size()));
  mark_nameless_arches(set, static_cast<int>(slices.size()));
  return set;
}

}  // namespace mv
