// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/compare_cases.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

double percent(double a, double b) { return a > 0 ? 100 * (b - a) / a : 0; }

void print(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0) throw IoError("cannot write to the standard output");
}

}  // namespace

CaseGeometry read_case_geometry(const std::filesystem::path& case_directory) {
  for (const char* file : {"mid_surface.vtp", "annulus.vtp"})
    if (!std::filesystem::exists(case_directory / file))
      throw IoError(fmt::format("{} has no {}: not a case, or not finished; make one with `mvprep run -c config.toml -o {}`", case_directory.string(), file, case_directory.string()));
  const SourceGeometry source = read_source(case_directory / "mid_surface.vtp");
  const Annulus annulus = read_annulus(case_directory / "annulus.vtp");
  CaseGeometry g;
  g.name = case_directory.string();
  g.points = source.surface.points;
  g.triangles = source.surface.triangles;
  for (std::size_t t = 0; t < g.triangles.size(); ++t) {
    const auto& k = g.triangles[t];
    const Vec3 &a = g.points[static_cast<std::size_t>(k[0])], &b = g.points[static_cast<std::size_t>(k[1])], &c = g.points[static_cast<std::size_t>(k[2])];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    g.area += area;
    (source.surface.region[t] == anterior ? g.area_anterior : g.area_posterior) += area;
  }
  for (std::size_t i = 0; i < annulus.points.size(); ++i) g.perimeter += (annulus.points[(i + 1) % annulus.points.size()] - annulus.points[i]).norm();
  g.annulus_normal = annulus.normal;
  g.annulus_center = annulus.origin;
  return g;
}

CaseComparison compare_geometry(const CaseGeometry& a, const CaseGeometry& b) {
  CaseComparison c;
  c.a = a.name;
  c.b = b.name;
  c.distance = surface_distance(a.points, a.triangles, b.points, b.triangles);
  c.normal_angle = std::atan2(a.annulus_normal.cross(b.annulus_normal).norm(), a.annulus_normal.dot(b.annulus_normal)) * 180 / std::numbers::pi;
  c.center_distance = (a.annulus_center - b.annulus_center).norm();
  c.area_difference = percent(a.area, b.area);
  c.area_difference_anterior = percent(a.area_anterior, b.area_anterior);
  c.area_difference_posterior = percent(a.area_posterior, b.area_posterior);
  c.perimeter_difference = percent(a.perimeter, b.perimeter);
  return c;
}

std::string comparison_csv(const std::vector<CaseComparison>& comparisons) {
  std::string csv =
      "case_a,case_b,distance_mean_mm,distance_p95_mm,distance_max_mm,distance_mean_a_to_b_mm,distance_mean_b_to_a_mm,normal_angle_deg,center_distance_mm,"
      "area_difference_percent,area_anterior_difference_percent,area_posterior_difference_percent,perimeter_difference_percent\n";
  for (const auto& c : comparisons)
    csv += fmt::format("\"{}\",\"{}\",{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.3f},{:.4f},{:.3f},{:.3f},{:.3f},{:.3f}\n", c.a, c.b, c.distance.mean, c.distance.p95, c.distance.max,
                       c.distance.mean_a_to_b, c.distance.mean_b_to_a, c.normal_angle, c.center_distance, c.area_difference, c.area_difference_anterior,
                       c.area_difference_posterior, c.perimeter_difference);
  return csv;
}

void compare_command(const std::vector<std::filesystem::path>& cases, const std::filesystem::path& csv) {
  if (cases.size() < 2) throw UsageError("compare needs at least two cases");
  std::vector<CaseGeometry> geometries;
  print(fmt::format("{:<32} {:>9} {:>9} {:>9} {:>10}\n", "case", "area mm2", "anterior", "posterior", "annulus mm"));
  for (const auto& directory : cases) {
    geometries.push_back(read_case_geometry(directory));
    const CaseGeometry& g = geometries.back();
    print(fmt::format("{:<32} {:>9.1f} {:>9.1f} {:>9.1f} {:>10.1f}\n", g.name, g.area, g.area_anterior, g.area_posterior, g.perimeter));
  }
  print(fmt::format("\n{:<48} {:>7} {:>7} {:>7} {:>8} {:>8} {:>9} {:>9} {:>9}\n", "mid-surfaces, both directions", "mean mm", "95 % mm", "max mm", "normal", "centre", "area", "anterior",
                    "posterior"));
  std::vector<CaseComparison> comparisons;
  for (std::size_t i = 0; i < geometries.size(); ++i)
    for (std::size_t j = i + 1; j < geometries.size(); ++j) {
      comparisons.push_back(compare_geometry(geometries[i], geometries[j]));
      const CaseComparison& c = comparisons.back();
      print(fmt::format("{:<48} {:>7.3f} {:>7.3f} {:>7.3f} {:>6.2f} ° {:>5.2f} mm {:>+7.1f} % {:>+7.1f} % {:>+7.1f} %\n", c.a + " / " + c.b, c.distance.mean, c.distance.p95,
                        c.distance.max, c.normal_angle, c.center_distance, c.area_difference, c.area_difference_anterior, c.area_difference_posterior));
    }
  if (!csv.empty()) write_text_atomically(csv, comparison_csv(comparisons));
}

}  // namespace mv
