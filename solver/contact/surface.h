// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The contact surface: oriented triangles on the boundary of the tetrahedra, with what contact needs to know about them.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace mv {

/// Which faces of the solid take part in contact: all of its boundary (rims included) or the atrial faces only.
enum class ContactFaces { both, inner };

/// Triangles index surface nodes; `nodes[s]` is the solid node of surface node s. All lengths in m, SI.
struct ContactSurface {
  int solid_nodes = 0;                        // size of the solid mesh: positions passed later hold 3 * solid_nodes numbers
  std::vector<int> nodes;                     // surface node -> solid node, ascending
  std::vector<std::array<int, 3>> triangles;  // surface nodes, counter-clockwise seen from outside the solid
  std::vector<int> triangle_side;             // +1 atrial face, -1 ventricular face, 0 rim (mv::Side)
  std::vector<char> on_atrial_face;           // per surface node: belongs to an atrial triangle
  std::vector<Eigen::Vector3d> reference;     // per surface node: rest position
  std::vector<int> node_side;          // per surface node: +1 if it has an atrial triangle, else -1 if a ventricular one, else 0
  std::vector<double> reference_area;  // per surface node: a third of the rest areas of its triangles of side node_side (m2), so
                                       // that nodes along a border do not count the rim to the face
  std::vector<int> ring_start, ring;   // per surface node: its triangles, ring[ring_start[s] .. ring_start[s+1])
  // Edges of the solid (tetrahedra included, when extracted from them) between solid nodes, both directions.
  std::vector<int> edge_start, edge_end;
  std::vector<Eigen::Vector3d> solid_reference;  // per solid node: rest position
  double mean_edge = 0;                          // m, mean rest edge length of the triangles

  int node_count() const { return static_cast<int>(nodes.size()); }
  int triangle_count() const { return static_cast<int>(triangles.size()); }
};

/// Extracts the boundary of a tetrahedral mesh.
/// `rest_positions`: xyz-interleaved, 3 * n (m). `tets`: 4 (order 1) or 10 (order 2, VTK ordering) used entries per element; the
/// orientation of the elements does not matter. `side`: per solid node (mv::Side); may be empty when `faces` is `both`. A face is
/// atrial (ventricular) when its three corners are. With order 2 each 6-node face becomes four triangles, so that mid nodes are
/// contact nodes. Throws InputError when the mesh has no such face, when an index is out of range or a face has more than two
/// owners.
ContactSurface extract_contact_surface(std::span<const double> rest_positions, std::span<const std::array<int, 10>> tets,
                                       int order, std::span<const int> side, ContactFaces faces);

/// A surface from oriented triangles over solid nodes (all of them atrial); for shells and tests. Solid edges are the triangles'
/// edges.
ContactSurface contact_surface_from_triangles(std::span<const double> rest_positions,
                                              std::span<const std::array<int, 3>> triangles);

/// Tributary area of each surface node in the current configuration (m2), counted as `reference_area`. `x`: 3 * solid_nodes;
/// `area`: node_count().
void current_tributary_areas(const ContactSurface& surface, std::span<const double> x, std::span<double> area);

/// Area-weighted outward unit normal of each surface node in the current configuration. `normals`: node_count().
void current_node_normals(const ContactSurface& surface, std::span<const double> x, std::span<Eigen::Vector3d> normals);

/// The same from the triangles of the node's own side only (node_side), so that a border's normal is its face's and not tilted towards the rim.
void current_face_normals(const ContactSurface& surface, std::span<const double> x, std::span<Eigen::Vector3d> normals);

/// Both of these, face normals and tributary areas, at the surface nodes of `which` only; other entries are left alone.
void current_faces_at(const ContactSurface& surface, std::span<const double> x, std::span<const int> which, std::span<Eigen::Vector3d> normals,
                      std::span<double> areas);

/// Distance at rest (m) of each surface node to the nearest solid node that is marked; infinity when none is. `is_marked`: solid_nodes or more entries.
std::vector<double> rest_distances_to(const ContactSurface& surface, std::span<const char> is_marked);

}  // namespace mv
