// SPDX-License-Identifier: BSD-3-Clause
#include "verification/solid/equilibrium.h"

#include <Eigen/QR>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace mv::test {
namespace {

using Forces = std::function<void(std::span<const double>, std::span<double>)>;

/// Columns of the tangent's pattern and a colouring in which columns of one colour share no row.
struct Pattern {
  std::vector<std::vector<int>> rows;   // per column, ascending
  std::vector<std::vector<int>> colours;
};

Pattern pattern_of(const std::vector<std::vector<int>>& elements, int unknowns) {
  Pattern p;
  p.rows.resize(static_cast<std::size_t>(unknowns));
  for (const auto& element : elements)
    for (int a : element) p.rows[static_cast<std::size_t>(a)].insert(p.rows[static_cast<std::size_t>(a)].end(), element.begin(), element.end());
  for (auto& rows : p.rows) {
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  std::vector<int> colour(static_cast<std::size_t>(unknowns), -1), taken_by;
  for (int column = 0; column < unknowns; ++column) {
    for (int row : p.rows[static_cast<std::size_t>(column)])
      for (int other : p.rows[static_cast<std::size_t>(row)]) {
        const int c = colour[static_cast<std::size_t>(other)];
        if (c >= 0) taken_by[static_cast<std::size_t>(c)] = column;
      }
    const auto found = std::find_if(taken_by.begin(), taken_by.end(), [&](int by) { return by != column; });
    const int c = static_cast<int>(found - taken_by.begin());
    if (found == taken_by.end()) {
      taken_by.push_back(-1);
      p.colours.emplace_back();
    }
    colour[static_cast<std::size_t>(column)] = c;
    p.colours[static_cast<std::size_t>(c)].push_back(column);
  }
  return p;
}

std::vector<double> residual_at(const Constraints& constraints, const Forces& forces, std::span<const double> q) {
  const std::vector<double> x = constraints.positions(q);
  std::vector<double> f(x.size(), 0.0);
  forces(x, f);
  return constraints.reduced(f);
}

Eigen::SparseMatrix<double> tangent(const Constraints& constraints, const Forces& forces, const Pattern& pattern, std::vector<double> q,
                                    double difference) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& columns : pattern.colours) {
    for (int c : columns) q[static_cast<std::size_t>(c)] += difference;
    const std::vector<double> plus = residual_at(constraints, forces, q);
    for (int c : columns) q[static_cast<std::size_t>(c)] -= 2 * difference;
    const std::vector<double> minus = residual_at(constraints, forces, q);
    for (int c : columns) q[static_cast<std::size_t>(c)] += difference;
    for (int c : columns)
      for (int r : pattern.rows[static_cast<std::size_t>(c)])
        entries.emplace_back(r, c, (minus[static_cast<std::size_t>(r)] - plus[static_cast<std::size_t>(r)]) / (2 * difference));
  }
  Eigen::SparseMatrix<double> K(constraints.count(), constraints.count());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

double largest(const std::vector<double>& r) {
  double value = 0;
  for (double a : r) value = std::isfinite(a) ? std::max(value, std::abs(a)) : 1e300;
  return value;
}

}  // namespace

Constraints::Constraints(std::vector<double> base) : base_(std::move(base)), shares_(base_.size() / 3) {}

void Constraints::free_except(int node, std::span<const Vec3> normals) {
  // Projections of the axes off the normals, made orthonormal: Gram-Schmidt.
  std::vector<Vec3> basis;
  const auto remainder = [&](Vec3 v) {
    for (const Vec3& b : basis) v -= b.dot(v) * b;
    return v;
  };
  for (const Vec3& n : normals) {
    const Vec3 v = remainder(n.normalized());
    if (v.norm() > 1e-9) basis.push_back(v.normalized());
  }
  while (basis.size() < 3) {
    Vec3 best = Vec3::Zero();
    for (int a = 0; a < 3; ++a) {
      const Vec3 v = remainder(Vec3::Unit(a));
      if (v.norm() > best.norm() + 1e-9) best = v;
    }
    basis.push_back(best.normalized());
    share(node, add_unknown(), basis.back());
  }
}

