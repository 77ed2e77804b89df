// SPDX-License-Identifier: BSD-3-Clause
#include "solver/solid/leaflet_solid.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>

#include "geometry/core/errors.h"
#include "geometry/core/leaflet_names.h"
#include "geometry/core/parallel.h"
#include "solver/solid/distorted_points.h"
#include "solver/solid/element_kernel.h"

namespace mv {

using namespace solid_kernel;

namespace solid_kernel {

Pack distortion_control(const LawConstants& k, const Deformation<Pack>& d, Tensor<Pack>& P, PackInt& is_active) {
  return add_distortion_control<Pack>(k, d, P, is_active);
}

}   // namespace solid_kernel

struct LeafletSolid::Data {
  SolidMesh mesh;
  std::vector<Material> materials;
  std::vector<LawConstants> laws;
  ElementBlocks blocks;
  std::vector<double> element_volumes, node_volumes, node_masses;
  double shortest_edge = 0;
  SolidStatistics statistics;

  Aligned<double> partial;   // 4 per tile node
  std::vector<BlockSums> tile_sums;
  std::vector<double> tile_steps;
  std::vector<double> work_x, work_f;   // forces_directional

  void check() const;
  void set_volumes();
  double tile_forces(std::span<const double> x, std::span<double> f);
  template <int N>
  void run_tile(const Tile& tile, const double* x, BlockSums& sums);
  template <int N>
  double tile_step(const Tile& tile, const double* x, std::span<double> element_steps, int rounds) const;
  void collect_statistics();
};

namespace {

void load_tile_nodes(const ElementBlocks& blocks, const Tile& tile, const double* x, double* records) {
  for (std::int32_t i = 0; i < tile.node_count; ++i) {
    const double* from = x + 3 * static_cast<std::ptrdiff_t>(blocks.tile_nodes[tile.node_begin + i]);
    records[4 * i] = from[0], records[4 * i + 1] = from[1], records[4 * i + 2] = from[2], records[4 * i + 3] = 0;
  }
}

template <int N>
MV_INLINE ElementVectors<N> load_elements(const double* records, const std::int32_t* index) {
  ElementVectors<N> x;
  for (int a = 0; a < N; ++a) load_corner(records, index + a * lanes, x.a[a]);
  return x;
}

double sum(Pack v) {
  double s = 0;
  for (int l = 0; l < lanes; ++l) s += v[l];
  return s;
}

}   // namespace

SolidMesh to_solid_mesh(const LeafletMesh& leaflets) {
  constexpr double metre_per_mm = 1e-3;
  SolidMesh mesh;
  mesh.nodes_per_tet = leaflets.nodes_per_tet();
  mesh.points.reserve(3 * leaflets.points.size());
  for (const Vec3& p : leaflets.points)
    for (int i = 0; i < 3; ++i) mesh.points.push_back(metre_per_mm * p[i]);
  for (std::size_t e = 0; e < leaflets.tets.size(); ++e) {
    for (int a = 0; a < mesh.nodes_per_tet; ++a) mesh.tets.push_back(leaflets.tets[e][a]);
    for (int i = 0; i < 3; ++i) mesh.fibres.push_back(leaflets.fibre[e][i]);
    const auto leaflet = std::find_if(leaflet_names.begin(), leaflet_names.end(), [&](const NamedRegion& n) { return n.region == leaflets.region[e]; });
    if (leaflet == leaflet_names.end()) throw InputError("leaflet element " + std::to_string(e) + " belongs to leaflet " + std::to_string(leaflets.region[e]) + ", which has no name");
    mesh.material.push_back(static_cast<int>(leaflet - leaflet_names.begin()));
  }
  return mesh;
}

// --- construction

void LeafletSolid::Data::check() const {
  const int N = mesh.nodes_per_tet;
  if (N != 4 && N != 10) throw InputError("leaflet elements must have 4 or 10 nodes, not " + std::to_string(N));
  if (mesh.points.size() % 3 != 0 || mesh.tets.size() % N != 0) throw InputError("leaflet mesh arrays have incomplete rows");
  const std::size_t elements = mesh.tets.size() / N;
  const long nodes = static_cast<long>(mesh.points.size()) / 3;
  if (elements == 0) throw InputError("leaflet mesh has no elements");
  if (mesh.fibres.size() != 3 * elements || mesh.material.size() != elements)
    throw InputError("leaflet mesh has " + std::to_string(elements) + " elements but " + std::to_string(mesh.fibres.size() / 3) +
                     " fibres and " + std::to_string(mesh.material.size()) + " material indices");
  for (double p : mesh.points)
    if (!std::isfinite(p)) throw InputError("leaflet mesh has a point that is not finite");
  for (std::size_t i = 0; i < mesh.tets.size(); ++i)
    if (mesh.tets[i] < 0 || mesh.tets[i] >= nodes)
      throw InputError("leaflet element " + std::to_string(i / N) + " refers to point " + std::to_string(mesh.tets[i]) + " of " +
                       std::to_string(nodes));
  for (std::size_t e = 0; e < elements; ++e) {
    const double* f = mesh.fibres.data() + 3 * e;
    if (!(std::abs(std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]) - 1) < 1e-4))
      throw InputError("fibre of leaflet element " + std::to_string(e) + " is not a unit vector");
    if (mesh.material[e] < 0 || mesh.material[e] >= static_cast<int>(materials.size()))
      throw InputError("leaflet element " + std::to_string(e) + " has no material");
  }
  for (std::size_t m = 0; m < materials.size(); ++m)
    for (const std::string& defect : defects(materials[m]))
      throw InputError("material " + std::to_string(m) + " (" + name_of(materials[m].law) + "): " + defect);
}

