// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Meshes for plane problems in a slab that is periodic in y. SI units; node arrays are xyz interleaved.
//
// The solver knows no periodic tissue. Here the nodes of the last plane repeat those of the first: their forces are added to the
// first's, they do not take part in the coupling, and they follow it. Nodes keep their y (plane strain).

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "geometry/core/parallel.h"
#include "solver/contact/self_contact.h"
#include "solver/fluid/grid.h"
#include "solver/solid/leaflet_solid.h"

namespace mv::test {

/// One thread as long as it lives: these problems are too small for more.
class OneThread {
 public:
  OneThread() { set_thread_count(1); }
  ~OneThread() { set_thread_count(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_ = thread_count();
};

/// Box of (nx, columns, nz) cells of a tissue; node(i, j, k) counts along x, y, z.
struct Plate {
  int first = 0, nx = 0, nz = 0, columns = 0;
  int node(int i, int j, int k) const { return first + i + (nx + 1) * (j + (columns + 1) * k); }
};

struct Range {
  double low, high;  // m
};

struct SlabTissue {
  double depth = 0;  // m, period along y
  int columns = 0;   // cells along y
  SolidMesh mesh;
  std::vector<int> side;      // per node: mv::Side
  std::vector<char> is_held;  // per node
  std::vector<int> repeats;   // per node: the node of the first plane it repeats, or itself

  int node_count() const { return static_cast<int>(side.size()); }
  bool is_copy(int node) const { return repeats[static_cast<std::size_t>(node)] != node; }
  /// Appends a box of nx * columns * nz cells, six linear tetrahedra each; sides are `between`, nothing is held.
  Plate add_plate(Range x, int nx, Range z, int nz);
  /// Turns every linear tetrahedron into a quadratic one with straight edges. All nodes that share x and z repeat one of them: in the plane these are
  /// six-node triangles. The plates' node() goes on naming corners. Not for drainage (share_with_copies() knows one copy a node).
  void make_quadratic();
  /// The node (no copy) nearest to a point of the plane (m).
  int nearest_node(double x, double z) const;
  /// Adds the copies' entries to the nodes they repeat and sets them to zero. 3 per node; further entries are left alone.
  void gather_copies(std::vector<double>& array) const;
  /// The reverse: shares the entries with the copies by volume (m3, one per node).
  void share_with_copies(std::span<const double> volumes, std::vector<double>& array) const;
  /// Positions and velocities of the copies follow; every node returns to its plane.
  void follow_first_plane(std::vector<double>& x, std::vector<double>& v) const;
};

/// Atrial faces only: the rims at the slab's border are no surface.
ContactSurface facing_surface(const SlabTissue& tissue);

/// Contact with the options of a case.
std::unique_ptr<SelfContact> make_contact(const ContactSurface& surface, const ContactOptions& options);

/// Points (xyz) that fill a rectangle of the slab with at most `spacing` between neighbours, corners included; nodes for
/// Coupling::hold.
std::vector<double> block_points(Range x, Range z, double spacing, double depth, int columns);

/// A grid over x and z (lengths must be multiples of h) that is `cells_deep` cells deep; y from 0.
FluidGrid slab_grid(Range x, Range z, double h, int cells_deep);

}  // namespace mv::test
