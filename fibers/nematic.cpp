// SPDX-License-Identifier: BSD-3-Clause
#include "fibers/nematic.h"

#include <Eigen/Geometry>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <string>

#include "fibers/intrinsic_surface.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

using Complex = std::complex<double>;

constexpr double smallest_order = 1e-9;    // below it, contradicting directions leave no direction at all
constexpr double smallest_tangent = 1e-6;  // part of a unit direction that must lie in the tangent plane

// A mesh whose face is further from Delaunay than this (degrees, two angles opposite to an edge) is diffused on its intrinsic surface.
constexpr double obtuse_sum = 200;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Frame {
  Vec3 a, b, normal;
};

Frame make_frame(const Vec3& normal) {
  int axis = 0;
  normal.cwiseAbs().minCoeff(&axis);
  const Vec3 a = normal.cross(Vec3::Unit(axis)).normalized();
  return {a, normal.cross(a), normal};
}

// z of a tangent direction; even in the direction, so its sign cannot matter.
Complex to_complex(const Frame& f, const Vec3& direction) {
  const double x = direction.dot(f.a), y = direction.dot(f.b);
  return Complex(x * x - y * y, 2 * x * y) / (x * x + y * y);
}

Vec3 to_direction(const Frame& f, Complex z) {
  const double angle = 0.5 * std::arg(z);
  return std::cos(angle) * f.a + std::sin(angle) * f.b;
}

// exp(2 i rho) that carries z from one frame to another by the smallest rotation between their normals.
Complex transport(const Frame& from, const Frame& to) {
  const Vec3 a = Eigen::Quaterniond::FromTwoVectors(from.normal, to.normal) * from.a;
  const Complex turn(a.dot(to.a), a.dot(to.b));
  return turn * turn / std::norm(turn);
}

// Everything indexed by the local numbers of the nodes that the elements use.
struct Domain {
  std::vector<std::array<int, 4>> corners;
  std::vector<Frame> frames;
  std::vector<Frame> element_frames;
  std::vector<int> local_of_node;
  std::vector<int> part;  // connected part of each node
  int parts = 0;
};

Domain make_domain(const LeafletMesh& mesh, const std::vector<int>& elements) {
  if (mesh.sheet_normal.size() != mesh.tets.size())
    throw InputError("fibers: the leaflets have no sheet_normal; run the mesh stage first");
  Domain d;
  d.local_of_node.assign(mesh.points.size(), -1);
  std::vector<Vec3> normals;
  for (int e : elements) {
    const Vec3& s = mesh.sheet_normal[at(e)];
    if (!s.allFinite() || std::abs(s.norm() - 1) > 1e-3)
      throw InputError("fibers: sheet_normal of leaflet element " + std::to_string(e) + " is not a unit vector");
    d.element_frames.push_back(make_frame(s.normalized()));
    std::array<int, 4> corner{};
    for (std::size_t i = 0; i < 4; ++i) {
      int& local = d.local_of_node[at(mesh.tets[at(e)][i])];
      if (local < 0) {
        local = static_cast<int>(normals.size());
        normals.push_back(Vec3::Zero());
      }
      corner[i] = local;
    }
    const auto& t = mesh.tets[at(e)];
    const Vec3 x0 = mesh.points[at(t[0])];
    const double volume =
        std::abs((mesh.points[at(t[1])] - x0).cross(mesh.points[at(t[2])] - x0).dot(mesh.points[at(t[3])] - x0)) / 6;
    if (!(volume > 0)) throw InputError("fibers: leaflet element " + std::to_string(e) + " has no volume");
    for (int c : corner)
      normals[at(c)] += volume * s;
    d.corners.push_back(corner);
  }
  for (const Vec3& n : normals) {
    if (!(n.norm() > 0)) throw InputError("fibers: the sheet normals around a leaflet node cancel");
    d.frames.push_back(make_frame(n.normalized()));
  }
  std::vector<int> parent(normals.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[at(i)] != i)
      i = parent[at(i)] = parent[at(parent[at(i)])];
    return i;
  };
  for (const auto& c : d.corners)
    for (std::size_t i = 1; i < 4; ++i)
      parent[at(find(c[i]))] = find(c[0]);
  d.part.resize(normals.size());
  for (std::size_t i = 0; i < parent.size(); ++i)
    d.part[i] = find(static_cast<int>(i));
  return d;
}

