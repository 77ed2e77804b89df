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
constexpr double wedge_share = 2;       // contact length over thickness, above which the leaflet ends in a wedge along the wall
constexpr double parallel_angle = 1;    // degrees
constexpr double pixel_noise = 0.5;     // pixels, of a mask's middle line
constexpr double outer_share = 1.0 / 3; // of the slices, in which leaflets that meet can be an arch on either side

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

/// Leaflet of the pixel nearest to x within two pixels; 0 when it has no name.
int region_at(const Slice& slice, const Vec3& x) {
  const Vec3 d = x - slice.origin;
  const double i0 = d.dot(slice.step_x) / slice.step_x.squaredNorm(), j0 = d.dot(slice.step_y) / slice.step_y.squaredNorm();
  int region = 0;
  double nearest = HUGE_VAL;
  for (int j = static_cast<int>(std::lround(j0)) - 2; j <= std::lround(j0) + 2; ++j)
    for (int i = static_cast<int>(std::lround(i0)) - 2; i <= std::lround(i0) + 2; ++i) {
      if (i < 0 || j < 0 || i >= slice.width || j >= slice.height) continue;
      const SlicePart part = slice.at(i, j);
      const double distance = std::hypot(i - i0, j - j0);
      if ((part == SlicePart::posterior || part == SlicePart::anterior) && distance < nearest)
        nearest = distance, region = part == SlicePart::anterior ? anterior : posterior;
    }
  return region;
}

/// The leaflet is that of most points of the half at the hinge, where labels are surest.
void name_curve(const Slice& slice, LeafletCurve& curve) {
  curve.point_region.clear();
  int count[3] = {0, 0, 0};
  const std::size_t n = curve.points.size(), decisive = curve.is_hinge_first ? (n + 1) / 2 : n;
  for (std::size_t i = 0; i < n; ++i) {
    curve.point_region.push_back(region_at(slice, curve.points[i]));
    if (i < decisive) ++count[curve.point_region.back()];
  }
  curve.region = count[posterior] + count[anterior] == 0 ? 0 : count[anterior] > count[posterior] ? anterior : posterior;
  curve.name = fmt::format("{}, {}", slice.name, curve.region == 0 ? "leaflet" : curve.region == anterior ? "anterior leaflet" : "posterior leaflet");
}

/// What the curves of one slice are made from.
struct SliceWork {
  const Slice& slice;
  const SliceCurveOptions& options;
  PixelMask contact;  // leaflet pixels that touch a wall
  bool may_arch;      // an outer slice: leaflets that meet are one sheet
  int number;
  CurveSet& set;
};

void take(SliceWork& work, const FineMask& fine, const std::vector<Vec2>& path, double area, CurveEnd end, bool is_hinge_first) {
  LeafletCurve curve = make_curve(fine, path, area, std::max(work.slice.step_x.norm(), work.slice.step_y.norm()));
  curve.slice = work.number;
  curve.plane_normal = work.slice.normal();
  curve.end = end;
  curve.is_hinge_first = is_hinge_first;
  name_curve(work.slice, curve);
  work.set.curves.push_back(curve);
}

/// Where the leaflet ends at a wall: the middle of the contact, or, when the slice cuts a wedge that runs out along the wall, the cell of the contact that is
/// farthest from the tip.
int hinge_cell(const FineMask& fine, const SliceWork& work, const Contact& contact, int tip) {
  const MaskPaths& paths = fine.paths;
  const int middle = paths.nearest_inside(fine.to_cells(contact.center));
  std::vector<double> depths;
  for (const int c : paths.middle_path(middle, tip)) depths.push_back(paths.depth(c));
  if (depths.empty()) return middle;
  std::nth_element(depths.begin(), depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2), depths.end());
  if (contact.length < wedge_share * 2 * depths[depths.size() / 2] * fine.cell) return middle;
  const auto from_tip = paths.distances({tip});
  int best = middle;
  for (const int p : contact.pixels) {
    const int c = paths.nearest_inside(fine.to_cells(Vec2(p % work.slice.width, p / work.slice.width)));
    if (std::isfinite(from_tip[static_cast<std::size_t>(c)]) && from_tip[static_cast<std::size_t>(c)] > from_tip[static_cast<std::size_t>(best)]) best = c;
  }
  return best;
}

