// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/mid_surface_of_solid.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"
#include "geometry/surface/sheet_remesh.h"
#include "geometry/surface/solid_depth.h"
#include "geometry/surface/solid_faces.h"
#include "geometry/surface/surface_query.h"

namespace mv {
namespace {

using Triangle = std::array<int, 3>;
std::size_t at(long i) { return static_cast<std::size_t>(i); }

constexpr double largest_frustration = 0.25;  // share of the pairs on one face beyond which there are no two faces
constexpr double narrowest_sheet = 1.5;       // mean width over the thickness; a rod has 1, a ball 1/2
constexpr double smallest_part = 2;           // area over the thickness squared
constexpr double rim_reach = 0.75;            // distance from a rim over the thickness within which lines are not trusted
constexpr double largest_continuation = 0.7;  // over the thickness; a fit that asks for more is not trusted
constexpr double corner_colour = 0.6;         // |s| of a rim's point beyond which it lies at the corner to a face
constexpr double largest_area_miss = 0.25;    // of half the faces' area
constexpr double shortest_hole = 2;           // rim over the thickness: a hole narrower than the sheet is thick by two thirds
constexpr double longest_false_hole = 10;     // rim over the thickness of a hole that is filled because no rim of the solid is near

/// Piece of the curve on the solid's surface where the colour changes sign, and the width of the rim there.
struct Segment {
  Vec3 a, b;
  double width;  // mm, over which s goes from -1 to 1
};

std::vector<Segment> rim_middle(const SolidFaces& f) {
  std::vector<Segment> segments;
  for (const Triangle& t : f.triangles) {
    std::vector<Vec3> ends;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double sa = f.colour[at(a)], sb = f.colour[at(b)];
      if ((sa > 0) == (sb > 0)) continue;
      const double w = sa / (sa - sb);
      ends.push_back((1 - w) * f.points[at(a)] + w * f.points[at(b)]);
    }
    if (ends.size() != 2) continue;
    const Vec3 &p = f.points[at(t[0])], &q = f.points[at(t[1])], &r = f.points[at(t[2])];
    const Vec3 n = (q - p).cross(r - p);
    // Gradient of s over the triangle.
    const Vec3 g = n.cross(f.colour[at(t[0])] * (r - q) + f.colour[at(t[1])] * (p - r) + f.colour[at(t[2])] * (q - p)) / n.squaredNorm();
    segments.push_back({ends[0], ends[1], 2 / std::max(g.norm(), 1e-12)});
  }
  return segments;
}

Vec3 nearest_on(const std::vector<Segment>& segments, const Vec3& x, double* width = nullptr) {
  double best = std::numeric_limits<double>::max();
  Vec3 nearest = x;
  for (const auto& [a, b, rim] : segments) {
    const Vec3 d = b - a;
    const double w = d.squaredNorm() > 0 ? std::clamp((x - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
    const Vec3 p = a + w * d;
    if ((p - x).squaredNorm() < best) {
      best = (p - x).squaredNorm(), nearest = p;
      if (width) *width = rim;
    }
  }
  return nearest;
}

std::vector<std::vector<int>> neighbours_of(const std::vector<Triangle>& triangles, std::size_t n) {
  std::vector<std::vector<int>> around(n);
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) around[at(t[k])].insert(around[at(t[k])].end(), {t[(k + 1) % 3], t[(k + 2) % 3]});
  for (auto& a : around) {
    std::sort(a.begin(), a.end());
    a.erase(std::unique(a.begin(), a.end()), a.end());
  }
  return around;
}

/// Values where `known`, elsewhere the mean of the neighbours (harmonic), by sweeps in both directions.
void fill_values(const std::vector<std::vector<int>>& around, const std::vector<char>& known, double start, std::vector<double>& values) {
  std::vector<int> open;
  for (std::size_t i = 0; i < known.size(); ++i)
    if (!known[i]) open.push_back(static_cast<int>(i)), values[i] = start;
  for (int sweep = 0; sweep < 200; ++sweep) {
    for (int i : open) {
      double sum = 0;
      for (int j : around[at(i)]) sum += values[at(j)];
      if (!around[at(i)].empty()) values[at(i)] = sum / static_cast<double>(around[at(i)].size());
    }
    std::reverse(open.begin(), open.end());
  }
}

double area_of(const std::vector<Vec3>& points, const Triangle& t) {
  return 0.5 * (points[at(t[1])] - points[at(t[0])]).cross(points[at(t[2])] - points[at(t[0])]).norm();
}

/// The solid's rims: triangles that do not lie on one face, and the curve s = 0 on them.
class Rims {
 public:
  explicit Rims(const SolidFaces& faces) : faces_(faces), triangles_(of(faces)), middle_(rim_middle(faces)) {
    if (!triangles_.empty() && !middle_.empty()) query_.emplace(faces.points, triangles_);
  }
  const std::vector<Segment>& middle() const { return middle_; }

  /// Point of the rim for a border point: the nearest one, or the middle of the rim where that lies at a corner or where the sheet ends
  /// so sharply that the grid does not see it.
  Vec3 onto(const Vec3& x, double voxel) const {
    if (!query_) return x;
    double width = 0;
    const Vec3 edge = nearest_on(middle_, x, &width);
    if (width < 2 * voxel) return edge;
    const auto hit = query_->nearest(x);
    const Triangle& t = triangles_[at(hit.triangle)];
    double colour = 0;
    for (int k = 0; k < 3; ++k) colour += hit.weights[k] * faces_.colour[at(t[at(k)])];
    return std::abs(colour) < corner_colour ? hit.point : edge;
  }

 private:
  static std::vector<Triangle> of(const SolidFaces& f) {
    std::vector<Triangle> rim;
    for (const Triangle& t : f.triangles) {
      const auto [low, high] = std::minmax({f.colour[at(t[0])], f.colour[at(t[1])], f.colour[at(t[2])]});
      if (low < 0.98 && high > -0.98) rim.push_back(t);
    }
    return rim;
  }

  const SolidFaces& faces_;
  std::vector<Triangle> triangles_;
  std::vector<Segment> middle_;
  std::optional<SurfaceQuery> query_;
};

/// Within the rims: height of the trusted points around over their common plane, fitted by a quadratic and continued to x along the normal;
/// their thickness, fitted by a plane and continued likewise to `across`.
Vec3 continued(const SolidMidSurface& mid, const std::vector<char>& known, const std::vector<std::vector<int>>& around, int i, double& across) {
  const std::vector<Vec3>& points = mid.points;
  const double thickness = mid.thickness[at(i)];
  across = thickness;
  const Vec3 x = points[at(i)];
  // Trusted points within two thicknesses, found over the mesh.
  std::vector<int> queue{i}, trusted;
  std::set<int> seen{i};
  for (std::size_t k = 0; k < queue.size(); ++k)
    for (int j : around[at(queue[k])])
      if ((points[at(j)] - x).norm() < 2 * thickness && seen.insert(j).second) {
        queue.push_back(j);
        if (known[at(j)]) trusted.push_back(j);
      }
  if (trusted.size() < 12) return x;
  Vec3 middle = Vec3::Zero();
  for (int j : trusted) middle += points[at(j)] / static_cast<double>(trusted.size());
  Mat3 spread = Mat3::Zero();
  for (int j : trusted) spread += (points[at(j)] - middle) * (points[at(j)] - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(spread);
  const Vec3 n = axes.eigenvectors().col(0), u = axes.eigenvectors().col(1), v = axes.eigenvectors().col(2);
  const auto terms = [&](const Vec3& p) {
    const double a = (p - middle).dot(u) / thickness, b = (p - middle).dot(v) / thickness;
    return Eigen::Matrix<double, 6, 1>{1, a, b, a * a, a * b, b * b};
  };
  Eigen::Matrix<double, 6, 6> normal = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
  Eigen::Matrix<double, 6, 1> rhs = Eigen::Matrix<double, 6, 1>::Zero();
  Vec3 slope = Vec3::Zero();
  for (int j : trusted) {
    const auto t = terms(points[at(j)]);
    const double weight = std::exp(-(points[at(j)] - x).squaredNorm() / (2.25 * thickness * thickness));
    normal += weight * t * t.transpose();
    rhs += weight * t * (points[at(j)] - middle).dot(n);
    slope += weight * t.head<3>() * mid.thickness[at(j)];
  }
  const Mat3 plane = normal.topLeftCorner<3, 3>();
  across = std::clamp(terms(x).head<3>().dot(plane.ldlt().solve(slope)), 0.75 * thickness, 1.25 * thickness);
  const double move = terms(x).dot(normal.ldlt().solve(rhs)) - (x - middle).dot(n);
  return std::abs(move) < largest_continuation * thickness ? Vec3(x + move * n) : x;
}

/// Moves the border onto the rims and the other points to the middle of their field lines; fills thickness.
void centre(const SolidFaces& faces, const SolidDepth& depth, const Rims& rims, SolidMidSurface& mid) {
  const std::size_t n = mid.points.size();
  const auto around = neighbours_of(mid.triangles, n);
  std::vector<char> is_border(n, 0), known(n, 0);
  for (const auto& loop : border_loops(mid.points, mid.triangles))
    for (int v : loop) is_border[at(v)] = 1;
  std::vector<double> shift(n, 0.0);
  mid.thickness.assign(n, 0.0);
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) {
    if (is_border[at(i)]) return;
    mid.points[at(i)] = depth.to_level(mid.points[at(i)], 0.5);
    const FieldLine line = depth.field_line(mid.points[at(i)]);
    if (!line.ends_on_faces) return;
    known[at(i)] = 1;
    mid.thickness[at(i)] = line.to_lower + line.to_upper;
    shift[at(i)] = 0.5 * (line.to_upper - line.to_lower);
  });
  // A line that ends within a rim is short, and close to a rim the grid's steps bend it: it says nothing about the sheet.
  const SurfaceQuery query(faces.points, faces.triangles);
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) {
    if (!known[at(i)]) return;
    const FieldLine line = depth.field_line(mid.points[at(i)]);
    for (const Vec3& end : {line.lower, line.upper}) {
      const auto hit = query.nearest(end);
      const Triangle& t = faces.triangles[at(hit.triangle)];
      double colour = 0;
      for (int k = 0; k < 3; ++k) colour += hit.weights[k] * faces.colour[at(t[at(k)])];
      if (std::abs(colour) < 0.98) known[at(i)] = 0;
    }
    if ((nearest_on(rims.middle(), mid.points[at(i)]) - mid.points[at(i)]).norm() < rim_reach * mid.thickness[at(i)]) known[at(i)] = 0;
  });
  fill_values(around, known, faces.thickness_median, mid.thickness);
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) {
    if (known[at(i)]) mid.points[at(i)] = depth.along_line(mid.points[at(i)], shift[at(i)]);
  });
  std::vector<Vec3> moved = mid.points;
  std::vector<double> thickness = mid.thickness;
  parallel_for(static_cast<std::ptrdiff_t>(n), [&](std::ptrdiff_t i) {
    if (known[at(i)]) return;
    moved[at(i)] = continued(mid, known, around, static_cast<int>(i), thickness[at(i)]);
    if (is_border[at(i)]) moved[at(i)] = rims.onto(moved[at(i)], depth.voxel());
  });
  mid.points = std::move(moved), mid.thickness = std::move(thickness);
}