void LeafletSolid::Data::set_volumes() {
  const int N = mesh.nodes_per_tet;
  element_volumes.assign(static_cast<std::size_t>(blocks.element_count), 0);
  for (long b = 0; b < blocks.block_count; ++b)
    for (int lane = 0; lane < lanes; ++lane) {
      const std::int32_t e = blocks.element[b * lanes + lane];
      for (int q = 0; e >= 0 && q < blocks.points; ++q) element_volumes[e] += blocks.block(b)[(q * 10 + 9) * lanes + lane];
    }
  node_volumes.assign(mesh.points.size() / 3, 0);
  node_masses.assign(mesh.points.size() / 3, 0);
  shortest_edge = std::numeric_limits<double>::max();
  for (long e = 0; e < blocks.element_count; ++e) {
    const int* node = mesh.tets.data() + e * N;
    for (int a = 0; a < N; ++a) {
      const double share = N == 4 ? Shape<4>::mass_share(a) : Shape<10>::mass_share(a);
      node_volumes[node[a]] += share * element_volumes[e];
      node_masses[node[a]] += share * element_volumes[e] * materials[mesh.material[e]].density;
    }
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b) {
        const Eigen::Map<const Vec3> xa(mesh.points.data() + 3 * static_cast<long>(node[a]));
        const Eigen::Map<const Vec3> xb(mesh.points.data() + 3 * static_cast<long>(node[b]));
        shortest_edge = std::min(shortest_edge, (xa - xb).norm());
      }
  }
}

LeafletSolid::LeafletSolid(const SolidMesh& mesh, std::vector<Material> materials) : data_(std::make_unique<Data>()) {
  data_->mesh = mesh;
  data_->materials = std::move(materials);
  data_->check();
  for (const Material& m : data_->materials) data_->laws.push_back(law_constants(m));
  data_->blocks = build_element_blocks(mesh);
  data_->set_volumes();
  data_->partial.resize(4 * data_->blocks.tile_nodes.size());
  data_->tile_sums.resize(data_->blocks.tiles.size());
  data_->tile_steps.resize(data_->blocks.tiles.size());
  data_->work_x.resize(mesh.points.size());
  data_->work_f.resize(mesh.points.size());
}

