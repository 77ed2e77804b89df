// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/compare_reference.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "solver/output/contact_map.h"
#include "solver/output/summary.h"
#include "solver/report/png.h"
#include "solver/report/results_data.h"

namespace mv {
namespace {

/// Squared distance of p from a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5).
double squared_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).squaredNorm();
  const double denominator = 1 / (va + vb + vc);
  return (ap - vb * denominator * ab - vc * denominator * ac).squaredNorm();
}

const std::vector<double>* scalar_named(const ReferenceSurface& reference, const std::string& part) {
  for (const auto& [name, values] : reference.point_scalars) {
    std::string lower = name;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (lower.find(part) != std::string::npos) return &values;
  }
  return nullptr;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

/// Reference points of the surface, in the order of the file.
std::vector<int> surface_points(const ReferenceSurface& reference) {
  const std::vector<char> on = reference.is_on_surface();
  std::vector<int> out;
  for (std::size_t i = 0; i < on.size(); ++i)
    if (on[i]) out.push_back(static_cast<int>(i));
  return out;
}

// A displacement given to six digits, between positions given to six.
constexpr double same_point_mm = 0.01;

/// Reference point of each node, or empty; `how` says why.
std::vector<int> match(const MidNodes& nodes, const ReferenceSurface& reference, const ReferenceSurface* rest, std::string& how) {
  const std::vector<int> candidates = surface_points(reference);
  if (rest) {
    if (rest->points.size() != reference.points.size()) throw InputError(fmt::format("the reference at rest has {} points, the closed one {}", rest->points.size(), reference.points.size()));
    std::vector<int> matched;
    for (const Vec3& x : nodes.rest) {
      int best = -1;
      double least = same_point_mm;
      for (const int c : candidates)
        if (const double d = (rest->points[static_cast<std::size_t>(c)] - x).norm(); d < least) least = d, best = c;
      if (best < 0) {
        how = "the reference at rest has no point at some of the nodes";
        return {};
      }
      matched.push_back(best);
    }
    how = "by the places at rest";
    return matched;
  }
  const std::vector<double>* const moved = scalar_named(reference, "displacement");
  if (candidates.size() != nodes.rest.size()) {
    how = fmt::format("the reference has {} nodes, the mid-surface {}", candidates.size(), nodes.rest.size());
    return {};
  }
  if (!moved) {
    how = "the reference has no displacements to check the order of its nodes by";
    return {};
  }
  double worst = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto c = static_cast<std::size_t>(candidates[i]);
    worst = std::max(worst, std::abs((reference.points[c] - nodes.rest[i]).norm() - (*moved)[c]));
  }
  if (worst > same_point_mm) {
    how = fmt::format("the nodes are not in the same order: a displacement differs by {:.3g} mm", worst);
    return {};
  }
  how = fmt::format("same nodes in the same order (displacements agree within {:.1e} mm)", worst);
  return candidates;
}

}  // namespace

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::clamp(std::ceil(share * static_cast<double>(values.size())) - 1, 0.0, static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
  return values[rank];
}

std::vector<double> distances_to_surface(const std::vector<Vec3>& points, const std::vector<Vec3>& surface, const std::vector<std::array<int, 3>>& triangles) {
  struct Ball {
    Vec3 centre;
    double radius;
  };
  std::vector<Ball> balls;
  for (const auto& t : triangles) {
    const Vec3 &a = surface[static_cast<std::size_t>(t[0])], &b = surface[static_cast<std::size_t>(t[1])], &c = surface[static_cast<std::size_t>(t[2])];
    const Vec3 centre = (a + b + c) / 3;
    balls.push_back({centre, std::max({(a - centre).norm(), (b - centre).norm(), (c - centre).norm()})});
  }
  std::vector<double> out;
  std::size_t last = 0;
  for (const Vec3& p : points) {
    auto to = [&](std::size_t t) {
      const auto& c = triangles[t];
      return std::sqrt(squared_distance(p, surface[static_cast<std::size_t>(c[0])], surface[static_cast<std::size_t>(c[1])], surface[static_cast<std::size_t>(c[2])]));
    };
    double least = to(last);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const double bound = least + balls[t].radius;
      if ((balls[t].centre - p).squaredNorm() >= bound * bound) continue;
      if (const double d = to(t); d < least) least = d, last = t;
    }
    out.push_back(least);
  }
  return out;
}