/// Path between the two hinges that lie farthest apart, when the mask does not go on beyond it; else empty.
std::vector<int> arch_of(const FineMask& fine, const std::vector<int>& starts, int tip) {
  const MaskPaths& paths = fine.paths;
  std::size_t a = 0, b = 1;
  double span = -1;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const auto distance = paths.distances({starts[i]});
    for (std::size_t k = i + 1; k < starts.size(); ++k)
      if (std::isfinite(distance[static_cast<std::size_t>(starts[k])]) && distance[static_cast<std::size_t>(starts[k])] > span)
        span = distance[static_cast<std::size_t>(starts[k])], a = i, b = k;
  }
  if (span < 3 * thickest(paths)) return {};
  const auto path = paths.middle_path(starts[a], starts[b]);
  if (path.empty() || paths.distances(path)[static_cast<std::size_t>(tip)] > thickest(paths)) return {};
  return path;
}

void curves_of_group(SliceWork& work, const PixelMask& group, bool may_split);

/// Leaflets that touch each other: each by its own label; without labels the path from hinge to hinge is cut in the middle.
void split_group(SliceWork& work, const PixelMask& group, const FineMask& fine, const std::vector<int>& arch) {
  const PixelMask front = mask_of(work.slice, SlicePart::anterior), back = mask_of(work.slice, SlicePart::posterior);
  PixelMask own[2] = {group, group};
  bool is_named = true;
  for (int k = 0; k < 2; ++k) {
    for (std::size_t p = 0; p < group.size(); ++p) own[k][p] = group[p] && (k == 0 ? back : front)[p];
    is_named = is_named && std::any_of(own[k].begin(), own[k].end(), [](std::uint8_t x) { return x != 0; });
  }
  if (is_named) {
    for (const PixelMask& mask : own)
      for (const PixelMask& piece : leaflet_groups(work.slice, mask, work.contact, work.options, work.slice.name, work.set.notes)) curves_of_group(work, piece, false);
  } else if (arch.size() > 8) {
    const auto path = positions(fine.paths, arch);
    const auto middle = static_cast<std::ptrdiff_t>(path.size() / 2);
    const double area = 0.5 * area_of(work.slice, group);
    take(work, fine, std::vector<Vec2>(path.begin(), path.begin() + middle), area, CurveEnd::free_edge, true);
    take(work, fine, reversed(std::vector<Vec2>(path.begin() + middle, path.end())), area, CurveEnd::free_edge, true);
  }
}

void curve_without_wall(SliceWork& work, const FineMask& fine, double area) {
  const MaskPaths& paths = fine.paths;
  const int a = farthest(paths, paths.distances({paths.nearest_inside(Vec2::Zero())}));
  const auto distance = paths.distances({a});
  const int b = farthest(paths, distance);
  if (distance[static_cast<std::size_t>(b)] * fine.cell < std::max(shortest_curve, 1.5 * thickest(paths) * fine.cell)) {
    work.set.notes.push_back(work.slice.name + ": a piece no longer than thick was left out");
    return;
  }
  const auto path = paths.extended_end(positions(paths, paths.middle_path(a, b)));
  take(work, fine, reversed(paths.extended_end(reversed(path))), area, CurveEnd::free_edge, false);
}

/// The slice cuts the sheet's outermost part only: the annulus enters and leaves at the ends of the contact.
void graze(SliceWork& work, const FineMask& fine, const Contact& contact) {
  const Slice& slice = work.slice;
  const auto pixel = [&](int p) { return Vec2(p % slice.width, p / slice.width); };
  const auto length = [&](int p, int q) { return (slice.world(pixel(p).x(), pixel(p).y()) - slice.world(pixel(q).x(), pixel(q).y())).norm(); };
  if (contact.length < shortest_curve) {
    work.set.annulus_points.push_back(fine.world(fine.to_cells(contact.center)));
    return;
  }
  int a = contact.pixels.front(), b = a;
  for (const int p : contact.pixels)
    for (const int q : contact.pixels)
      if (length(p, q) > length(a, b)) a = p, b = q;
  for (const int p : {a, b}) work.set.annulus_points.push_back(slice.world(pixel(p).x(), pixel(p).y()));
}