/// Border points slide along the rim and inner ones within the surface towards the mean of their neighbours: the snap leaves them uneven.
void even_out(const Rims& rims, double voxel, SolidMidSurface& mid) {
  const std::size_t n = mid.points.size();
  const auto around = neighbours_of(mid.triangles, n);
  std::vector<char> is_border(n, 0);
  const auto loops = border_loops(mid.points, mid.triangles);
  for (const auto& loop : loops)
    for (int v : loop) is_border[at(v)] = 1;
  for (int sweep = 0; sweep < 4; ++sweep) {
    for (const auto& loop : loops)
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vec3 &before = mid.points[at(loop[(k + loop.size() - 1) % loop.size()])], &after = mid.points[at(loop[(k + 1) % loop.size()])];
        Vec3& x = mid.points[at(loop[k])];
        // Only along the border: across it would cut corners.
        const Vec3 along = (after - before).normalized();
        const Vec3 target = rims.onto(x + 0.5 * (0.5 * (before + after) - x).dot(along) * along, voxel);
        if ((target - x).norm() < 0.5 * (before - after).norm()) x = target;
      }
    std::vector<Vec3> normal(n, Vec3::Zero());
    for (const Triangle& t : mid.triangles) {
      const Vec3 a = (mid.points[at(t[1])] - mid.points[at(t[0])]).cross(mid.points[at(t[2])] - mid.points[at(t[0])]);
      for (int v : t) normal[at(v)] += a;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (is_border[i] || around[i].empty()) continue;
      Vec3 mean = Vec3::Zero();
      for (int j : around[i]) mean += mid.points[at(j)] / static_cast<double>(around[i].size());
      const Vec3 m = normal[i].normalized(), d = 0.5 * (mean - mid.points[i]);
      mid.points[i] += d - d.dot(m) * m;
    }
  }
}