MidNodes mid_nodes(const LeafletsFrame& frame) {
  const LeafletMesh& mesh = frame.mesh;
  std::vector<char> is_corner(mesh.points.size(), 0);
  for (const auto& tet : mesh.tets)
    for (std::size_t c = 0; c < 4; ++c) is_corner[static_cast<std::size_t>(tet[c])] = 1;
  std::map<std::pair<double, double>, int> ventricular_at;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (is_corner[i] && mesh.side[i] == ventricular) ventricular_at[{mesh.unfolded[i].x(), mesh.unfolded[i].y()}] = static_cast<int>(i);
  MidNodes out;
  std::vector<int> column(mesh.points.size(), -1);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!is_corner[i] || mesh.side[i] != atrial) continue;
    const auto partner = ventricular_at.find({mesh.unfolded[i].x(), mesh.unfolded[i].y()});
    if (partner == ventricular_at.end()) throw InputError(fmt::format("leaflets: point {} of the atrial face has no partner on the ventricular face", i));
    const auto j = static_cast<std::size_t>(partner->second);
    column[i] = static_cast<int>(out.current.size());
    out.current.push_back(0.5 * (mesh.points[i] + mesh.points[j]));
    out.rest.push_back(out.current.back() - 0.5 * (frame.displacement[i] + frame.displacement[j]));
    const double pressure = frame.contact_pressure.empty() ? 0.0 : std::max(frame.contact_pressure[i], frame.contact_pressure[j]);
    out.contact_pressure.push_back(pressure);
    out.in_contact.push_back(pressure > 0);
  }
  for (std::size_t e = 0; e < mesh.tets.size(); ++e)
    for (const auto& f : {std::array<int, 3>{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}) {
      std::array<int, 3> t;
      for (std::size_t k = 0; k < 3; ++k) t[k] = column[static_cast<std::size_t>(mesh.tets[e][static_cast<std::size_t>(f[k])])];
      if (t[0] < 0 || t[1] < 0 || t[2] < 0) continue;
      out.triangles.push_back(t);
      out.region.push_back(mesh.region[e]);
    }
  return out;
}

ReferenceComparison compare_with_reference(const MidNodes& nodes, const ReferenceSurface& reference, const std::string& contact_array, const ReferenceSurface* rest) {
  ReferenceComparison c;
  c.distance = distances_to_surface(nodes.current, reference.points, reference.triangles);
  c.distance_median = percentile(c.distance, 0.5);
  c.distance_p90 = percentile(c.distance, 0.9);
  c.distance_max = percentile(c.distance, 1.0);
  c.distance_mean = mean_of(c.distance);
  std::vector<double> moved;
  for (std::size_t i = 0; i < nodes.rest.size(); ++i) moved.push_back((nodes.current[i] - nodes.rest[i]).norm());
  c.displacement_max = percentile(moved, 1.0);
  c.displacement_mean = mean_of(moved);
  for (const char in : nodes.in_contact) c.contact_nodes += in != 0;

  const std::vector<double>* contact = nullptr;
  if (contact_array.empty()) {
    contact = scalar_named(reference, "contact");
  } else {
    const auto found = reference.point_scalars.find(contact_array);
    if (found == reference.point_scalars.end()) throw InputError(fmt::format("the reference has no point array '{}'", contact_array));
    contact = &found->second;
  }
  const std::vector<int> partner = match(nodes, reference, rest, c.correspondence);
  if (partner.empty()) {
    if (contact)
      for (const int p : surface_points(reference)) c.reference_contact_nodes += (*contact)[static_cast<std::size_t>(p)] > 0;
    return c;
  }
  std::vector<double> reference_moved;
  for (std::size_t i = 0; i < partner.size(); ++i) {
    const Vec3& x = reference.points[static_cast<std::size_t>(partner[i])];
    c.node_distance.push_back((nodes.current[i] - x).norm());
    reference_moved.push_back((x - nodes.rest[i]).norm());
  }
  c.node_median = percentile(c.node_distance, 0.5);
  c.node_p90 = percentile(c.node_distance, 0.9);
  c.node_max = percentile(c.node_distance, 1.0);
  c.reference_displacement_max = percentile(reference_moved, 1.0);
  c.reference_displacement_mean = mean_of(reference_moved);
  if (!contact) return c;
  long both = 0;
  for (std::size_t i = 0; i < partner.size(); ++i) {
    const bool is_in = (*contact)[static_cast<std::size_t>(partner[i])] > 0;
    c.reference_contact.push_back(is_in);
    c.reference_contact_nodes += is_in;
    both += is_in && nodes.in_contact[i];
  }
  if (c.reference_contact_nodes + c.contact_nodes > 0) c.dice = 2.0 * static_cast<double>(both) / static_cast<double>(c.reference_contact_nodes + c.contact_nodes);
  return c;
}