/// What one group of pixels gives: a curve, an arch, two coapting leaflets, or a point on the annulus only.
void curves_of_group(SliceWork& work, const PixelMask& group, bool may_split) {
  const FineMask fine = refine(work.slice, group);
  const MaskPaths& paths = fine.paths;
  const std::vector<Contact> contacts = contacts_of(work.slice, group, work.contact);
  const double area = area_of(work.slice, group);
  if (contacts.empty()) {
    if (may_split) curve_without_wall(work, fine, area);  // else: the other label's tip
    return;
  }
  std::vector<int> starts, touching;
  for (const Contact& c : contacts) {
    starts.push_back(paths.nearest_inside(fine.to_cells(c.center)));
    for (const int p : c.pixels) touching.push_back(paths.nearest_inside(fine.to_cells(Vec2(p % work.slice.width, p / work.slice.width))));
  }
  const auto from_contact = paths.distances(touching);
  const int tip = farthest(paths, from_contact);
  const double height = from_contact[static_cast<std::size_t>(tip)] * fine.cell;
  if (contacts.size() > 1 && may_split) {
    for (std::size_t k = 0; k < contacts.size(); ++k) starts[k] = hinge_cell(fine, work, contacts[k], tip);
    const auto arch = arch_of(fine, starts, tip);
    if (!arch.empty() && work.may_arch) return take(work, fine, positions(paths, arch), area, CurveEnd::annulus, true);
    const auto from_first = paths.distances({starts[0]});
    const int apart = *std::max_element(starts.begin(), starts.end(), [&](int x, int y) { return from_first[static_cast<std::size_t>(x)] < from_first[static_cast<std::size_t>(y)]; });
    if (!arch.empty() || from_first[static_cast<std::size_t>(apart)] > 3 * thickest(paths)) return split_group(work, group, fine, arch);
  }
  const Contact& hinge = contacts.front();
  if (height < shortest_curve || height < grazing_share * hinge.length) {
    graze(work, fine, hinge);
    return;
  }
  const int start = hinge_cell(fine, work, hinge, tip);
  const auto path = paths.middle_path(start, tip);
  if (path.size() < 4) return;
  auto points = paths.extended_end(positions(paths, path));
  if (start != paths.nearest_inside(fine.to_cells(hinge.center))) points = reversed(paths.extended_end(reversed(points)));
  take(work, fine, points, area, CurveEnd::free_edge, true);
}

/// Direction in which a curve leaves its end.
Vec3 end_direction(const LeafletCurve& curve) {
  const std::size_t n = curve.points.size(), back = std::min<std::size_t>(n - 1, 4);
  return (curve.points[n - 1] - curve.points[n - 1 - back]).normalized();
}

/// A broken arch: ends that point at each other across a short gap.
void mark_joined(CurveSet& set, std::size_t first, const SliceCurveOptions& options) {
  for (std::size_t i = first; i < set.curves.size(); ++i)
    for (std::size_t j = i + 1; j < set.curves.size(); ++j) {
      LeafletCurve &a = set.curves[i], &b = set.curves[j];
      if (a.end != CurveEnd::free_edge || b.end != CurveEnd::free_edge || !a.is_hinge_first || !b.is_hinge_first) continue;
      const Vec3 gap = b.points.back() - a.points.back();
      if (gap.norm() > options.join_gap + a.thickness.back()) continue;
      if (gap.norm() < 0.5 || (end_direction(a).dot(gap) > 0.5 * gap.norm() && end_direction(b).dot(-gap) > 0.5 * gap.norm())) a.end = b.end = CurveEnd::joined;
    }
}

