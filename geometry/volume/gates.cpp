// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/volume/gates.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace mv {
namespace {

std::size_t at(long i) { return static_cast<std::size_t>(i); }

constexpr std::array<std::array<std::size_t, 2>, 6> tet_edges{{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

Vec3 centre_of(const LeafletMesh& m, std::size_t e) {
  Vec3 c = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) c += 0.25 * m.points[at(m.tets[e][k])];
  return c;
}

std::string place(const LeafletMesh& m, long e) {
  const Vec3 c = centre_of(m, at(e));
  const Vec2 uv = m.unfolded.empty() ? Vec2::Zero() : m.unfolded[at(m.tets[at(e)][0])];
  return fmt::format("element {} at ({:.2f}, {:.2f}, {:.2f}) mm, unfolded ({:.2f}, {:.2f}) mm", e, c.x(), c.y(), c.z(), uv.x(),
                     uv.y());
}

double volume(const LeafletMesh& m, std::size_t e) {
  const auto& t = m.tets[e];
  const Vec3 &a = m.points[at(t[0])], &b = m.points[at(t[1])], &c = m.points[at(t[2])], &d = m.points[at(t[3])];
  return (b - a).dot((c - a).cross(d - a)) / 6;
}

/// Smallest Jacobian determinant over the ten nodes, over 6 times the volume of the straight element (1 for straight edges).
double smallest_quadratic_jacobian(const LeafletMesh& m, std::size_t e) {
  constexpr std::array<std::array<double, 4>, 10> nodes{{{1, 0, 0, 0},
                                                         {0, 1, 0, 0},
                                                         {0, 0, 1, 0},
                                                         {0, 0, 0, 1},
                                                         {.5, .5, 0, 0},
                                                         {0, .5, .5, 0},
                                                         {.5, 0, .5, 0},
                                                         {.5, 0, 0, .5},
                                                         {0, .5, 0, .5},
                                                         {0, 0, .5, .5}}};
  double smallest = 1e300;
  for (const auto& l : nodes) {
    // dx/dl_i with N_i = l_i (2 l_i - 1), N_ij = 4 l_i l_j
    std::array<Vec3, 4> d{};
    for (std::size_t i = 0; i < 4; ++i) d[i] = (4 * l[i] - 1) * m.points[at(m.tets[e][i])];
    for (std::size_t k = 0; k < 6; ++k) {
      const auto [i, j] = tet_edges[k];
      const Vec3& x = m.points[at(m.tets[e][4 + k])];
      d[i] += 4 * l[j] * x;
      d[j] += 4 * l[i] * x;
    }
    Mat3 J;
    J << d[1] - d[0], d[2] - d[0], d[3] - d[0];
    smallest = std::min(smallest, J.determinant());
  }
  return smallest / (6 * volume(m, e));
}

/// Level of each corner node: 0 on the atrial face to the number of layers on the ventricular face.
std::vector<int> levels(const LeafletMesh& m) {
  std::vector<int> level(m.points.size(), 0);
  for (std::size_t e = 0; e < m.tets.size(); ++e)
    for (std::size_t k = 0; k < 4; ++k) {
      const int v = m.tets[e][k];
      const int l = m.layer[e] + (m.side[at(v)] == ventricular ? 1 : 0);
      level[at(v)] = std::max(level[at(v)], l);
    }
  return level;
}

}  // namespace

bool GateReport::passed() const {
  return std::all_of(gates.begin(), gates.end(), [](const Gate& g) { return g.passed; });
}

std::string GateReport::failures() const {
  std::string text;
  for (const Gate& g : gates)
    if (!g.passed)
      text += fmt::format("{}: {:.6g} {} (must be {} {:.6g}): {}\n", g.name, g.value, g.unit, g.relation, g.limit, g.message);
  return text;
}

nlohmann::json to_json(const GateReport& report) {
  nlohmann::json gates = nlohmann::json::array();
  for (const Gate& g : report.gates)
    gates.push_back({{"name", g.name},
                     {"verdict", g.passed ? "pass" : "fail"},
                     {"value", g.value},
                     {"limit", g.limit},
                     {"relation", g.relation},
                     {"unit", g.unit},
                     {"worst_element", g.worst_element},
                     {"message", g.message}});
  return {{"passed", report.passed()}, {"gates", gates}};
}

std::array<double, 6> dihedral_angles(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const std::array<const Vec3*, 4> x{&a, &b, &c, &d};
  // edge (i, j) with the two remaining corners (k, l)
  constexpr std::array<std::array<std::size_t, 4>, 6> edges{
      {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}}};
  std::array<double, 6> angles{};
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j, k, l] = edges[e];
    const Vec3 axis = *x[j] - *x[i];
    const Vec3 p = axis.cross(*x[k] - *x[i]), q = axis.cross(*x[l] - *x[i]);
    angles[e] = std::atan2(p.cross(q).norm(), p.dot(q)) * 180 / std::acos(-1.0);
  }
  return angles;
}

