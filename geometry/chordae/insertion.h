// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Influence spheres (papers/s0, 2.1 "Chordae"): a chorda's force enters the leaflet through all nodes near its end, on both faces
// and between them, with weights that decrease gradually, instead of through one node or one face (which shears the leaflet).
//
//   weights   w0_i = V_i (1 - (d_i/R)^2)^2 / sum,  d_i < R
//             V_i nodal volume (lumped), d_i distance along the leaflet from the target
//   end       x_e = sum w_i x_i. Left open, it is the centroid of w0; given, the weights are corrected:
//             min sum (w_i - w0_i)^2 / w0_i   subject to   sum w_i = 1,  sum w_i (x_i - x_e) = 0,  w_i >= 0
//             whose solution w_i = w0_i (1 + a + b.(x_i - x_e)) still falls to zero at the rim.
// A force F at the end becomes w_i F at the nodes: its sum is F, and its moment about the end is (sum w_i (x_i - x_e)) x F = 0,
// exactly. With V_i in the weight, force over mass decreases with distance whatever the local mesh size.

#include <optional>
#include <utility>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Node neighbourhoods of the leaflets, made once and used for every insertion. Keeps a reference to the mesh.
class LeafletGraph {
 public:
  /// Throws InputError when the mesh is empty or an array has the wrong size.
  explicit LeafletGraph(const LeafletMesh& mesh);

  struct Reached {
    int node = -1;
    double distance = 0;  // mm, along the leaflet
  };

  /// Nodes whose distance along the leaflet from `target` (mm, in or next to the tissue) is below `radius`, by ascending node.
  /// The distance is the shortest path in the graph that joins every node to those at most four elements (two quadratic
  /// ones) away by straight lines, except where the way along edges is over 1.75 times longer; so it goes round the gap
  /// between two scallops instead of across. On a flat patch it is at most 4.5 % long (beyond six edges 3 %). The tissue
  /// near `target` is that of the node nearest to it. Empty when that node is further than `radius`.
  std::vector<Reached> within(const Vec3& target, double radius) const;

  const LeafletMesh& mesh() const { return *mesh_; }
  double nodal_volume(int node) const { return volume_[static_cast<std::size_t>(node)]; }  // mm3

 private:
  const LeafletMesh* mesh_;
  std::vector<int> neighbour_begin_, neighbours_;
  std::vector<double> volume_;
};

struct InfluenceSphere {
  Vec3 end = Vec3::Zero();                      // mm, = sum of weight * node position
  std::vector<std::pair<int, double>> weights;  // node, weight > 0; ascending node
};

/// Weights of one leaflet end. `target` mm: centre of the sphere; `radius` mm; `end` mm: where the chorda shall end (default:
/// centroid). Throws InputError when no node is reached, when one face only is reached, or when `end` is not within the reached
/// nodes.
InfluenceSphere influence_sphere(const LeafletGraph& graph, const Vec3& target, double radius,
                                 std::optional<Vec3> end = std::nullopt);

/// Default radius R (mm) of an unbranched chorda: half its share of the free border, so that neighbouring spheres just meet, but
/// no more than 3/4 of the leaflet's height there, so that the sphere stays clear of the annulus:
///   R = min( border_length / (2 primary_count), 0.75 height ).     Ends of bifurcated chordae use R/2.
double influence_radius(double border_length, int primary_count, double height);

/// Largest |sum w - 1|, largest |sum w x - point| (mm), smallest weight, and whether each end has both faces; for the gate.
struct InsertionReport {
  int ends = 0;
  double sum_error_max = 0;
  double position_error_max = 0;
  double weight_min = 0;
  int nodes_min = 0;
  int ends_on_one_face = 0;
  int first_bad_point = -1;
  bool passed = false;
};
InsertionReport check_insertions(const LeafletMesh& mesh, const Chordae& chordae, double tolerance = 1e-9);

}  // namespace mv
