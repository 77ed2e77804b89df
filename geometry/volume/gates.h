// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Quality gates with numbers, written to quality.json. A gate never throws: it reports; the pipeline stops on a failed one.

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct Gate {
  std::string name;  // e.g. "leaflets.dihedral_min_deg"
  bool passed = false;
  double value = 0;
  double limit = 0;
  std::string relation;  // how value relates to limit when passed: ">=", "<=", "=="
  std::string unit;
  long worst_element = -1;  // element, triangle or point index as the message says; -1 none
  std::string message;      // one sentence: what was measured, and on failure which element, where and why
};

struct GateReport {
  std::vector<Gate> gates;
  bool passed() const;
  std::string failures() const;  // one line per failed gate, empty when passed
};
/// {"passed": bool, "gates": [{name, verdict: "pass"|"fail", value, limit, relation, unit, worst_element, message}]}
nlohmann::json to_json(const GateReport& report);

/// Outward boundary of a tetrahedral mesh.
struct BoundarySurface {
  std::vector<std::array<int, 3>> triangles;  // corner nodes, outward
  std::vector<std::array<int, 6>> quadratic;  // order 2: corners, then midpoints of edges 01 12 20; else empty
  std::vector<int> element;                   // tetrahedron behind each triangle
};
BoundarySurface extract_boundary(const LeafletMesh& mesh);
/// Boundary as flat triangles: 1 per face (linear) or 4 (quadratic).
std::vector<std::array<int, 3>> boundary_facets(const BoundarySurface& boundary);

struct GateLimits {
  double dihedral_min = 10;   // degrees
  double dihedral_max = 170;  // degrees
  int layers = 2;             // 0: a mesh without layers: leaves the layers gate out, and the spacing gate takes gate_spacing_unlayered
  double fluid_spacing = 0;        // mm; 0 leaves the spacing gate out
  double spacing_tolerance = 1.0;  // gate: longest structural edge <= tolerance * fluid_spacing / 2
};

/// Every directed edge of the boundary is matched once by its opposite (closed, oriented, manifold edges), enclosed volume
/// positive and equal to the sum of the elements.
Gate gate_boundary(const LeafletMesh& mesh);
/// Signed volume of every tetrahedron; order 2: also the smallest Jacobian determinant at the corners and midpoints.
Gate gate_volumes(const LeafletMesh& mesh);
Gate gate_dihedral_min(const LeafletMesh& mesh, double limit);
Gate gate_dihedral_max(const LeafletMesh& mesh, double limit);
/// Counts, for every triangle of the atrial face, the elements' layers met on the way through to the ventricular face.
Gate gate_layers(const LeafletMesh& mesh, int layers);
/// Structural edge: edge within a level or straight through the thickness (diagonals of the prisms are left out, since both their
/// ends have nearer neighbours). Order 2 halves the edges. Value: the longest; the message adds the 99.9th percentile and the
/// longest edge of all.
Gate gate_spacing(const LeafletMesh& mesh, double fluid_spacing, double tolerance);
/// For any tetrahedra: the corners of every element are joined by steps no longer than the value (the longest edge of each element's shortest spanning tree, the largest of all). Same
/// name and limit. Order 2 halves the edges.
Gate gate_spacing_unlayered(const LeafletMesh& mesh, double fluid_spacing, double tolerance);
/// Longest edge of the shortest spanning tree of four points.
double spanning_step(const std::array<Vec3, 4>& points);
/// |fibre| = 1 and |sheet_normal| = 1 within 1e-9, finite, |fibre . sheet_normal| <= 1e-6.
Gate gate_fibres(const LeafletMesh& mesh);
/// Weights of each leaflet end positive and summing to one within 1e-9; nodes in range and from both faces (side +1 and -1).
std::vector<Gate> gate_insertions(const LeafletMesh& mesh, const Chordae& chordae);

/// All gates of the leaflet mesh alone.
GateReport check_leaflets(const LeafletMesh& mesh, const GateLimits& limits);

/// Dihedral angles (degrees) of a tetrahedron at edges 01 02 03 12 13 23.
std::array<double, 6> dihedral_angles(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace mv