Gate gate_boundary(const LeafletMesh& m) {
  Gate g{"leaflets.boundary_open_edges", false, 0, 0, "==", "edges", -1, ""};
  const BoundarySurface b = extract_boundary(m);
  std::map<std::pair<int, int>, int> directed;
  std::map<std::pair<int, int>, int> triangle_of;
  for (std::size_t t = 0; t < b.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::pair<int, int> edge{b.triangles[t][k], b.triangles[t][(k + 1) % 3]};
      ++directed[edge];
      triangle_of[edge] = static_cast<int>(t);
    }
  long bad = 0;
  for (const auto& [edge, count] : directed) {
    const auto back = directed.find({edge.second, edge.first});
    if (count == 1 && back != directed.end() && back->second == 1) continue;
    if (bad++ == 0) g.worst_element = b.element[at(triangle_of[edge])];
  }
  double enclosed = 0, sum = 0;
  for (const auto& t : b.triangles) enclosed += m.points[at(t[0])].dot(m.points[at(t[1])].cross(m.points[at(t[2])])) / 6;
  for (std::size_t e = 0; e < m.tets.size(); ++e) sum += volume(m, e);
  g.value = static_cast<double>(bad);
  const bool volumes_agree = std::abs(enclosed - sum) <= 1e-8 * std::abs(sum) && enclosed > 0;
  g.passed = bad == 0 && volumes_agree && !b.triangles.empty();
  if (g.passed)
    g.message = fmt::format("closed and oriented boundary of {} triangles enclosing {:.3f} mm3", b.triangles.size(), enclosed);
  else if (b.triangles.empty())
    g.message = "the mesh has no boundary";
  else if (bad > 0)
    g.message = fmt::format("{} directed boundary edges are not matched by exactly one opposite edge, first at {}", bad,
                            place(m, g.worst_element));
  else
    g.message = fmt::format("the boundary encloses {:.6f} mm3 but the elements hold {:.6f} mm3", enclosed, sum);
  return g;
}

Gate gate_volumes(const LeafletMesh& m) {
  Gate g{"leaflets.volume_min", false, 1e300, 0, ">=", "mm3", -1, ""};
  double total = 0, jacobian = 1;
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const double v = volume(m, e);
    total += v;
    if (m.order == 2 && v > 0) jacobian = std::min(jacobian, smallest_quadratic_jacobian(m, e));
    if (!(v >= g.value)) {
      g.value = v;
      g.worst_element = static_cast<long>(e);
    }
  }
  g.passed = !m.tets.empty() && g.value > 0 && jacobian > 0;
  g.message = g.passed         ? fmt::format("{} elements, {:.3f} mm3 in all, all positive", m.tets.size(), total)
              : m.tets.empty() ? "the mesh has no elements"
                               : fmt::format("inverted or flat: {} has {:.3e} mm3", place(m, g.worst_element), g.value);
  if (m.order == 2) g.message += fmt::format("; smallest relative Jacobian at the nodes {:.4f}", jacobian);
  return g;
}

