// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Grows single chordae and trees on a valve, with rest lengths from its closed shape. Used by the density model and by the layout
// search.

#include <map>
#include <optional>
#include <vector>

#include "geometry/chordae/coapted_shape.h"
#include "geometry/chordae/insertion.h"
#include "geometry/chordae/leaflet_chart.h"
#include "geometry/chordae/leaflet_probe.h"

namespace mv {

struct ChordaEnd {
  Vec2 centre_uv;  // middle of the influence sphere, on the pattern
  Vec2 end_uv;     // where the chorda ends
  double radius = 0;
};

class ChordaeGrower {
 public:
  struct Options {
    double slack = 1.0;
    double coaptation_depth = 5.0;  // mm
    double branch_angle = 40;       // degrees
    bool avoids_leaflets = true;
  };

  /// Throws InputError (mesh, fewer than two tips, tips on one side).
  ChordaeGrower(const LeafletMesh& mesh, const Annulus& annulus, const Papillary& papillary, const std::vector<Vec3>& heads, const Options& options);

  const LeafletChart& chart() const { return chart_; }
  const CoaptedShape& closed() const { return closed_; }

  /// A border end at an arc length of the border: sphere centred on the border, the end `inset` radii inside it.
  ChordaEnd border_end(double arc, double radius, double inset) const;

  /// Which muscle (tip) holds this end: the nearest of its half of the valve.
  int muscle_of(const ChordaEnd& end) const;

  enum class Outcome { grown, other_head, blocked };
  /// One chorda (one end) or a tree (several ends, in order) from one head, tried from the nearest on until none of its segments passes
  /// through a leaflet. `forced`: kept on the nearest head when all are blocked. Blocked and not forced: nothing is added.
  Outcome grow(const std::vector<ChordaEnd>& ends, ChordaKind kind, double area, bool forced);

  int radius_enlarged() const { return radius_enlarged_; }
  int trees() const { return trees_; }
  /// Points, segments, insertions so far.
  const Chordae& chordae() const { return out_; }

 private:
  struct Node {
    Vec3 closed = Vec3::Zero(), initial = Vec3::Zero();
    int left = -1, right = -1;  // children, -1 at a leaflet end
    int leaves = 1;
    double below = 0;           // mean closed length from here to the ends
    std::size_t end = 0;
  };
  int plan(const std::vector<InfluenceSphere>& spheres, const std::vector<Vec3>& closed, std::size_t begin, std::size_t stop, const Vec3& head, std::vector<Node>& nodes) const;
  void settle(std::vector<Node>& nodes, int node, const Vec3& parent_closed, const Vec3& parent_initial) const;
  bool is_blocked(const std::vector<Node>& nodes, int node, const Vec3& parent, double spared) const;
  int add_point(const Vec3& position, int muscle);
  void add_subtree(const std::vector<Node>& nodes, int node, int parent_point, const Vec3& parent_closed, const std::vector<int>& end_points, ChordaSegment proto, double area, int leaves);

  const LeafletMesh& mesh_;
  LeafletGraph graph_;
  LeafletChart chart_;
  LeafletProbe probe_;
  CoaptedShape closed_;
  Options options_;
  std::vector<Vec3> heads_;
  std::vector<int> muscle_of_head_;
  std::vector<int> half_of_muscle_;
  std::vector<Vec3> tips_;
  std::map<int, int> root_points_;  // head -> point
  Chordae out_;
  int radius_enlarged_ = 0, trees_ = 0;
};

}  // namespace mv
