// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/surface/read_surface.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "geometry/core/config.h"
#include "geometry/core/errors.h"
#include "geometry/surface/surface_formats.h"

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::string contents(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw IoError("surface: " + file.string() + " is a directory; expected a surface file");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw IoError("surface: cannot read " + file.string() + "; check the path");
  std::ostringstream text;
  text << in.rdbuf();
  return std::move(text).str();
}

void check(const std::filesystem::path& file, const RawSurface& s) {
  const int n = static_cast<int>(s.points.size());
  for (std::size_t i = 0; i < s.points.size(); ++i)
    if (!s.points[i].allFinite())
      throw InputError(fmt::format("surface: {}: point {} is not finite; expected numbers for x, y, z", file.string(), i));
  for (std::size_t t = 0; t < s.triangles.size(); ++t)
    for (int v : s.triangles[t])
      if (v < 0 || v >= n)
        throw InputError(fmt::format("surface: {}: polygon {} refers to point {} of {}", file.string(), t, v, n));
  if (s.triangles.empty()) throw InputError("surface: " + file.string() + " holds no triangle; expected a surface");
}

}  // namespace

void add_polygon(RawSurface& surface, const std::vector<int>& corners, int group) {
  // Fan from the corner whose triangles are the least slender: a quad is cut along its shorter diagonal, a concave polygon inside.
  const std::size_t n = corners.size();
  std::size_t best = 0;
  if (n > 3) {
    double best_worst = -2;
    Vec3 normal = Vec3::Zero();
    const auto p = [&](std::size_t k) -> const Vec3& { return surface.points[at(corners[k % n])]; };
    for (std::size_t k = 1; k + 1 < n; ++k) normal += (p(k) - p(0)).cross(p(k + 1) - p(0));
    for (std::size_t first = 0; first < n; ++first) {
      double worst = 2;
      for (std::size_t k = 1; k + 1 < n; ++k) {
        const Vec3 &a = p(first), &b = p(first + k), &c = p(first + k + 1);
        const double edges = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
        const double area = (b - a).cross(c - a).dot(normal.normalized());
        worst = std::min(worst, edges > 0 ? area / edges : -1);
      }
      if (worst > best_worst + 1e-12) best_worst = worst, best = first;
    }
  }
  for (std::size_t k = 1; k + 1 < n; ++k) {
    surface.triangles.push_back({corners[best], corners[(best + k) % n], corners[(best + k + 1) % n]});
    if (group >= 0) surface.group.push_back(group);
  }
}

RawSurface read_surface(const std::filesystem::path& file, const std::string& unit) {
  const std::string ending = lower(file.extension().string());
  const std::string text = contents(file);
  if (text.empty()) throw InputError("surface: " + file.string() + " is empty; expected a surface");
  RawSurface s;
  std::string recorded;
  if (ending == ".stl") s = parse_stl(file.string(), text);
  else if (ending == ".obj") s = parse_obj(file.string(), text);
  else if (ending == ".ply") s = parse_ply(file.string(), text);
  else if (ending == ".vtp" || ending == ".vtk") s = parse_vtk(file, ending == ".vtp", recorded);
  else
    throw InputError("surface: " + file.string() + " has the ending '" + ending + "'; expected .stl, .obj, .ply, .vtp or .vtk");
  check(file, s);
  const std::string chosen = unit == "auto" ? (recorded.empty() ? "mm" : recorded) : unit;
  if (unit != "auto" && !recorded.empty() && recorded != unit)
    s.notes.push_back(file.string() + " records the unit " + recorded + ", but " + unit + " was asked for and is used");
  const double factor = unit_factor(chosen) / unit_factor("mm");
  if (factor != 1)
    for (Vec3& p : s.points) p *= factor;
  return s;
}

void expect_valve_size(const RawSurface& surface, const std::string& name, const std::string& unit) {
  constexpr double smallest = 5, largest = 300;  // mm, an infant's valve to a whole heart
  Eigen::AlignedBox3d box;
  for (const auto& t : surface.triangles)
    for (int v : t) box.extend(surface.points[at(v)]);
  const double size = surface.triangles.empty() ? 0 : box.diagonal().norm();
  if (size >= smallest && size <= largest) return;
  const double in_file = size / unit_factor(unit == "auto" ? "mm" : unit);
  std::string fitting;
  for (const char* other : {"um", "mm", "cm", "m"})
    if (in_file * unit_factor(other) >= smallest && in_file * unit_factor(other) <= largest)
      fitting += fmt::format("{}\"{}\"", fitting.empty() ? "surface.unit = " : " or ", other);
  throw InputError(fmt::format("surface: {} is {:.3g} mm from corner to corner with surface.unit = \"{}\"; expected {} to {} mm for a valve: {}", name, size,
                               unit, smallest, largest, fitting.empty() ? "no unit fits, check the file" : "set " + fitting));
}

}  // namespace mv
