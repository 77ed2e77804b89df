// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Harmonic depth inside a thick sheet: Laplace's equation with 0 and 1 on the faces and no flux through the rims, |s| < 0.9 (Jones,
// Buchbinder, Aharon 2000; values where the grid lines cross the faces: Gibou, Fedkiw, Cheng, Kang 2002, second order). Internal to
// mid_surface_of_solid and the thick path.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/surface/solid_faces.h"

namespace mv {

struct LevelSurface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;  // normal towards larger depth
};

/// A sheet's local thickness: the field line through a point, from face to face.
struct FieldLine {
  double to_lower = 0, to_upper = 0;            // mm, arc length to the faces s = -1 and s = +1
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();
  bool ends_on_faces = false;                   // false: an end lies on a rim or was not reached
};

class SolidDepth {
 public:
  /// Grid spacing `voxel` (mm), made coarser when more than max_voxels would lie inside; volume in mm3. Throws InputError when the
  /// grid does not see the solid (thinner than the grid everywhere).
  SolidDepth(const SolidFaces& faces, double volume, double voxel, long max_voxels);

  double voxel() const { return h_; }
  long voxels() const { return inside_count_; }
  int iterations() const { return iterations_; }

  /// 0 on the face s = -1, 1 on the face s = +1, continued linearly about two voxels beyond the surface; nothing further out.
  std::optional<double> depth(const Vec3& x) const { return sample(depth_, x); }
  /// Signed distance to the surface near it (mm, positive outside), -voxel deeper inside.
  std::optional<double> outside(const Vec3& x) const { return sample(outside_, x); }
  Vec3 gradient(const Vec3& x) const;

  /// Surface of equal depth, ending where it meets the solid's surface.
  LevelSurface level(double value) const;
  /// x moved along the gradient to the given depth; unchanged when that fails.
  Vec3 to_level(const Vec3& x, double value) const;
  FieldLine field_line(const Vec3& x) const;
  /// Point at the signed arc length along the field line (positive towards s = +1).
  Vec3 along_line(const Vec3& x, double length) const;

 private:
  struct Crossing {
    double position;
    double value;
    int step;  // winding number's change when crossed upwards
  };
  using Index = std::array<int, 3>;
  struct Link {
    int node = -1;         // inside neighbour, or -1
    float fraction = 2;    // distance of the surface in voxels, 2: none
    float value = 0;       // depth prescribed there
    bool is_free = false;  // no flux: a rim, or overlapping sheets
  };

  void collect_crossings(const SolidFaces& faces);
  void mark_inside();
  void link_nodes();
  void solve();
  void extrapolate();
  int node_at(const Index& i) const;
  int add_node(const Index& i);
  Vec3 position(const Index& i) const { return lower_ + h_ * Vec3(i[0], i[1], i[2]); }
  std::optional<double> sample(const std::vector<double>& values, const Vec3& x) const;
  std::optional<Vec3> walk(Vec3 x, double direction, double target, double length_limit, double& length) const;

  double h_ = 0;
  Vec3 lower_ = Vec3::Zero();
  Index cells_{};                                  // nodes along each axis
  Index blocks_{};
  std::array<std::vector<std::vector<Crossing>>, 3> lines_;
  std::vector<int> block_;                         // per block of 8 x 8 x 8 nodes: index into slots_, or -1
  std::vector<std::array<int, 512>> slots_;        // node numbers, -1
  std::vector<Index> nodes_;                       // inside ones first
  int inside_count_ = 0;
  std::vector<std::array<Link, 6>> links_;         // inside nodes: -x +x -y +y -z +z
  std::vector<double> depth_, outside_;
  int iterations_ = 0;
};

}  // namespace mv
