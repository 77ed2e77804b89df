// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/parallel.h"

namespace mv {
namespace {

using Vec3 = Eigen::Vector3d;

Vec3 point(std::span<const double> x, int node) { return Eigen::Map<const Vec3>(x.data() + 3 * static_cast<std::size_t>(node)); }

// Faces opposite to corner 0..3, outward for a positively oriented element, with the mid node of each face edge (VTK ordering).
constexpr int face_corner[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
constexpr int mid_of_edge[4][4] = {{-1, 4, 6, 7}, {4, -1, 5, 8}, {6, 5, -1, 9}, {7, 8, 9, -1}};

struct Face {
  std::array<int, 3> key;     // sorted corners
  std::array<int, 3> corner;  // outward
  std::array<int, 3> mid;     // of edges 01, 12, 20; -1 when linear
};

double signed_volume(std::span<const double> x, const std::array<int, 10>& t) {
  const Vec3 a = point(x, t[0]);
  return (point(x, t[1]) - a).cross(point(x, t[2]) - a).dot(point(x, t[3]) - a) / 6;
}

std::vector<Face> boundary_faces(std::span<const double> x, std::span<const std::array<int, 10>> tets, int order) {
  std::vector<Face> faces;
  faces.reserve(4 * tets.size());
  for (const auto& t : tets) {
    const bool flipped = signed_volume(x, t) < 0;
    for (const auto& local : face_corner) {
      std::array<int, 3> l{local[0], local[1], local[2]};
      if (flipped) std::swap(l[1], l[2]);
      Face face;
      for (int k = 0; k < 3; ++k) {
        face.corner[k] = t[l[k]];
        face.mid[k] = order == 2 ? t[mid_of_edge[l[k]][l[(k + 1) % 3]]] : -1;
      }
      face.key = face.corner;
      std::sort(face.key.begin(), face.key.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.key < b.key; });
  std::vector<Face> boundary;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].key == faces[i].key) ++j;
    if (j - i > 2)
      throw InputError("contact surface: face of nodes " + std::to_string(faces[i].key[0]) + ", " +
                       std::to_string(faces[i].key[1]) + ", " + std::to_string(faces[i].key[2]) +
                       " belongs to more than two elements");
    if (j - i == 1) boundary.push_back(faces[i]);
    i = j;
  }
  return boundary;
}

/// Both directions of each edge, as rows of a compressed table.
void set_edges(ContactSurface& s, std::vector<std::array<int, 2>> edges) {
  const std::size_t one_way = edges.size();
  edges.reserve(2 * one_way);
  for (std::size_t e = 0; e < one_way; ++e) edges.push_back({edges[e][1], edges[e][0]});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  s.edge_start.assign(static_cast<std::size_t>(s.solid_nodes) + 1, 0);
  s.edge_end.resize(edges.size());
  for (std::size_t e = 0; e < edges.size(); ++e) {
    ++s.edge_start[static_cast<std::size_t>(edges[e][0]) + 1];
    s.edge_end[e] = edges[e][1];
  }
  for (int n = 0; n < s.solid_nodes; ++n) s.edge_start[n + 1] += s.edge_start[n];
}

/// Fills everything that follows from `triangles` given over solid nodes.
void finish(ContactSurface& s, std::span<const double> x) {
  std::vector<int> surface_node(static_cast<std::size_t>(s.solid_nodes), -1);
  for (const auto& t : s.triangles) {
    for (int n : t) surface_node[n] = 0;
  }
  for (int n = 0; n < s.solid_nodes; ++n) {
    if (surface_node[n] < 0) continue;
    surface_node[n] = s.node_count();
    s.nodes.push_back(n);
    s.reference.push_back(point(x, n));
  }
  s.reference_area.assign(s.nodes.size(), 0.0);
  s.on_atrial_face.assign(s.nodes.size(), 0);
  s.node_side.assign(s.nodes.size(), 0);
  s.ring_start.assign(s.nodes.size() + 1, 0);
  double edge_sum = 0;
  for (std::size_t f = 0; f < s.triangles.size(); ++f) {
    auto& t = s.triangles[f];
    for (int& n : t) n = surface_node[n];
    for (int k = 0; k < 3; ++k) {
      int& side = s.node_side[t[k]];
      if (s.triangle_side[f] > 0 || side == 0) side = s.triangle_side[f];
      if (s.triangle_side[f] > 0) s.on_atrial_face[t[k]] = 1;
      ++s.ring_start[static_cast<std::size_t>(t[k]) + 1];
      edge_sum += (s.reference[t[(k + 1) % 3]] - s.reference[t[k]]).norm();
    }
  }
  for (std::size_t f = 0; f < s.triangles.size(); ++f) {
    const auto& t = s.triangles[f];
    const double area = 0.5 * (s.reference[t[1]] - s.reference[t[0]]).cross(s.reference[t[2]] - s.reference[t[0]]).norm();
    for (int n : t) {
      if (s.triangle_side[f] == s.node_side[n]) s.reference_area[n] += area / 3;
    }
  }
  s.mean_edge = edge_sum / (3.0 * static_cast<double>(s.triangles.size()));
  for (std::size_t n = 0; n < s.nodes.size(); ++n) s.ring_start[n + 1] += s.ring_start[n];
  s.ring.resize(3 * s.triangles.size());
  std::vector<int> next(s.ring_start.begin(), s.ring_start.end() - 1);
  for (int f = 0; f < s.triangle_count(); ++f) {
    for (int n : s.triangles[f]) s.ring[next[n]++] = f;
  }
}

void set_solid_nodes(ContactSurface& s, std::span<const double> x) {
  s.solid_nodes = static_cast<int>(x.size() / 3);
  s.solid_reference.resize(static_cast<std::size_t>(s.solid_nodes));
  for (int n = 0; n < s.solid_nodes; ++n) s.solid_reference[n] = point(x, n);
}

void check_index(int node, int count, const char* what) {
  if (node < 0 || node >= count)
    throw InputError(std::string("contact surface: ") + what + " refers to node " + std::to_string(node) + " of " +
                     std::to_string(count));
}

}  // namespace