/// Label of the solid's triangles where the field line through the triangle's middle ends; the nearer end decides when they differ.
std::vector<int> carry_labels(const SolidSurface& solid, const SolidFaces& faces, const SolidDepth& depth, const SolidMidSurface& mid) {
  std::vector<int> label(mid.triangles.size(), 0);
  const SurfaceQuery query(faces.points, faces.triangles);
  parallel_for(static_cast<std::ptrdiff_t>(label.size()), [&](std::ptrdiff_t t) {
    const Triangle& tri = mid.triangles[at(t)];
    const Vec3 x = (mid.points[at(tri[0])] + mid.points[at(tri[1])] + mid.points[at(tri[2])]) / 3;
    const FieldLine line = depth.field_line(x);
    auto found = query.nearest(line.ends_on_faces ? line.lower : x);
    if (line.ends_on_faces) {
      const auto other = query.nearest(line.upper);
      if ((other.point - x).norm() < (found.point - x).norm()) found = other;
    }
    label[at(t)] = solid.label[at(faces.parent[at(found.triangle)])];
  });
  return label;
}

void check_sheet(const SolidMidSurface& mid) {
  double area = 0, border = 0;
  for (const Triangle& t : mid.triangles) area += area_of(mid.points, t);
  for (const auto& loop : border_loops(mid.points, mid.triangles))
    for (std::size_t i = 0; i < loop.size(); ++i) border += (mid.points[at(loop[i])] - mid.points[at(loop[(i + 1) % loop.size()])]).norm();
  const double width = border > 0 ? 2 * area / border : std::numeric_limits<double>::max();
  if (area <= 0 || width < narrowest_sheet * mid.thickness_median)
    throw InputError(fmt::format("surface: no thick sheet: its mid-surface would be {:.2f} mm wide where it is {:.2f} mm thick; expected closed "
                                 "thick leaflets", width, mid.thickness_median));
}