/// Slices in which leaflets that meet can be an arch: an unbroken row from the outermost slice with a curve, up to a third of all that have one.
std::vector<char> outer_slices(const CurveSet& set, int slices) {
  std::vector<char> is_open(static_cast<std::size_t>(slices), 0), has_any = is_open, may(static_cast<std::size_t>(slices), 0);
  for (const auto& c : set.curves) {
    has_any[static_cast<std::size_t>(c.slice)] = 1;
    if (c.end == CurveEnd::free_edge) is_open[static_cast<std::size_t>(c.slice)] = 1;
  }
  const auto count = static_cast<double>(std::count(has_any.begin(), has_any.end(), 1));
  for (const bool upwards : {true, false}) {
    std::vector<std::size_t> row;
    for (int k = 0; k < slices; ++k) {
      const auto at = static_cast<std::size_t>(upwards ? k : slices - 1 - k);
      if (is_open[at]) break;
      row.push_back(at);
    }
    const auto arches = std::count_if(row.begin(), row.end(), [&](std::size_t at) { return has_any[at] != 0; });
    if (static_cast<double>(arches) <= outer_share * count)
      for (const std::size_t at : row) may[at] = 1;
  }
  return may;
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

/// Adds what one slice gives; false when it shows no leaflet.
bool curves_of_slice(const Slice& slice, int number, bool may_arch, const SliceCurveOptions& options, CurveSet& set) {
  PixelMask mask(slice.parts.size(), 0);
  for (std::size_t p = 0; p < mask.size(); ++p) {
    const auto part = static_cast<SlicePart>(slice.parts[p]);
    mask[p] = part == SlicePart::posterior || part == SlicePart::anterior || part == SlicePart::leaflet;
  }
  if (std::none_of(mask.begin(), mask.end(), [](std::uint8_t x) { return x != 0; })) return false;
  const auto to_atrium = distance_to_mask(slice, mask_of(slice, SlicePart::atrium)), to_ventricle = distance_to_mask(slice, mask_of(slice, SlicePart::ventricle));
  PixelMask atrial(mask.size()), any(mask.size());
  for (std::size_t p = 0; p < mask.size(); ++p) {
    atrial[p] = mask[p] && to_atrium[p] <= options.wall_reach;
    any[p] = atrial[p] || (mask[p] && to_ventricle[p] <= options.wall_reach);
  }
  const std::size_t first = set.curves.size();
  SliceWork work{slice, options, {}, may_arch, number, set};
  for (const PixelMask& group : leaflet_groups(slice, mask, any, options, slice.name, set.notes)) {
    // The body of a leaflet may touch the ventricle's wall, never the atrium's.
    bool touches_atrium = false;
    for (std::size_t p = 0; p < group.size(); ++p) touches_atrium = touches_atrium || (group[p] && atrial[p]);
    work.contact = touches_atrium ? atrial : any;
    curves_of_group(work, group, true);
  }
  int per_leaflet[3] = {0, 0, 0};
  for (std::size_t i = first; i < set.curves.size(); ++i) ++per_leaflet[set.curves[i].region];
  for (const int region : {posterior, anterior})
    if (per_leaflet[region] > 1) set.notes.push_back(fmt::format("{}: the slice cuts the {} leaflet {} times", slice.name, region == anterior ? "anterior" : "posterior", per_leaflet[region]));
  if (may_arch) mark_joined(set, first, options);
  return true;
}

}  // namespace

CurveSet curves_of_slices(std::vector<Slice> slices, const SliceCurveOptions& options) {
  if (slices.empty()) throw InputError("no slices");
  CurveSet set;
  sort_slices(slices, set);
  add_muscles(slices, set);
  for (const Slice& slice : slices) set.resolution += 0.5 * (slice.step_x.norm() + slice.step_y.norm()) / static_cast<double>(slices.size());
  // Once as if every slice were an outer one; then it is known which are.
  const auto all = static_cast<int>(slices.size());
  CurveSet trial = set;
  for (int k = 0; k < all; ++k) curves_of_slice(slices[static_cast<std::size_t>(k)], k, true, options, trial);
  const std::vector<char> may_arch = outer_slices(trial, all);
  std::vector<char> meets(slices.size(), 0);
  for (const auto& c : trial.curves) meets[static_cast<std::size_t>(c.slice)] |= c.end != CurveEnd::free_edge && c.is_hinge_first;
  int with_leaflet = 0, coapting = 0;
  for (int k = 0; k < all; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (meets[at] && !may_arch[at]) ++coapting;
    if (curves_of_slice(slices[at], k, may_arch[at] != 0, options, set)) ++with_leaflet;
    else set.empty_slices.push_back(slices[at].world(0.5 * (slices[at].width - 1), 0.5 * (slices[at].height - 1)));
  }
  if (coapting > 0) set.notes.push_back(fmt::format("the leaflets touch each other in {} slices that are not the outermost: taken as coaptation, their ends as free edge", coapting));
  if (with_leaflet == 0)
    throw InputError(fmt::format("none of the {} slices shows a leaflet; check the labels (mask: any value but 0 is leaflet), and that the slices cut the valve", slices.size()));
  if (with_leaflet < 3)
    throw InputError(fmt::format("only {} of {} slices shows a leaflet; a surface needs at least 3, better 8 or more", with_leaflet, slices.size()));
  mark_nameless_arches(set, all);
  return set;
}

}  // namespace mv