// Integrals of grad N_i . grad N_j over one linear tetrahedron.
Eigen::Matrix4d stiffness(const LeafletMesh& mesh, const std::array<int, 10>& tet) {
  Mat3 edges;
  for (int i = 0; i < 3; ++i)
    edges.col(i) = mesh.points[at(tet[at(i + 1)])] - mesh.points[at(tet[0])];
  Eigen::Matrix<double, 3, 4> gradients;
  gradients.rightCols<3>() = edges.inverse().transpose();
  gradients.col(0) = -gradients.rightCols<3>().rowwise().sum();
  return std::abs(edges.determinant()) / 6 * gradients.transpose() * gradients;
}

// Value at each local node that has one; |z| = 1.
std::vector<Complex> fix_given(const Domain& d, const std::vector<GivenDirection>& given, std::vector<char>& is_given) {
  std::vector<Complex> z(d.frames.size(), 0.0);
  std::vector<double> weight(d.frames.size(), 0.0);
  is_given.assign(d.frames.size(), 0);
  for (const GivenDirection& g : given) {
    const int local = g.node >= 0 && at(g.node) < d.local_of_node.size() ? d.local_of_node[at(g.node)] : -1;
    if (local < 0)
      throw InputError("fibers: a direction is given at node " + std::to_string(g.node) +
                       ", which belongs to none of the elements");
    const Frame& f = d.frames[at(local)];
    const Vec3 tangent = g.direction - f.normal * f.normal.dot(g.direction);
    if (!g.direction.allFinite() || !(tangent.norm() > smallest_tangent * g.direction.norm()))
      throw InputError("fibers: the direction given at node " + std::to_string(g.node) +
                       " vanishes in the leaflet's tangent plane");
    z[at(local)] += g.weight * to_complex(f, tangent);
    weight[at(local)] += g.weight;
  }
  for (std::size_t i = 0; i < z.size(); ++i) {
    if (!(weight[i] > 0) || std::abs(z[i]) < smallest_order * weight[i]) continue;
    z[i] /= std::abs(z[i]);
    is_given[i] = 1;
  }
  std::vector<char> has_given(d.frames.size(), 0);
  for (std::size_t i = 0; i < z.size(); ++i)
    if (is_given[i]) has_given[at(d.part[i])] = 1;
  for (int p : d.part)
    if (!has_given[at(p)]) throw InputError("fibers: no direction is given on a connected part of the leaflet");
  return z;
}

using Entries = std::vector<Eigen::Triplet<Complex>>;

// Puts the solution of the assembled system into the unknown z.
void solve(const Entries& entries, const Eigen::VectorXcd& rhs, const std::vector<int>& unknown, std::vector<Complex>& z) {
  Eigen::SparseMatrix<Complex> matrix(rhs.size(), rhs.size());
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> solver(matrix);
  if (solver.info() != Eigen::Success)
    throw InputError("fibers: the diffusion system is singular; check the leaflet mesh for degenerate elements");
  const Eigen::VectorXcd solution = solver.solve(rhs);
  if (!solution.allFinite() || (matrix * solution - rhs).norm() > 1e-8 * (rhs.norm() + 1e-300))
    throw InputError("fibers: the diffusion system could not be solved; check the leaflet mesh for degenerate elements");
  for (std::size_t i = 0; i < z.size(); ++i)
    if (unknown[i] >= 0) z[i] = solution[unknown[i]];
}

// Numbers of the free entries; returns how many.
int number_free(const std::vector<char>& is_given, std::vector<int>& unknown) {
  unknown.assign(is_given.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < is_given.size(); ++i)
    if (!is_given[i]) unknown[i] = count++;
  return count;
}