/// Lengths of the closed curves s = 0 on the solid's surface.
std::vector<double> rim_lengths(const SolidFaces& f) {
  std::map<std::pair<int, int>, int> number;  // of each edge that the curves cross
  std::vector<int> root;
  std::vector<double> length;
  const auto find = [&](int i) {
    while (root[at(i)] != i) i = root[at(i)] = root[at(root[at(i)])];
    return i;
  };
  std::vector<std::pair<int, double>> pieces;
  for (const Triangle& t : f.triangles) {
    std::vector<int> ends;
    std::vector<Vec3> where;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      const double sa = f.colour[at(a)], sb = f.colour[at(b)];
      if ((sa > 0) == (sb > 0)) continue;
      const auto [entry, added] = number.try_emplace(std::minmax(a, b), static_cast<int>(root.size()));
      if (added) root.push_back(entry->second);
      ends.push_back(entry->second);
      where.push_back(f.points[at(a)] + sa / (sa - sb) * (f.points[at(b)] - f.points[at(a)]));
    }
    if (ends.size() != 2) continue;
    root[at(find(ends[0]))] = find(ends[1]);
    pieces.emplace_back(ends[0], (where[1] - where[0]).norm());
  }
  std::map<int, double> sum;
  for (const auto& [edge, piece] : pieces) sum[find(edge)] += piece;
  for (const auto& [curve, total] : sum) length.push_back(total);
  return length;
}