LeafletSolid::~LeafletSolid() = default;
LeafletSolid::LeafletSolid(LeafletSolid&&) noexcept = default;
LeafletSolid& LeafletSolid::operator=(LeafletSolid&&) noexcept = default;

// --- forces

template <int N>
void LeafletSolid::Data::run_tile(const Tile& tile, const double* x, BlockSums& sums) {
  alignas(64) double position[4 * tile_nodes_max];
  alignas(64) double force[4 * tile_nodes_max];
  load_tile_nodes(blocks, tile, x, position);
  std::fill_n(force, 4 * tile.node_count, 0.0);
  DistortedPoints<N> distorted(blocks, tile, force, sums);
  for (std::int32_t b = tile.block_begin; b < tile.block_end; ++b) {
    const std::int32_t* index = blocks.local_node.data() + static_cast<std::ptrdiff_t>(b) * N * lanes;
    const LawConstants& law = laws[blocks.block_material[b]];
    const ElementVectors<N> xe = load_elements<N>(position, index);
    ElementVectors<N> fe;
    block_forces<N>(law, blocks.block(b), xe, fe, sums, b,
                    [&](int q, const Deformation<Pack>& d, PackInt which, Tensor<Pack>&) { distorted.add(law, b, q, d.F, which); });
    for (int a = 0; a < N; ++a) add_corner(force, index + a * lanes, fe.a[a]);
  }
  distorted.finish();
  std::copy_n(force, 4 * tile.node_count, partial.data() + 4 * static_cast<std::ptrdiff_t>(tile.node_begin));
}

/// Adds the forces to f; energy and the rest are left in tile_sums.
double LeafletSolid::Data::tile_forces(std::span<const double> x, std::span<double> f) {
  assert(x.size() == mesh.points.size() && f.size() == mesh.points.size());
  // Distorted tissue, which costs more, is bunched up.
  parallel_pieces(
      static_cast<std::ptrdiff_t>(blocks.tiles.size()), 1,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        for (std::ptrdiff_t t = begin; t < end; ++t) {
          BlockSums sums;
          if (blocks.nodes == 10)
            run_tile<10>(blocks.tiles[t], x.data(), sums);
          else
            run_tile<4>(blocks.tiles[t], x.data(), sums);
          tile_sums[t] = sums;
        }
      },
      2);
  parallel_for(blocks.node_count, [&](std::ptrdiff_t n) {
    double sum[3] = {0, 0, 0};
    for (std::int32_t s = blocks.node_begin[n]; s < blocks.node_begin[n + 1]; ++s) {
      const double* from = partial.data() + 4 * static_cast<std::ptrdiff_t>(blocks.node_slot[s]);
      for (int i = 0; i < 3; ++i) sum[i] += from[i];
    }
    for (int i = 0; i < 3; ++i) f[3 * n + i] += sum[i];
  });
  double energy = 0;
  for (const BlockSums& s : tile_sums) energy += sum(s.energy);
  return energy;
}

void LeafletSolid::Data::collect_statistics() {
  SolidStatistics s;
  s.J_min = std::numeric_limits<double>::max();
  s.J_max = -std::numeric_limits<double>::max();
  long controlled = 0;
  for (const BlockSums& t : tile_sums) {
    s.energy += sum(t.energy);
    s.control_energy += sum(t.control_energy);
    s.volume += sum(t.volume);
    controlled += t.controlled;
    s.inverted += t.inverted;
    for (int l = 0; l < lanes; ++l) {
      s.J_max = std::max(s.J_max, t.J_max[l]);
      if (t.J_min[l] >= s.J_min) continue;
      s.J_min = t.J_min[l];
      long i = t.J_min_block[l] * lanes + l;
      while (blocks.element[i] < 0) --i;   // padding repeats the element before it
      s.J_min_element = blocks.element[i];
    }
  }
  s.controlled_fraction = static_cast<double>(controlled) / static_cast<double>(blocks.element_count);
  s.is_finite = std::isfinite(s.energy) && std::isfinite(s.volume);
  statistics = s;
}