namespace {

Gate gate_dihedral(const LeafletMesh& m, double limit, bool smallest) {
  Gate g{smallest ? "leaflets.dihedral_min" : "leaflets.dihedral_max",
         false,
         smallest ? 180.0 : 0.0,
         limit,
         smallest ? ">=" : "<=",
         "deg",
         -1,
         ""};
  long beyond = 0;
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const auto& t = m.tets[e];
    const auto angles = dihedral_angles(m.points[at(t[0])], m.points[at(t[1])], m.points[at(t[2])], m.points[at(t[3])]);
    const double angle =
        smallest ? *std::min_element(angles.begin(), angles.end()) : *std::max_element(angles.begin(), angles.end());
    if (!(smallest ? angle >= limit : angle <= limit)) ++beyond;
    if (!(smallest ? angle >= g.value : angle <= g.value)) {
      g.value = angle;
      g.worst_element = static_cast<long>(e);
    }
  }
  g.passed = !m.tets.empty() && beyond == 0;
  g.message = m.tets.empty() ? "the mesh has no elements"
                             : fmt::format("{} dihedral angle {:.2f} degrees in {}", smallest ? "smallest" : "largest", g.value,
                                           place(m, std::max(0L, g.worst_element)));
  if (beyond > 0) g.message += fmt::format("; {} elements beyond the limit (slivers)", beyond);
  return g;
}

}  // namespace

Gate gate_dihedral_min(const LeafletMesh& m, double limit) { return gate_dihedral(m, limit, true); }
Gate gate_dihedral_max(const LeafletMesh& m, double limit) { return gate_dihedral(m, limit, false); }

Gate gate_layers(const LeafletMesh& m, int layers) {
  Gate g{"leaflets.layers", false, 1e300, static_cast<double>(layers), "==", "layers", -1, ""};
  // Faces shared by two elements lead from one to the other; from each atrial face triangle all elements of its column are
  // reached through elements whose corners project on the same three columns of nodes (same unfolded position).
  const BoundarySurface b = extract_boundary(m);
  std::map<std::pair<double, double>, int> column_of;
  std::vector<int> column(m.points.size());
  for (std::size_t i = 0; i < m.points.size(); ++i)
    column[i] = column_of.try_emplace({m.unfolded[i].x(), m.unfolded[i].y()}, static_cast<int>(column_of.size())).first->second;
  std::map<std::array<int, 3>, std::set<int>> layers_of;
  std::map<std::array<int, 3>, bool> reaches_ventricle;
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    std::set<int> columns;
    for (std::size_t k = 0; k < 4; ++k) columns.insert(column[at(m.tets[e][k])]);
    if (columns.size() != 3) continue;
    std::array<int, 3> key{};
    std::copy(columns.begin(), columns.end(), key.begin());
    layers_of[key].insert(m.layer[e]);
    for (std::size_t k = 0; k < 4; ++k)
      if (m.side[at(m.tets[e][k])] == ventricular) reaches_ventricle[key] = true;
  }
  long checked = 0, wrong = 0;
  for (std::size_t t = 0; t < b.triangles.size(); ++t) {
    std::array<int, 3> key{};
    bool is_atrial = true;
    for (std::size_t k = 0; k < 3; ++k) {
      is_atrial = is_atrial && m.side[at(b.triangles[t][k])] == atrial;
      key[k] = column[at(b.triangles[t][k])];
    }
    if (!is_atrial) continue;
    ++checked;
    std::sort(key.begin(), key.end());
    const double count = reaches_ventricle[key] ? static_cast<double>(layers_of[key].size()) : 0;
    if (count < g.value) g.value = count;
    if (count != layers && wrong++ == 0) g.worst_element = b.element[t];
  }
  if (checked == 0) g.value = 0;
  g.passed = checked > 0 && wrong == 0;
  g.message = g.passed       ? fmt::format("{} layers under each of {} atrial triangles", layers, checked)
              : checked == 0 ? "no triangle of the boundary lies on the atrial face"
                             : fmt::format("{} of {} atrial triangles do not have {} layers, first at {}", wrong, checked, layers,
                                           place(m, g.worst_element));
  return g;
}