ContactSurface extract_contact_surface(std::span<const double> rest_positions, std::span<const std::array<int, 10>> tets,
                                       int order, std::span<const int> side, ContactFaces faces) {
  ContactSurface s;
  set_solid_nodes(s, rest_positions);
  const bool has_sides = side.size() == static_cast<std::size_t>(s.solid_nodes);
  if (!has_sides && (!side.empty() || faces == ContactFaces::inner))
    throw InputError("contact surface: the array `side` has " + std::to_string(side.size()) + " entries for " +
                     std::to_string(s.solid_nodes) + " nodes");
  const int used = order == 2 ? 10 : 4;
  std::vector<std::array<int, 2>> edges;
  for (const auto& t : tets) {
    for (int k = 0; k < used; ++k) check_index(t[k], s.solid_nodes, "a tetrahedron");
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) {
        if (order == 2) {
          edges.push_back({t[a], t[mid_of_edge[a][b]]});
          edges.push_back({t[mid_of_edge[a][b]], t[b]});
        } else {
          edges.push_back({t[a], t[b]});
        }
      }
    }
  }
  for (const Face& face : boundary_faces(rest_positions, tets, order)) {
    const auto& c = face.corner;
    int triangle_side = 0;
    if (has_sides && side[c[0]] == side[c[1]] && side[c[1]] == side[c[2]]) triangle_side = side[c[0]];
    if (faces == ContactFaces::inner && triangle_side != 1) continue;
    if (order == 2) {
      const auto& m = face.mid;
      s.triangles.push_back({c[0], m[0], m[2]});
      s.triangles.push_back({m[0], c[1], m[1]});
      s.triangles.push_back({m[2], m[1], c[2]});
      s.triangles.push_back({m[0], m[1], m[2]});
      // Mid nodes are joined across the face, so that distances along the solid do not detour over corners.
      for (int k = 0; k < 3; ++k) edges.push_back({m[k], m[(k + 1) % 3]});
      s.triangle_side.insert(s.triangle_side.end(), 4, triangle_side);
    } else {
      s.triangles.push_back(c);
      s.triangle_side.push_back(triangle_side);
    }
  }
  if (s.triangles.empty())
    throw InputError("contact surface: no boundary face with the side asked for; check the array `side` of leaflets.vtu");
  set_edges(s, std::move(edges));
  finish(s, rest_positions);
  return s;
}

