// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/valve_metrics.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "geometry/annulus/annulus_fit.h"
#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "pipeline/source_file.h"

namespace mv {
namespace {

const std::string preset = "MitralValve";

std::string leaflet_name(int region) {
  return region == Region::anterior    ? "anterior leaflet"
         : region == Region::posterior ? "posterior leaflet"
                                       : fmt::format("leaflet {}", region);
}

/// Points of the annulus at which the leaflets change, in the order of the curve.
std::vector<Vec3> commissures_on_annulus(const MidSurface& surface) {
  std::map<int, int> regions_at;  // point: regions as bits
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const int point : surface.triangles[t]) {
      if (surface.on_annulus[static_cast<std::size_t>(point)]) regions_at[point] |= 1 << surface.region[t];
    }
  }
  std::vector<Vec3> found;
  for (const auto& [point, bits] : regions_at) {
    if ((bits & (bits - 1)) != 0) found.push_back(surface.points[static_cast<std::size_t>(point)]);
  }
  return found;
}

std::map<int, double> areas(const MidSurface& surface) {
  std::map<int, double> area;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 &pa = surface.points[static_cast<std::size_t>(a)], &pb = surface.points[static_cast<std::size_t>(b)],
               &pc = surface.points[static_cast<std::size_t>(c)];
    area[surface.region[t]] += 0.5 * (pb - pa).cross(pc - pa).norm();
  }
  return area;
}

std::map<int, double> volumes(const LeafletMesh& mesh) {
  std::map<int, double> volume;
  for (std::size_t e = 0; e < mesh.tets.size(); ++e) {
    const auto at = [&](std::size_t k) -> const Vec3& { return mesh.points[static_cast<std::size_t>(mesh.tets[e][k])]; };
    volume[mesh.region[e]] += std::abs((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0))) / 6;
  }
  return volume;
}

void add_leaflets(const MidSurface& surface, const LeafletMesh& mesh, std::vector<Metric>& metrics) {
  const auto area = areas(surface);
  const auto volume = volumes(mesh);
  double area_sum = 0, volume_sum = 0, thickness_sum = 0;
  for (const auto& [region, value] : area) {
    const double leaflet_volume = volume.contains(region) ? volume.at(region) : 0;
    metrics.push_back({"Leaflet volume - " + leaflet_name(region), leaflet_volume, "mm*mm*mm"});
    metrics.push_back({"Leaflet area - " + leaflet_name(region), value, "mm*mm"});
    metrics.push_back({"Leaflet thickness estimate - " + leaflet_name(region), leaflet_volume / value, "mm"});
    area_sum += value;
    volume_sum += leaflet_volume;
    thickness_sum += leaflet_volume / value;
  }
  metrics.push_back({"Leaflet volume - all", volume_sum, "mm*mm*mm"});
  metrics.push_back({"Leaflet area - all", area_sum, "mm*mm"});
  metrics.push_back({"Leaflet thickness estimate - all", thickness_sum / static_cast<double>(area.size()), "mm"});
}

/// A cell of a CSV table, in quotes where it has to be.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string number(double value) { return fmt::format("{:.6g}", value); }

std::string wide_table(const std::vector<ValveMetrics>& valves, const std::vector<std::string>& names) {
  std::string text = "Filename,Phase,Measurement";
  for (const std::string& name : names) text += "," + cell(name);
  text += "\n";
  for (const ValveMetrics& valve : valves) {
    text += cell(valve.filename) + "," + cell(valve.phase) + "," + preset;
    for (const std::string& name : names) {
      const auto found =
          std::find_if(valve.metrics.begin(), valve.metrics.end(), [&](const Metric& m) { return m.name == name; });
      text += "," + (found == valve.metrics.end() ? std::string() : number(found->value));
    }
    text += "\n";
  }
  return text;
}

std::string long_table(const std::vector<ValveMetrics>& valves) {
  std::string text = "Filename,Phase,Measurement,Value\n";
  for (const ValveMetrics& valve : valves) {
    const std::string start = cell(valve.filename) + "," + cell(valve.phase) + ",";
    text += start + "ValveType," + preset + "\n";
    for (const Metric& metric : valve.metrics) text += start + cell(metric.name) + "," + number(metric.value) + "\n";
  }
  return text;
}

}  // namespace

std::vector<Metric> measure_case_metrics(const std::filesystem::path& case_directory) {
  const SourceGeometry source = read_source(case_directory / "mid_surface.vtp");
  const Annulus annulus = read_annulus(case_directory / "annulus.vtp");
  const LeafletMesh mesh = read_leaflets(case_directory / "leaflets.vtu");
  const AnnulusMetrics m = measure_annulus(annulus, source.anterior_direction);
  std::vector<Metric> metrics = {{"Annulus circumference (3D)", m.perimeter, "mm"},
                                 {"A-P distance", m.ap_diameter, "mm"},
                                 {"AL-PM distance", m.al_pm_diameter, "mm"}};
  if (const auto c = commissures_on_annulus(source.surface); c.size() == 2) {
    metrics.push_back({"ALC-PMC distance", (c[0] - c[1]).norm(), "mm"});
  }
  for (const Metric& metric : std::vector<Metric>{{"Sphericity index (A-P / AL-PM)", m.sphericity, "mm/mm"},
                                                  {"Annulus height", m.height, "mm"},
                                                  {"Annulus height above", m.height_above, "mm"},
                                                  {"Annulus height below", m.height_below, "mm"},
                                                  {"Annulus area (2D)", m.area_2d, "mm*mm"},
                                                  {"Annulus area (3D)", m.area_3d, "mm*mm"}})
    metrics.push_back(metric);
  add_leaflets(source.surface, mesh, metrics);
  return metrics;
}

void write_metrics(const std::filesystem::path& directory, const std::vector<ValveMetrics>& valves) {
  std::vector<std::string> names;
  std::string units = "Measurement,Unit\n";
  for (const ValveMetrics& valve : valves) {
    for (const Metric& metric : valve.metrics) {
      if (std::find(names.begin(), names.end(), metric.name) != names.end()) continue;
      names.push_back(metric.name);
      units += cell(metric.name) + "," + metric.unit + "\n";
    }
  }
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (!std::filesystem::is_directory(directory)) throw IoError("cannot create the directory " + directory.string());
  write_text_atomically(directory / "QuantificationResults_wide.csv", wide_table(valves, names));
  write_text_atomically(directory / "QuantificationResults_long.csv", long_table(valves));
  write_text_atomically(directory / "QuantificationUnits.csv", units);
}

}  // namespace mv