void Constraints::plane_strain(const BoxMesh& box, const std::function<std::vector<Vec3>(int)>& normals_of_node) {
  std::map<std::array<int, 2>, int> first;
  for (int n = 0; n < box.node_count(); ++n) {
    const auto& l = box.lattice[static_cast<std::size_t>(n)];
    const auto [it, is_new] = first.try_emplace({l[0], l[2]}, n);
    if (is_new) {
      std::vector<Vec3> normals = normals_of_node(n);
      normals.insert(normals.begin(), Vec3::UnitY());
      free_except(n, normals);
    } else {
      shares_[static_cast<std::size_t>(n)] = shares_[static_cast<std::size_t>(it->second)];
    }
  }
}

std::vector<double> Constraints::positions(std::span<const double> q) const {
  std::vector<double> x = base_;
  for (std::size_t n = 0; n < shares_.size(); ++n)
    for (const Share& s : shares_[n]) Vec3::Map(x.data() + 3 * n) += q[static_cast<std::size_t>(s.unknown)] * s.direction;
  return x;
}

std::vector<double> Constraints::reduced(std::span<const double> f) const {
  std::vector<double> r(static_cast<std::size_t>(unknowns_), 0.0);
  for (std::size_t n = 0; n < shares_.size(); ++n)
    for (const Share& s : shares_[n]) r[static_cast<std::size_t>(s.unknown)] += s.direction.dot(Vec3::Map(f.data() + 3 * n));
  return r;
}

std::vector<std::vector<int>> Constraints::unknowns_of_elements(const SolidMesh& mesh) const {
  const std::size_t per = static_cast<std::size_t>(mesh.nodes_per_tet);
  std::vector<std::vector<int>> result(mesh.tets.size() / per);
  for (std::size_t e = 0; e < result.size(); ++e) {
    std::set<int> unknowns;
    for (std::size_t a = 0; a < per; ++a)
      for (const Share& s : shares_[static_cast<std::size_t>(mesh.tets[per * e + a])]) unknowns.insert(s.unknown);
    result[e].assign(unknowns.begin(), unknowns.end());
  }
  return result;
}

Equilibrium solve(const Constraints& constraints, const SolidMesh& mesh, const Forces& forces, double length, double tolerance,
                  std::vector<double> start) {
  constexpr int max_iterations = 40, max_halvings = 8;
  constexpr double relative_difference = 1e-6;
  const Pattern pattern = pattern_of(constraints.unknowns_of_elements(mesh), constraints.count());
  Equilibrium e;
  e.q = start.empty() ? std::vector<double>(static_cast<std::size_t>(constraints.count()), 0.0) : std::move(start);
  std::vector<double> r = residual_at(constraints, forces, e.q);
  e.residual = largest(r);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver;
  bool is_analysed = false;
  for (; e.iterations < max_iterations && e.residual > tolerance; ++e.iterations) {
    const Eigen::SparseMatrix<double> K = tangent(constraints, forces, pattern, e.q, relative_difference * length);
    if (!is_analysed) solver.analyzePattern(K);
    is_analysed = true;
    solver.factorize(K);
    if (solver.info() != Eigen::Success) break;
    const Eigen::VectorXd step = solver.solve(Eigen::VectorXd::Map(r.data(), static_cast<Eigen::Index>(r.size())));
    // A residual may rise a little on the way (bending); a tenfold rise is a step too far.
    double scale = 1;
    for (int halving = 0; halving <= max_halvings; ++halving, scale *= 0.5) {
      std::vector<double> q = e.q;
      for (std::size_t i = 0; i < q.size(); ++i) q[i] += scale * step[static_cast<Eigen::Index>(i)];
      std::vector<double> trial = residual_at(constraints, forces, q);
      if (largest(trial) > 10 * e.residual && halving < max_halvings) continue;
      e.q = std::move(q);
      r = std::move(trial);
      break;
    }
    e.residual = largest(r);
  }
  e.is_converged = e.residual <= tolerance;
  e.x = constraints.positions(e.q);
  return e;
}

}  // namespace mv::test