/// A mid-surface has half the area of the two faces and a border along each rim. Where the colouring went astray it has not.
void check_against_faces(const SolidFaces& f, const SolidMidSurface& mid) {
  double expected = 0, area = 0;
  for (const Triangle& t : f.triangles)
    expected += 0.5 * area_of(f.points, t) * (std::abs(f.colour[at(t[0])]) + std::abs(f.colour[at(t[1])]) + std::abs(f.colour[at(t[2])])) / 3;
  for (const Triangle& t : mid.triangles) area += area_of(mid.points, t);
  if (std::abs(area - expected) > largest_area_miss * expected)
    throw InputError(fmt::format("surface: its mid-surface would have {:.0f} mm2 where half of its two faces is {:.0f} mm2: the faces could not be told "
                                 "apart; smooth the surface, remesh it evenly, or remove what is no leaflet", area, expected));
  // Holes about as narrow as the sheet is thick may be open or filled.
  const double narrow = shortest_hole * f.thickness_median;
  std::size_t least = 0, most = 0;
  for (double length : rim_lengths(f)) least += length > 2 * narrow, most += length > 0.5 * narrow;
  const std::size_t loops = border_loops(mid.points, mid.triangles).size();
  if (loops < least || loops > most)
    throw InputError(fmt::format("surface: its mid-surface would have {} border loops where the solid has {} rims: the faces could not be told apart; "
                                 "smooth the surface, remesh it evenly, or remove what is no leaflet", loops,
                                 least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most)));
}

}  // namespace

SolidMidSurface mid_surface_of_solid(const SolidSurface& solid, const SolidMidOptions& options) {
  const double volume = check_closed_surface(solid.points, solid.triangles);
  if (!solid.label.empty() && solid.label.size() != solid.triangles.size())
    throw InputError("surface: labels do not match the number of triangles");
  const SolidFaces faces = colour_solid_faces(solid);
  if (faces.frustrated_share > largest_frustration)
    throw InputError(fmt::format("surface: no thick sheet: {:.0f} % of its opposite points end on the same face; expected closed thick leaflets",
                                 100 * faces.frustrated_share));
  const double thickness = faces.thickness_median;
  SolidMidSurface mid;
  if (faces.frustrated_share > 0.02)
    mid.notes.push_back(fmt::format("surface: {:.1f} % of its opposite points end on the same face", 100 * faces.frustrated_share));
  // Thin places need points between their faces as well.
  const double automatic = std::clamp(faces.thickness_thin / 4, thickness / 12, thickness / 6);
  const double voxel = options.voxel > 0 ? options.voxel : automatic;
  const SolidDepth depth(faces, volume, voxel, options.max_voxels);
  mid.voxel = depth.voxel();
  if (depth.voxel() > 1.001 * voxel)
    mid.notes.push_back(fmt::format("surface: depth solved on {:.3f} mm instead of {:.3f} mm, {} grid points inside", depth.voxel(), voxel,
                                    depth.voxels()));

  SheetOptions tidy;
  tidy.spacing = options.spacing > 0 ? options.spacing : 0.5 * thickness;
  tidy.smallest_part = smallest_part * thickness * thickness;
  tidy.shortest_hole = shortest_hole * thickness;
  const Rims rims(faces);
  tidy.rim_distance = [&rims](const Vec3& x) { return (nearest_on(rims.middle(), x) - x).norm(); };
  tidy.rim_reach = 0.5 * thickness;
  tidy.longest_hole = longest_false_hole * thickness;
  LevelSurface level = depth.level(0.5);
  if (level.triangles.empty()) throw InputError("surface: the depth has no middle level; expected closed thick leaflets");
  level = tidy_sheet(level, tidy, mid.notes);
  mid.points = std::move(level.points), mid.triangles = std::move(level.triangles);
  centre(faces, depth, rims, mid);
  even_out(rims, depth.voxel(), mid);

  std::vector<std::pair<double, double>> seen;
  double whole = 0, sum = 0;
  for (const Triangle& t : mid.triangles)
    for (int v : t) seen.emplace_back(mid.thickness[at(v)], area_of(mid.points, t)), whole += area_of(mid.points, t);
  std::sort(seen.begin(), seen.end());
  for (const auto& [value, area] : seen)
    if ((sum += area) >= 0.5 * whole) { mid.thickness_median = value; break; }
  check_sheet(mid);
  check_against_faces(faces, mid);
  if (!solid.label.empty()) mid.label = carry_labels(solid, faces, depth, mid);
  mid.face_colour.assign(faces.colour.begin(), faces.colour.begin() + static_cast<long>(solid.points.size()));
  connected_parts(mid.triangles, mid.points.size(), &mid.parts);
  return mid;
}

}  // namespace mv
