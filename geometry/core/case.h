// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The case: everything mvprep hands to mvsolve, as plain data. Lengths in mm, RAS frame, as in the files.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace mv {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

enum Region : int { posterior = 1, anterior = 2 };
enum Side : int { ventricular = -1, between = 0, atrial = 1 };

/// Tetrahedral leaflets (mm). `tets` holds 4 (linear) or 10 (quadratic, VTK ordering: corners 0-3, then the midpoints of
/// edges 01 12 02 03 13 23) point indices per element; unused entries of a linear element are -1.
struct LeafletMesh {
  int order = 1;
  std::vector<Vec3> points;
  std::vector<std::array<int, 10>> tets;
  // one entry per element
  std::vector<int> region;          // Region
  std::vector<int> layer;           // 0 at the atrial face, counting towards the ventricular face
  std::vector<Vec3> fibre;          // unit
  std::vector<Vec3> sheet_normal;   // unit, through the thickness, towards the atrial face
  // one entry per point
  std::vector<char> on_annulus;
  std::vector<char> on_free_edge;
  std::vector<int> side;            // Side
  std::vector<Vec2> unfolded;       // (u, v) mm on the flat pattern: u along the annulus, v from the annulus to the free edge

  int nodes_per_tet() const { return order == 2 ? 10 : 4; }
};

enum class ChordaKind : int { primary = 0, secondary = 1, strut = 2, basal = 3, marginal = 4 };

struct ChordaSegment {
  int a = -1;              // point nearer to the papillary muscle
  int b = -1;              // point nearer to the leaflet
  ChordaKind kind = ChordaKind::primary;
  int muscle = 0;          // index of the papillary tip the tree hangs on
  int leaflet = 0;         // Region of the leaflet end
  double rest_length = 0;  // mm
  double area = 0;         // mm2
};

/// A share of a leaflet-end point: that point sits at sum(weight * x_node) and hands its force back with the same weights.
struct Insertion {
  int point = -1;
  int node = -1;
  double weight = 0;
};

/// Chordae trees with shared branch points (mm).
struct Chordae {
  std::vector<Vec3> points;
  std::vector<int> muscle_of_point;   // papillary tip index for a root point, else -1
  std::vector<ChordaSegment> segments;
  std::vector<Insertion> insertions;  // grouped by point; weights of one point sum to one
};

/// Annulus curve with its plane. `normal` points from the atrium to the ventricle.
struct Annulus {
  std::vector<Vec3> points;           // closed, ordered, last point not repeated
  Vec3 origin = Vec3::Zero();
  Vec3 normal = -Vec3::UnitZ();
  Vec3 axis_major = Vec3::UnitX();
  double residual_rms = 0;            // mm, distance of the points from the plane
  Vec3 eigenvalues = Vec3::Zero();    // mm2, descending
  std::string sign_rule;              // which rule chose the direction of the normal
};

/// Blood tube: the annulus' own cross-section extruded along its normal, and the fluid grid around it.
/// Tube frame: x_tube = axes * (x_world - origin); rows of `axes` are e1, e2 (in the annulus plane) and e3, which points from the
/// ventricle to the atrium (= -annulus normal).
struct Tube {
  Vec3 origin = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
  std::vector<Vec2> cross_section;    // closed counter-clockwise polygon in (e1, e2), mm
  double z_ventricle = 0;             // mm, end where the ventricular pressure acts
  double z_atrium = 0;                // mm, end where the atrial pressure acts
  // fluid grid (cell-centred box of cubes), lower corner in the tube frame
  Vec3 grid_lower = Vec3::Zero();     // mm
  std::array<int, 3> grid_cells{0, 0, 0};
  double grid_spacing = 0;            // mm
  // body-fitted hexahedra (world frame), VTK ordering
  std::vector<Vec3> points;
  std::vector<std::array<int, 8>> hexes;
};

struct Papillary {
  std::vector<Vec3> tips;             // mm
  std::vector<std::string> names;     // "anterolateral", "posteromedial"
};

}  // namespace mv