ContactSurface contact_surface_from_triangles(std::span<const double> rest_positions,
                                              std::span<const std::array<int, 3>> triangles) {
  ContactSurface s;
  set_solid_nodes(s, rest_positions);
  if (triangles.empty()) throw InputError("contact surface: no triangles");
  std::vector<std::array<int, 2>> edges;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      check_index(t[k], s.solid_nodes, "a triangle");
      edges.push_back({t[k], t[(k + 1) % 3]});
    }
  }
  s.triangles.assign(triangles.begin(), triangles.end());
  s.triangle_side.assign(triangles.size(), 1);
  set_edges(s, std::move(edges));
  finish(s, rest_positions);
  return s;
}

void current_tributary_areas(const ContactSurface& s, std::span<const double> x, std::span<double> area) {
  parallel_for(s.node_count(), [&](std::ptrdiff_t n) {
    double sum = 0;
    for (int r = s.ring_start[n]; r < s.ring_start[n + 1]; ++r) {
      if (s.triangle_side[s.ring[r]] != s.node_side[n]) continue;
      const auto& t = s.triangles[s.ring[r]];
      const Vec3 a = point(x, s.nodes[t[0]]);
      sum += (point(x, s.nodes[t[1]]) - a).cross(point(x, s.nodes[t[2]]) - a).norm();
    }
    area[n] = sum / 6;
  });
}

namespace {

template <class Keep>
void sum_normals(const ContactSurface& s, std::span<const double> x, std::span<Vec3> normals, const Keep& keep) {
  parallel_for(s.node_count(), [&](std::ptrdiff_t n) {
    Vec3 sum = Vec3::Zero();
    for (int r = s.ring_start[n]; r < s.ring_start[n + 1]; ++r) {
      if (!keep(n, s.ring[r])) continue;
      const auto& t = s.triangles[s.ring[r]];
      const Vec3 a = point(x, s.nodes[t[0]]);
      sum += (point(x, s.nodes[t[1]]) - a).cross(point(x, s.nodes[t[2]]) - a);
    }
    const double length = sum.norm();
    normals[n] = length > 0 ? Vec3(sum / length) : Vec3::Zero();
  });
}

}  // namespace

void current_node_normals(const ContactSurface& s, std::span<const double> x, std::span<Vec3> normals) {
  sum_normals(s, x, normals, [](std::ptrdiff_t, int) { return true; });
}

void current_face_normals(const ContactSurface& s, std::span<const double> x, std::span<Vec3> normals) {
  sum_normals(s, x, normals, [&](std::ptrdiff_t n, int f) { return s.triangle_side[f] == s.node_side[n]; });
}

void current_faces_at(const ContactSurface& s, std::span<const double> x, std::span<const int> which, std::span<Vec3> normals, std::span<double> areas) {
  parallel_for(static_cast<std::ptrdiff_t>(which.size()), [&](std::ptrdiff_t q) {
    const int n = which[q];
    Vec3 sum = Vec3::Zero();
    double area = 0;
    for (int r = s.ring_start[n]; r < s.ring_start[n + 1]; ++r) {
      if (s.triangle_side[s.ring[r]] != s.node_side[n]) continue;
      const auto& t = s.triangles[s.ring[r]];
      const Vec3 a = point(x, s.nodes[t[0]]);
      const Vec3 m = (point(x, s.nodes[t[1]]) - a).cross(point(x, s.nodes[t[2]]) - a);
      sum += m;
      area += m.norm();
    }
    const double length = sum.norm();
    normals[n] = length > 0 ? Vec3(sum / length) : Vec3::Zero();
    areas[n] = area / 6;
  });
}

std::vector<double> rest_distances_to(const ContactSurface& surface, std::span<const char> is_marked) {
  std::vector<Eigen::Vector3d> marked;
  for (std::size_t i = 0; i < surface.solid_reference.size(); ++i)
    if (is_marked[i]) marked.push_back(surface.solid_reference[i]);
  std::vector<double> distance(surface.nodes.size());
  parallel_for(surface.node_count(), [&](std::ptrdiff_t n) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : marked) nearest = std::min(nearest, (surface.reference[static_cast<std::size_t>(n)] - p).squaredNorm());
    distance[static_cast<std::size_t>(n)] = std::sqrt(nearest);
  });
  return distance;
}

}  // namespace mv