ReferenceComparison compare_results_with_reference(const std::filesystem::path& results, const std::filesystem::path& reference_file, const std::filesystem::path& output,
                                                   const ReferenceOptions& options) {
  const ResultsData data = read_results(results);
  if (!data.frames.closed) throw InputError((results / "leaflets.pvd").string() + ": no frame after the first; run the case to its end");
  const LeafletsFrame& frame = *data.frames.closed;
  const ReferenceSurface reference = read_reference_surface(reference_file);
  std::optional<ReferenceSurface> rest;
  if (!options.rest.empty()) rest = read_reference_surface(options.rest);
  const MidNodes nodes = mid_nodes(frame);
  const ReferenceComparison c = compare_with_reference(nodes, reference, options.contact_array, rest ? &*rest : nullptr);

  std::error_code code;
  std::filesystem::create_directories(output, code);
  if (code) throw IoError(output.string() + ": cannot be created: " + code.message());
  Summary json;
  json.set("reference.file", reference_file.filename().string());
  json.set("reference.sha256", sha256_of_file(reference_file));
  json.set("time_s", frame.time);
  json.set("nodes", static_cast<long>(nodes.current.size()));
  json.set("correspondence", c.correspondence);
  json.set("distance.median_mm", c.distance_median);
  json.set("distance.p90_mm", c.distance_p90);
  json.set("distance.max_mm", c.distance_max);
  json.set("distance.mean_mm", c.distance_mean);
  const bool is_matched = !c.node_distance.empty();
  const auto if_matched = [&](double value) { return is_matched ? Json(value) : Json(); };
  json.set("node.median_mm", if_matched(c.node_median));
  json.set("node.p90_mm", if_matched(c.node_p90));
  json.set("node.max_mm", if_matched(c.node_max));
  json.set("displacement.max_mm", c.displacement_max);
  json.set("displacement.mean_mm", c.displacement_mean);
  json.set("displacement.reference_max_mm", if_matched(c.reference_displacement_max));
  json.set("displacement.reference_mean_mm", if_matched(c.reference_displacement_mean));
  json.set("contact.nodes", c.contact_nodes);
  json.set("contact.reference_nodes", c.reference_contact_nodes);
  json.set("contact.dice", c.dice ? Json(*c.dice) : Json());
  json.write(output / "comparison.json");

  std::string csv = "node,x_mm,y_mm,z_mm,distance_mm,node_distance_mm,in_contact,reference_in_contact,contact_pressure_kPa\n";
  for (std::size_t i = 0; i < nodes.current.size(); ++i) {
    const Vec3& x = nodes.current[i];
    csv += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{},{},{},{:.6g}\n", i, x.x(), x.y(), x.z(), c.distance[i], is_matched ? fmt::format("{:.6f}", c.node_distance[i]) : "",
                       int{nodes.in_contact[i]}, c.reference_contact.empty() ? "" : std::to_string(int{c.reference_contact[i]}), nodes.contact_pressure[i]);
  }
  write_text_atomically(output / "comparison.csv", csv);
  write_text_atomically(output / "comparison.png", encode_png(draw_comparison(nodes, reference, c, frame.annulus_normal)));
  return c;
}

}  // namespace mv