void solve_in_volume(const LeafletMesh& mesh, const std::vector<int>& elements, const Domain& d, const std::vector<char>& is_given,
                     std::vector<Complex>& z) {
  std::vector<int> unknown;
  const int count = number_free(is_given, unknown);
  if (count == 0) return;
  Entries entries;
  Eigen::VectorXcd rhs = Eigen::VectorXcd::Zero(count);
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Eigen::Matrix4d k = stiffness(mesh, mesh.tets[at(elements[e])]);
    const auto& c = d.corners[e];
    for (int i = 0; i < 4; ++i) {
      const int row = unknown[at(c[at(i)])];
      if (row < 0) continue;
      for (int j = 0; j < 4; ++j) {
        if (i == j) continue;
        const double weight = -k(i, j);
        entries.emplace_back(row, row, weight);
        const Complex carry = weight * transport(d.frames[at(c[at(j)])], d.frames[at(c[at(i)])]);
        if (const int column = unknown[at(c[at(j)])]; column >= 0)
          entries.emplace_back(row, column, -carry);
        else
          rhs[row] += carry * z[at(c[at(j)])];
      }
    }
  }
  solve(entries, rhs, unknown, z);
}

void solve_on_surface(const IntrinsicSurface& surface, const Domain& d, const std::vector<char>& is_given, std::vector<Complex>& z) {
  const std::size_t columns = surface.column_node.size();
  std::vector<Frame> frames;
  for (int node : surface.column_node) frames.push_back(d.frames[at(d.local_of_node[at(node)])]);
  std::vector<int> column(d.frames.size(), -1);
  for (std::size_t node = 0; node < d.local_of_node.size(); ++node)
    if (d.local_of_node[node] >= 0) column[at(d.local_of_node[node])] = surface.column_of_node[node];
  // What is given anywhere through the thickness holds for the column.
  std::vector<Complex> zc(columns, 0.0);
  std::vector<char> is_fixed(columns, 0);
  for (std::size_t i = 0; i < z.size(); ++i)
    if (is_given[i]) zc[at(column[i])] += transport(d.frames[i], frames[at(column[i])]) * z[i];
  for (std::size_t c = 0; c < columns; ++c) {
    if (std::abs(zc[c]) < smallest_order) continue;
    zc[c] /= std::abs(zc[c]);
    is_fixed[c] = 1;
  }
  // A trace of coupling keeps points whose weights all vanish in the system.
  double largest = 0;
  for (const auto& e : surface.edges) largest = std::max(largest, e.weight);
  std::vector<int> unknown;
  const int count = number_free(is_fixed, unknown);
  Entries entries;
  Eigen::VectorXcd rhs = Eigen::VectorXcd::Zero(count);
  for (const auto& e : surface.edges) {
    const double weight = std::max(e.weight, 1e-9 * largest);
    for (const auto& [i, j] : {std::pair(e.a, e.b), std::pair(e.b, e.a)}) {
      const int row = unknown[at(i)];
      if (row < 0) continue;
      entries.emplace_back(row, row, weight);
      const Complex carry = weight * transport(frames[at(j)], frames[at(i)]);
      if (unknown[at(j)] >= 0)
        entries.emplace_back(row, unknown[at(j)], -carry);
      else
        rhs[row] += carry * zc[at(j)];
    }
  }
  if (count > 0) solve(entries, rhs, unknown, zc);
  for (std::size_t i = 0; i < z.size(); ++i)
    if (!is_given[i]) z[i] = transport(frames[at(column[i])], d.frames[i]) * zc[at(column[i])];
}

}  // namespace

NematicField diffuse_directions(const LeafletMesh& mesh, const std::vector<int>& elements,
                                const std::vector<GivenDirection>& given, Diffusion how) {
  const Domain d = make_domain(mesh, elements);
  std::vector<char> is_given;
  std::vector<Complex> z = fix_given(d, given, is_given);
  NematicField field;
  IntrinsicSurface surface;
  if (how != Diffusion::volume && mesh.side.size() == mesh.points.size()) surface = intrinsic_surface(mesh, elements);
  field.on_surface = !surface.column_node.empty() && (how == Diffusion::surface || surface.worst_angle_sum > obtuse_sum);
  if (field.on_surface)
    solve_on_surface(surface, d, is_given, z);
  else
    solve_in_volume(mesh, elements, d, is_given, z);
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Frame& frame = d.element_frames[e];
    Complex mean = 0;
    for (int c : d.corners[e])
      mean += 0.25 * transport(d.frames[at(c)], frame) * z[at(c)];
    field.directions.push_back(to_direction(frame, mean));
    field.order.push_back(std::abs(mean));
    field.order_min = std::min(field.order_min, field.order.back());
  }
  return field;
}

}  // namespace mv
