// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/label_landmarks.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/core/errors.h"
#include "geometry/image/distance_map.h"
#include "geometry/image/papillary_heads.h"

namespace mv {
namespace {

constexpr int directions = 72;            // around the annulus
constexpr double least_hinge_share = 0.5;  // of them, or the annulus is left to the leaflets' border
constexpr double largest_gap = 120;        // degrees that may be bridged
constexpr double small_seam_share = 0.25;  // of the larger seam between the leaflets
constexpr int box_margin = 2;

bool is_part(std::int32_t value, Part part) { return value == static_cast<std::int32_t>(part); }
bool is_leaflet(std::int32_t value) { return is_part(value, Part::posterior) || is_part(value, Part::anterior); }

template <class Take>
std::optional<Vec3> centre_of(const LabelImage& image, Take&& take) {
  Vec3 sum = Vec3::Zero();
  long count = 0;
  std::size_t v = 0;
  for (int k = 0; k < image.size[2]; ++k)
    for (int j = 0; j < image.size[1]; ++j)
      for (int i = 0; i < image.size[0]; ++i, ++v)
        if (take(image.values[v])) sum += Vec3(i, j, k), ++count;
  if (count == 0) return std::nullopt;
  return image.world(sum / static_cast<double>(count));
}

struct Centres {
  Vec3 leaflets;
  std::optional<Vec3> papillary, atrium, ventricle, aorta;
};

Centres centres_of(const LabelImage& image) {
  const auto of = [&](Part part) { return centre_of(image, [part](std::int32_t v) { return is_part(v, part); }); };
  return {*centre_of(image, is_leaflet),
          centre_of(image, [](std::int32_t v) { return is_part(v, Part::papillary) || is_part(v, Part::papillary_anterolateral) || is_part(v, Part::papillary_posteromedial); }),
          of(Part::atrium), of(Part::ventricle), of(Part::aorta)};
}

void find_direction(const Centres& c, LabelLandmarks& marks, const std::string& name) {
  std::optional<Vec3> by_walls;
  std::string rule;
  if (c.atrium && c.ventricle) by_walls = *c.ventricle - *c.atrium, rule = "from atrium to ventricle label";
  else if (c.ventricle) by_walls = *c.ventricle - c.leaflets, rule = "from leaflets to ventricle label";
  else if (c.atrium) by_walls = c.leaflets - *c.atrium, rule = "from atrium label to leaflets";
  if (c.papillary) {
    const Vec3 by_papillary = *c.papillary - c.leaflets;
    if (by_walls && by_papillary.normalized().dot(by_walls->normalized()) < -0.3)
      throw InputError(name + ": the papillary muscles lie on the side of the atrium's label; check labels.atrium, labels.ventricle and the papillary labels (labels.preset)");
    marks.ventricle_direction = by_papillary.normalized();
    marks.direction_rule = "from leaflets to papillary labels";
  } else if (by_walls) {
    marks.ventricle_direction = by_walls->normalized();
    marks.direction_rule = rule;
  }
}

/// Leaflet voxels near both walls.
struct Hinge {
  std::vector<Vec3> points;
  std::vector<double> reach;  // mm, to the further of the two walls
};

Hinge hinge_voxels(const LabelledParts& parts, double contact) {
  std::array<int, 3> low = parts.low, high = parts.high;
  for (std::size_t a = 0; a < 3; ++a) low[a] -= box_margin, high[a] += box_margin;
  const LabelImage box = cropped(parts.image, low, high);
  const auto distance_to = [&](Part part) { return distance_map(box.size, box.spacing(), [&](std::size_t v) { return is_part(box.values[v], part); }); };
  const std::vector<float> atrium = distance_to(Part::atrium), ventricle = distance_to(Part::ventricle);
  Hinge hinge;
  std::size_t v = 0;
  for (int k = 0; k < box.size[2]; ++k)
    for (int j = 0; j < box.size[1]; ++j)
      for (int i = 0; i < box.size[0]; ++i, ++v) {
        const double reach = std::max(atrium[v], ventricle[v]);
        if (!is_leaflet(box.values[v]) || reach > contact) continue;
        hinge.points.push_back(box.world(i, j, k));
        hinge.reach.push_back(reach);
      }
  return hinge;
}

struct Frame {
  Vec3 centre, e1, e2, e3;  // e3 across the plane
};

Frame plane_of(const std::vector<Vec3>& points) {
  Frame f;
  f.centre = std::accumulate(points.begin(), points.end(), Vec3(Vec3::Zero())) / static_cast<double>(points.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : points) spread += (p - f.centre) * (p - f.centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(spread);
  f.e3 = solver.eigenvectors().col(0), f.e1 = solver.eigenvectors().col(2), f.e2 = f.e3.cross(f.e1);
  return f;
}

/// Weighted means per direction around the frame; directions without voxels have no weight.
void average_by_direction(const Hinge& hinge, const Frame& f, double contact, std::vector<Vec3>& mean, std::vector<double>& weight) {
  mean.assign(directions, Vec3::Zero());
  weight.assign(directions, 0);
  for (std::size_t p = 0; p < hinge.points.size(); ++p) {
    const Vec3 d = hinge.points[p] - f.centre;
    const double angle = std::atan2(d.dot(f.e2), d.dot(f.e1)) / (2 * M_PI) + 0.5;
    const auto n = std::min(static_cast<std::size_t>(angle * directions), static_cast<std::size_t>(directions - 1));
    const double w = std::exp(-3 * hinge.reach[p] / contact);
    mean[n] += w * hinge.points[p];
    weight[n] += w;
  }
  for (std::size_t n = 0; n < mean.size(); ++n)
    if (weight[n] > 0) mean[n] /= weight[n];
}

/// Empty directions: radius and height between those of the neighbours, linear in the angle. Returns the largest gap in directions.
int bridge_gaps(const Frame& f, std::vector<Vec3>& mean, const std::vector<double>& weight) {
  int largest = 0;
  for (int n = 0; n < directions; ++n) {
    if (weight[static_cast<std::size_t>(n)] > 0) continue;
    int back = 1, forth = 1;
    while (weight[static_cast<std::size_t>((n - back + directions) % directions)] == 0) ++back;
    while (weight[static_cast<std::size_t>((n + forth) % directions)] == 0) ++forth;
    largest = std::max(largest, back + forth - 1);
    const Vec3 a = mean[static_cast<std::size_t>((n - back + directions) % directions)] - f.centre, b = mean[static_cast<std::size_t>((n + forth) % directions)] - f.centre;
    const double s = static_cast<double>(back) / (back + forth), angle = 2 * M_PI * ((n + 0.5) / directions - 0.5);
    const double radius = (1 - s) * std::hypot(a.dot(f.e1), a.dot(f.e2)) + s * std::hypot(b.dot(f.e1), b.dot(f.e2));
    const double height = (1 - s) * a.dot(f.e3) + s * b.dot(f.e3);
    mean[static_cast<std::size_t>(n)] = f.centre + radius * (std::cos(angle) * f.e1 + std::sin(angle) * f.e2) + height * f.e3;
  }
  return largest;
}

void find_annulus(const LabelledParts& parts, const LandmarkOptions& options, const Centres& centres, LabelLandmarks& marks) {
  if (!centres.atrium || !centres.ventricle) {
    marks.notes.push_back("no labels of both atrium and ventricle: the annulus is found from the leaflets' own border");
    return;
  }
  const double contact = options.contact * parts.image.spacing().norm();
  const Hinge hinge = hinge_voxels(parts, contact);
  const auto leave_it = [&](const std::string& why) { marks.notes.push_back(why + ": the annulus is found from the leaflets' own border"); };
  if (hinge.points.size() < 3 * static_cast<std::size_t>(directions) / 4) return leave_it(fmt::format("only {} leaflet voxels touch both atrium and ventricle", hinge.points.size()));
  Frame frame = plane_of(hinge.points);
  std::vector<Vec3> mean;
  std::vector<double> weight;
  average_by_direction(hinge, frame, contact, mean, weight);
  // A hinge that is thicker on one side draws the centre there: take the middle of the directions instead and repeat.
  std::vector<Vec3> filled;
  for (std::size_t n = 0; n < mean.size(); ++n)
    if (weight[n] > 0) filled.push_back(mean[n]);
  if (filled.size() >= 8) {
    frame = plane_of(filled);
    average_by_direction(hinge, frame, contact, mean, weight);
  }
  const auto count = std::count_if(weight.begin(), weight.end(), [](double w) { return w > 0; });
  marks.hinge_share = static_cast<double>(count) / directions;
  if (marks.hinge_share < least_hinge_share) return leave_it(fmt::format("leaflet, atrium and ventricle meet in only {:.0f} % of the directions", 100 * marks.hinge_share));
  const int gap = bridge_gaps(frame, mean, weight);
  const double degrees = 360.0 * gap / directions;
  if (degrees > largest_gap) return leave_it(fmt::format("leaflet, atrium and ventricle do not meet over {:.0f} degrees of the annulus", degrees));
  if (gap > 1) marks.notes.push_back(fmt::format("annulus: leaflet, atrium and ventricle do not meet over {:.0f} degrees; bridged", degrees));
  marks.annulus_curve = mean;
  for (const double w : weight) marks.annulus_seen.push_back(w > 0);
}

/// Posterior voxels with an anterior neighbour (26).
std::vector<std::array<int, 3>> seam_voxels(const LabelledParts& parts) {
  const LabelImage& image = parts.image;
  std::vector<std::array<int, 3>> seam;
  for (int k = parts.low[2]; k <= parts.high[2]; ++k)
    for (int j = parts.low[1]; j <= parts.high[1]; ++j)
      for (int i = parts.low[0]; i <= parts.high[0]; ++i) {
        if (!is_part(image.at(i, j, k), Part::posterior)) continue;
        bool touches = false;
        for (int n = 0; n < 27 && !touches; ++n) {
          const int x = i + n % 3 - 1, y = j + n / 3 % 3 - 1, z = k + n / 9 - 1;
          touches = x >= 0 && y >= 0 && z >= 0 && x < image.size[0] && y < image.size[1] && z < image.size[2] && is_part(image.at(x, y, z), Part::anterior);
        }
        if (touches) seam.push_back({i, j, k});
      }
  return seam;
}

/// Seams as groups of neighbouring voxels, largest first, small ones left out.
std::vector<std::vector<std::array<int, 3>>> seams_of(const LabelledParts& parts) {
  std::vector<std::array<int, 3>> rest = seam_voxels(parts);
  std::vector<std::vector<std::array<int, 3>>> seams;
  while (!rest.empty()) {
    std::vector<std::array<int, 3>> seam{rest.back()};
    rest.pop_back();
    for (std::size_t n = 0; n < seam.size(); ++n)
      for (std::size_t r = 0; r < rest.size();) {
        bool is_near = true;
        for (std::size_t a = 0; a < 3; ++a) is_near = is_near && std::abs(rest[r][a] - seam[n][a]) <= 2;  // a ragged seam may miss a voxel
        if (!is_near) {
          ++r;
          continue;
        }
        seam.push_back(rest[r]);
        rest[r] = rest.back();
        rest.pop_back();
      }
    seams.push_back(std::move(seam));
  }
  std::sort(seams.begin(), seams.end(), [](const auto& a, const auto& b) { return a.size() != b.size() ? a.size() > b.size() : a < b; });
  if (!seams.empty()) {
    const double least = small_seam_share * static_cast<double>(seams.front().size());
    std::erase_if(seams, [&](const auto& s) { return static_cast<double>(s.size()) < least; });
  }
  return seams;
}

void find_commissures(const LabelledParts& parts, LabelLandmarks& marks) {
  const auto seams = seams_of(parts);
  if (seams.size() != 2) {
    marks.notes.push_back(fmt::format("the leaflets' labels touch along {} seams, not 2: commissures are found from the surface", seams.size()));
    return;
  }
  for (const auto& seam : seams) {
    double best = 1e300;
    Vec3 at = Vec3::Zero();
    for (const auto& voxel : seam) {
      const Vec3 x = parts.image.world(voxel[0], voxel[1], voxel[2]);
      double rank = 0;
      if (!marks.annulus_curve.empty()) {
        rank = 1e300;
        for (const Vec3& p : marks.annulus_curve) rank = std::min(rank, (p - x).norm());
      } else if (marks.ventricle_direction) {
        rank = x.dot(*marks.ventricle_direction);
      } else {
        return;
      }
      if (rank < best) best = rank, at = x;
    }
    marks.commissures.push_back(at);
  }
}

void find_papillary_tips(const LabelledParts& parts, const LandmarkOptions& options, const Vec3& valve, LabelLandmarks& marks) {
  for (const auto& [part, muscle] : {std::pair{Part::papillary_anterolateral, "anterolateral"}, std::pair{Part::papillary_posteromedial, "posteromedial"}, std::pair{Part::papillary, ""}})
    for (const PapillaryHead& head : papillary_heads(parts.image, part, valve, options.head_prominence, options.head_cap)) {
      marks.papillary_points.push_back(head.tip);
      marks.papillary_names.emplace_back(muscle);
    }
  const auto count = [&](const char* muscle) { return std::count(marks.papillary_names.begin(), marks.papillary_names.end(), muscle); };
  if (count("") == 0 && count("anterolateral") + count("posteromedial") > 0)
    for (const char* muscle : {"anterolateral", "posteromedial"})
      if (count(muscle) == 0) marks.notes.push_back(fmt::format("the map holds no {} papillary muscle", muscle));
}

}  // namespace

LabelLandmarks find_landmarks(const LabelledParts& parts, const LandmarkOptions& options, const std::string& name) {
  LabelLandmarks marks;
  const Centres centres = centres_of(parts.image);
  find_direction(centres, marks, name);
  find_annulus(parts, options, centres, marks);
  find_commissures(parts, marks);
  const Vec3 valve = centres.leaflets;
  find_papillary_tips(parts, options, valve, marks);
  marks.anterior_hint = centres.aorta;
  return marks;
}

}  // namespace mv