double LeafletSolid::forces(std::span<const double> x, std::span<double> f) {
  data_->tile_forces(x, f);
  data_->collect_statistics();
  return data_->statistics.energy;
}

namespace {

/// Factor on v that moves the fastest node by a small share of the shortest edge; 0 when nothing moves. The share balances the h^2 error of the stiff
/// exponential against round-off of positions.
double difference_factor(std::span<const double> v, double shortest_edge) {
  constexpr double relative_displacement = 3e-6;
  double largest = 0;
  for (std::size_t i = 0; i + 2 < v.size(); i += 3) largest = std::max(largest, v[i] * v[i] + v[i + 1] * v[i + 1] + v[i + 2] * v[i + 2]);
  return largest > 0 ? relative_displacement * shortest_edge / std::sqrt(largest) : 0.0;
}

}   // namespace

void LeafletSolid::forces_directional(std::span<const double> x, std::span<const double> v, std::span<double> out) {
  Data& d = *data_;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(x.size());
  assert(v.size() == x.size() && out.size() == x.size());
  std::fill(out.begin(), out.end(), 0.0);
  const double epsilon = difference_factor(v, d.shortest_edge);
  if (!(epsilon > 0)) return;
  parallel_for(n, [&](std::ptrdiff_t i) { d.work_x[i] = x[i] + epsilon * v[i]; });
  d.tile_forces(d.work_x, out);
  parallel_for(n, [&](std::ptrdiff_t i) {
    d.work_x[i] = x[i] - epsilon * v[i];
    d.work_f[i] = 0;
  });
  d.tile_forces(d.work_x, d.work_f);
  parallel_for(n, [&](std::ptrdiff_t i) { out[i] = (d.work_f[i] - out[i]) / (2 * epsilon); });
}

void LeafletSolid::forces_directional(std::span<const double> x, std::span<const double> at_x, std::span<const double> v, std::span<double> out) {
  Data& d = *data_;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(x.size());
  assert(v.size() == x.size() && out.size() == x.size() && at_x.size() == x.size());
  std::fill(out.begin(), out.end(), 0.0);
  const double epsilon = difference_factor(v, d.shortest_edge);
  if (!(epsilon > 0)) return;
  parallel_for(n, [&](std::ptrdiff_t i) { d.work_x[i] = x[i] + epsilon * v[i]; });
  d.tile_forces(d.work_x, out);
  parallel_for(n, [&](std::ptrdiff_t i) { out[i] = (at_x[i] - out[i]) / epsilon; });
}

// --- critical step