Gate gate_spacing(const LeafletMesh& m, double fluid_spacing, double tolerance) {
  Gate g{"leaflets.spacing_max", false, 0, tolerance * 0.5 * fluid_spacing, "<=", "mm", -1, ""};
  const std::vector<int> level = levels(m);
  std::vector<double> lengths;
  std::set<std::pair<int, int>> done;
  double longest = 0;
  const double share = m.order == 2 ? 0.5 : 1.0;  // a mid-edge node halves the distance between neighbouring solid points
  for (std::size_t e = 0; e < m.tets.size(); ++e)
    for (const auto& [i, j] : tet_edges) {
      const int a = m.tets[e][i], b = m.tets[e][j];
      if (!done.insert({std::min(a, b), std::max(a, b)}).second) continue;
      const double d = share * (m.points[at(a)] - m.points[at(b)]).norm();
      longest = std::max(longest, d);
      const bool diagonal = level[at(a)] != level[at(b)] && m.unfolded[at(a)] != m.unfolded[at(b)];
      if (diagonal) continue;
      lengths.push_back(d);
      if (d > g.value) {
        g.value = d;
        g.worst_element = static_cast<long>(e);
      }
    }
  if (lengths.empty()) {
    g.message = "the mesh has no elements";
    return g;
  }
  const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(lengths.size() - 1));
  std::nth_element(lengths.begin(), lengths.begin() + rank, lengths.end());
  g.passed = g.value <= g.limit * (1 + 1e-9);  // thickness/layers may equal the limit up to rounding
  g.message = fmt::format(
      "longest distance between neighbouring solid points {:.4f} mm (99.9th percentile {:.4f}, with prism diagonals {:.4f}) "
      "against half the "
      "fluid spacing of {:.4f} mm",
      g.value, lengths[at(rank)], longest, fluid_spacing);
  if (!g.passed)
    g.message += "; worst " + place(m, g.worst_element) + "; lower mesh.spacing, or raise mesh.layers if the thickness sets it";
  return g;
}

double spanning_step(const std::array<Vec3, 4>& p) {
  const auto length = [&](std::size_t i, std::size_t j) { return (p[i] - p[j]).norm(); };
  // Prim's tree from point 0.
  std::array<double, 4> nearest{0, length(0, 1), length(0, 2), length(0, 3)};
  std::array<bool, 4> is_in{true, false, false, false};
  double longest = 0;
  for (int step = 0; step < 3; ++step) {
    std::size_t next = 0;
    for (std::size_t k = 1; k < 4; ++k)
      if (!is_in[k] && (next == 0 || nearest[k] < nearest[next])) next = k;
    is_in[next] = true;
    longest = std::max(longest, nearest[next]);
    for (std::size_t k = 1; k < 4; ++k)
      if (!is_in[k]) nearest[k] = std::min(nearest[k], length(next, k));
  }
  return longest;
}

Gate gate_spacing_unlayered(const LeafletMesh& m, double fluid_spacing, double tolerance) {
  Gate g{"leaflets.spacing_max", false, 0, tolerance * 0.5 * fluid_spacing, "<=", "mm", -1, ""};
  const double share = m.order == 2 ? 0.5 : 1.0;
  double longest = 0;
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const auto length = [&](std::size_t i, std::size_t j) { return share * (m.points[at(m.tets[e][i])] - m.points[at(m.tets[e][j])]).norm(); };
    for (const auto& [i, j] : tet_edges) longest = std::max(longest, length(i, j));
    const double step = share * spanning_step({m.points[at(m.tets[e][0])], m.points[at(m.tets[e][1])], m.points[at(m.tets[e][2])], m.points[at(m.tets[e][3])]});
    if (step > g.value) {
      g.value = step;
      g.worst_element = static_cast<long>(e);
    }
  }
  if (m.tets.empty()) {
    g.message = "the mesh has no elements";
    return g;
  }
  g.passed = g.value <= g.limit * (1 + 1e-9);
  g.message = fmt::format("the corners of every element are joined by steps of at most {:.4f} mm (longest edge {:.4f}) against half the fluid spacing of {:.4f} mm", g.value, longest, fluid_spacing);
  if (!g.passed) g.message += "; worst " + place(m, g.worst_element) + "; lower mesh.spacing";
  return g;
}

