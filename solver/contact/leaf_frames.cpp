// SPDX-License-Identifier: BSD-3-Clause
#include "solver/contact/leaf_frames.h"

#include "geometry/core/parallel.h"

namespace mv {

SurfaceFrames::SurfaceFrames(const ContactSurface& surface, const BoxTree& tree, std::span<const double> radius)
    : tree_(tree), corner_(static_cast<std::size_t>(tree.leaf_count())), radius_(static_cast<std::size_t>(tree.slot_count()), 0.0) {
  for (std::size_t slot = 0; slot < radius_.size(); ++slot) {
    const int f = tree.item(static_cast<int>(slot));
    if (f < 0) continue;
    for (std::size_t k = 0; k < 3; ++k)
      corner_[slot / BoxTree::width][k][slot % BoxTree::width] = 3 * surface.nodes[static_cast<std::size_t>(surface.triangles[static_cast<std::size_t>(f)][k])];
    radius_[slot] = radius[static_cast<std::size_t>(f)];
  }
  frames_.resize(static_cast<std::size_t>(tree.leaf_count()));
  heads_.resize(frames_.size());
  normals_.resize(surface.triangles.size());
}

void SurfaceFrames::fit(int leaf, std::span<const double> x) {
  constexpr int width = BoxTree::width;
  const auto& corners = corner_[static_cast<std::size_t>(leaf)];
  LeafFrames& out = frames_[static_cast<std::size_t>(leaf)];
  alignas(64) double head[7][width], area2[width];  // centre, normal, size
  for (int h = 0; h < width; h += lanes) {
    Pack a[3], b[3], c[3], e1[3], e2[3], m[3], centre[3];
    for (int i = 0; i < 3; ++i) {
      a[i] = gather(x.data() + i, corners[0].data() + h);
      b[i] = gather(x.data() + i, corners[1].data() + h);
      c[i] = gather(x.data() + i, corners[2].data() + h);
      e1[i] = b[i] - a[i];
      e2[i] = c[i] - a[i];
      centre[i] = (a[i] + b[i] + c[i]) * (1.0 / 3.0);
    }
    Pack squared{};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      m[i] = e1[j] * e2[k] - e1[k] * e2[j];
      squared += m[i] * m[i];
    }
    const Pack twice = square_root(squared);
    const Pack inverse = select(twice > Pack{}, 1.0 / maximum(twice, 1e-300), Pack{});
    const auto far = [&](const Pack(&p)[3]) {
      Pack sum{};
      for (int i = 0; i < 3; ++i) sum += (p[i] - centre[i]) * (p[i] - centre[i]);
      return sum;
    };
    const Pack size = square_root(maximum(far(a), maximum(far(b), far(c)))) + load(radius_.data() + leaf * width + h);
    Pack g11{}, g12{}, g22{};
    for (int i = 0; i < 3; ++i) {
      g11 += e1[i] * e1[i];
      g12 += e1[i] * e2[i];
      g22 += e2[i] * e2[i];
      const Pack n = m[i] * inverse;
      const auto at = static_cast<std::size_t>(i);
      store(out.a[at].data() + h, a[i]);
      store(out.e1[at].data() + h, e1[i]);
      store(out.e2[at].data() + h, e2[i]);
      store(out.n[at].data() + h, n);
      store(head[i] + h, centre[i]);
      store(head[3 + i] + h, n);
    }
    store(out.g11.data() + h, g11);
    store(out.g12.data() + h, g12);
    store(out.g22.data() + h, g22);
    store(out.inverse_det.data() + h, inverse * inverse);
    store(head[6] + h, size);
    store(area2 + h, twice);
  }
  LeafHeads& small = heads_[static_cast<std::size_t>(leaf)];
  for (int c = 0; c < 3; ++c)
    for (int lane = 0; lane < width; ++lane) {
      small.centre[static_cast<std::size_t>(c)][static_cast<std::size_t>(lane)] = static_cast<float>(head[c][lane]);
      small.normal[static_cast<std::size_t>(c)][static_cast<std::size_t>(lane)] = static_cast<float>(head[3 + c][lane]);
    }
  for (int lane = 0; lane < width; ++lane) {
    small.size[static_cast<std::size_t>(lane)] = static_cast<float>(head[6][lane]);
    const int f = tree_.item(leaf * width + lane);
    if (f >= 0) normals_[static_cast<std::size_t>(f)] = {{head[3][lane], head[4][lane], head[5][lane]}, area2[lane]};
  }
}

void SurfaceFrames::update(std::span<const double> x) {
  parallel_for(tree_.leaf_count(), [&](std::ptrdiff_t leaf) { fit(static_cast<int>(leaf), x); }, 32);
}

}  // namespace mv