/// Power iteration on M_e^(-1/2) K_e M_e^(-1/2) of a block of elements at a time, K_e by central differences of the element forces (one-sided ones
/// would miss fibres that take no pressure, at rest).
template <int N>
double LeafletSolid::Data::tile_step(const Tile& tile, const double* x, std::span<double> element_steps, int rounds) const {
  constexpr double relative_displacement = 1e-6;
  alignas(64) double position[4 * tile_nodes_max];
  load_tile_nodes(blocks, tile, x, position);
  double root_share[N];   // square root of the node's share of the element mass
  for (int a = 0; a < N; ++a) root_share[a] = std::sqrt(Shape<N>::mass_share(a));

  double shortest = std::numeric_limits<double>::max();
  for (std::int32_t b = tile.block_begin; b < tile.block_end; ++b) {
    const LawConstants& law = laws[blocks.block_material[b]];
    const double* data = blocks.block(b);
    const ElementVectors<N> xe =
        load_elements<N>(position, blocks.local_node.data() + static_cast<std::ptrdiff_t>(b) * N * lanes);
    Pack volume{};
    for (int q = 0; q < Shape<N>::points; ++q) volume += load(data + (q * 10 + 9) * lanes);
    const auto is_real = volume > Pack{};
    volume = is_real ? volume : broadcast<Pack>(1.0);
    const Pack size = exponential(logarithm(volume) * (1.0 / 3.0));

    ElementVectors<N> y;   // start: no symmetry of the element, no rigid motion
    for (int a = 0; a < N; ++a)
      for (int i = 0; i < 3; ++i) y.a[a][i] = broadcast<Pack>(std::sin(1.0 + 3.7 * a + 1.9 * i * (a + 1)));
    BlockSums unused;
    const auto control = [&](int, const Deformation<Pack>& d, PackInt, Tensor<Pack>& P) {
      PackInt is_active;
      distortion_control(law, d, P, is_active);
    };
    Pack eigenvalue{};
    for (int round = 0; round < rounds; ++round) {
      Pack norm2{};
      for (int a = 0; a < N; ++a)
        for (int i = 0; i < 3; ++i) norm2 += y.a[a][i] * y.a[a][i];
      const Pack inverse_norm = 1.0 / square_root(maximum(norm2, 1e-300));
      const Pack epsilon = relative_displacement * size * inverse_norm;
      ElementVectors<N> plus, minus, force_plus, force_minus;
      for (int a = 0; a < N; ++a)
        for (int i = 0; i < 3; ++i) {
          const Pack shift = epsilon * y.a[a][i] * (1.0 / root_share[a]);
          plus.a[a][i] = xe.a[a][i] + shift;
          minus.a[a][i] = xe.a[a][i] - shift;
        }
      block_forces<N>(law, data, plus, force_plus, unused, 0, control);
      block_forces<N>(law, data, minus, force_minus, unused, 0, control);
      Pack image2{};
      const Pack scale = 1.0 / (2.0 * relative_displacement * size);
      for (int a = 0; a < N; ++a)
        for (int i = 0; i < 3; ++i) {
          y.a[a][i] = (force_minus.a[a][i] - force_plus.a[a][i]) * scale * (1.0 / root_share[a]);
          image2 += y.a[a][i] * y.a[a][i];
        }
      eigenvalue = square_root(image2);
    }
    const double density = materials[blocks.block_material[b]].density;
    for (int lane = 0; lane < lanes; ++lane) {
      const std::int32_t e = blocks.element[b * lanes + lane];
      if (e < 0) continue;
      const double step = 2 * std::sqrt(density * volume[lane] / std::max(eigenvalue[lane], 1e-300));
      if (!element_steps.empty()) element_steps[e] = step;
      shortest = std::min(shortest, step);
    }
  }
  return shortest;
}

double LeafletSolid::critical_step(std::span<const double> x, std::span<double> element_steps, int rounds) {
  Data& d = *data_;
  assert(element_steps.empty() || static_cast<long>(element_steps.size()) == d.blocks.element_count);
  parallel_for(
      static_cast<std::ptrdiff_t>(d.blocks.tiles.size()),
      [&](std::ptrdiff_t t) {
        d.tile_steps[t] = d.blocks.nodes == 10 ? d.tile_step<10>(d.blocks.tiles[t], x.data(), element_steps, rounds)
                                               : d.tile_step<4>(d.blocks.tiles[t], x.data(), element_steps, rounds);
      },
      2);
  return *std::min_element(d.tile_steps.begin(), d.tile_steps.end());
}

// --- access

long LeafletSolid::node_count() const { return data_->blocks.node_count; }
long LeafletSolid::element_count() const { return data_->blocks.element_count; }
const SolidStatistics& LeafletSolid::statistics() const { return data_->statistics; }
const std::vector<double>& LeafletSolid::node_volumes() const { return data_->node_volumes; }
const std::vector<double>& LeafletSolid::node_masses() const { return data_->node_masses; }
const std::vector<double>& LeafletSolid::element_volumes() const { return data_->element_volumes; }
const SolidMesh& LeafletSolid::mesh() const { return data_->mesh; }
const std::vector<Material>& LeafletSolid::materials() const { return data_->materials; }

}   // namespace mv