Gate gate_fibres(const LeafletMesh& m) {
  Gate g{"leaflets.fibre_defect", false, 0, 1e-6, "<=", "", -1, ""};
  if (m.fibre.size() != m.tets.size() || m.sheet_normal.size() != m.tets.size()) {
    g.value = 1;
    g.message =
        fmt::format("{} fibres and {} sheet normals for {} elements", m.fibre.size(), m.sheet_normal.size(), m.tets.size());
    return g;
  }
  bool finite = true;
  for (std::size_t e = 0; e < m.tets.size(); ++e) {
    const Vec3 &f = m.fibre[e], &n = m.sheet_normal[e];
    double defect = 1e300;
    if (f.allFinite() && n.allFinite())
      // Unit length is held to 1e-9; scaled so that one limit serves both.
      defect = std::max({std::abs(f.norm() - 1) * 1e3, std::abs(n.norm() - 1) * 1e3, std::abs(f.dot(n))});
    else
      finite = false;
    if (defect > g.value) {
      g.value = defect;
      g.worst_element = static_cast<long>(e);
    }
  }
  g.passed = !m.tets.empty() && g.value <= g.limit;
  g.message = g.passed         ? "every fibre is unit, finite and tangent to the mid-surface"
              : !finite        ? "a fibre is not finite: " + place(m, g.worst_element)
              : m.tets.empty() ? "the mesh has no elements"
                               : fmt::format("fibre not unit (1e-9) or not tangent (1e-6): {}", place(m, g.worst_element));
  return g;
}

std::vector<Gate> gate_insertions(const LeafletMesh& m, const Chordae& c) {
  Gate sums{"chordae.insertion_sum_error", false, 0, 1e-9, "<=", "", -1, ""};
  Gate faces{"chordae.insertion_one_sided", false, 0, 0, "==", "ends", -1, ""};
  struct End {
    double sum = 0;
    bool atrial = false, ventricular = false;
  };
  std::map<int, End> ends;
  std::string fault;
  for (const Insertion& i : c.insertions) {
    if (i.node < 0 || at(i.node) >= m.points.size() || i.point < 0 || at(i.point) >= c.points.size()) {
      fault = fmt::format("insertion of chordae point {} refers to leaflet node {}, which does not exist", i.point, i.node);
      sums.worst_element = i.point;
      continue;
    }
    if (!(i.weight > 0) || !std::isfinite(i.weight)) {
      fault = fmt::format("chordae point {} has the weight {} at leaflet node {}", i.point, i.weight, i.node);
      sums.worst_element = i.point;
    }
    End& end = ends[i.point];
    end.sum += i.weight;
    end.atrial = end.atrial || m.side[at(i.node)] == atrial;
    end.ventricular = end.ventricular || m.side[at(i.node)] == ventricular;
  }
  long one_sided = 0;
  for (const auto& [point, end] : ends) {
    const double error = std::abs(end.sum - 1);
    if (!(error <= sums.value)) {
      sums.value = error;
      if (fault.empty()) sums.worst_element = point;
    }
    if ((!end.atrial || !end.ventricular) && one_sided++ == 0) faces.worst_element = point;
  }
  // Every leaf of the trees (a point b that starts no segment) hangs on the leaflet.
  std::set<int> starts;
  for (const ChordaSegment& s : c.segments) starts.insert(s.a);
  for (const ChordaSegment& s : c.segments)
    if (!starts.contains(s.b) && !ends.contains(s.b) && fault.empty()) {
      fault = fmt::format("chordae point {} ends at the leaflet but has no insertion", s.b);
      sums.worst_element = s.b;
    }
  sums.passed = fault.empty() && sums.value <= sums.limit;
  sums.message = !fault.empty()
                     ? fault
                     : fmt::format("{} leaflet ends, largest error of the sum of weights {:.2e}", ends.size(), sums.value);
  faces.value = static_cast<double>(one_sided);
  faces.passed = one_sided == 0;
  faces.message = faces.passed ? "every leaflet end holds nodes of both faces"
                               : fmt::format("{} leaflet ends hold nodes of one face only, first chordae point {}", one_sided,
                                             faces.worst_element);
  return {sums, faces};
}

GateReport check_leaflets(const LeafletMesh& m, const GateLimits& limits) {
  GateReport r;
  r.gates = {gate_boundary(m), gate_volumes(m), gate_dihedral_min(m, limits.dihedral_min),
             gate_dihedral_max(m, limits.dihedral_max)};
  const bool has_layers = limits.layers > 0;
  if (has_layers) r.gates.push_back(gate_layers(m, limits.layers));
  if (limits.fluid_spacing > 0) r.gates.push_back(has_layers ? gate_spacing(m, limits.fluid_spacing, limits.spacing_tolerance) : gate_spacing_unlayered(m, limits.fluid_spacing, limits.spacing_tolerance));
  r.gates.push_back(gate_fibres(m));
  return r;
}

}  // namespace mv
