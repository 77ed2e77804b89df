// SPDX-License-Identifier: BSD-3-Clause
#include "solver/seal/holes.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "solver/seal/minimum_cut.h"

namespace mv::seal {

namespace {

enum Label : std::uint8_t { closed = 0, open = 1, atrium = 2, ventricle = 3 };

constexpr std::size_t cut_cells_wanted = 150'000;
/// Voxels with less room than this share are solid for the cut.
constexpr float least_share = 0.02f;

/// A dense box of voxels cut out of the grid.
struct Box {
  std::array<int, 3> low{0, 0, 0}, n{0, 0, 0};
  std::size_t size() const {
    return static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  }
  bool holds(int i, int j, int k) const {
    return i >= low[0] && i < low[0] + n[0] && j >= low[1] && j < low[1] + n[1] && k >= low[2] && k < low[2] + n[2];
  }
  std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k - low[2]) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j - low[1])) *
               static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(i - low[0]);
  }
};

/// Voxels reached from the atrial end by a ball of radius `level`; false when they do not reach the ventricular end.
bool flood_open(const VoxelField& field, double level, std::vector<std::uint8_t>& label) {
  const VoxelGrid& grid = field.grid();
  label.assign(static_cast<std::size_t>(grid.size()), closed);
  std::vector<std::uint8_t> refused(label.size(), 0);
  std::vector<Voxel> stack;
  const auto visit = [&](Voxel v) {
    const auto s = static_cast<std::size_t>(v);
    if (label[s] != closed || refused[s] || field.is_wall(v)) return;
    if (!field.peak_reaches(v, level)) {
      refused[s] = 1;
      return;
    }
    label[s] = open;
    stack.push_back(v);
  };
  const Voxel layer = grid.n[0] * grid.n[1];
  for (Voxel v = grid.size() - layer; v < grid.size(); ++v) visit(v);
  bool through = false;
  while (!stack.empty()) {
    const Voxel v = stack.back();
    stack.pop_back();
    through = through || v < layer;
    grid.neighbours(v, [&](Voxel w, int) { visit(w); });
  }
  return through;
}

/// Flooding by falling clearance from both ends (Meyer 1994): the two colours meet where the way is narrowest.
void shed_from_both_ends(const VoxelField& field, std::vector<std::uint8_t>& label) {
  struct Entry {
    float level;
    std::int64_t order;  // first come, first served among equals
    Voxel voxel;
    std::uint8_t colour;
    bool operator<(const Entry& o) const { return level != o.level ? level < o.level : order > o.order; }
  };
  const VoxelGrid& grid = field.grid();
  std::priority_queue<Entry> queue;
  std::int64_t order = 0;
  const auto push = [&](Voxel v, std::uint8_t colour) {
    if (label[static_cast<std::size_t>(v)] == open) queue.push({field.cheap_peak(v), order++, v, colour});
  };
  const Voxel layer = grid.n[0] * grid.n[1];
  for (Voxel v = 0; v < layer; ++v) {
    push(v, ventricle);
    push(grid.size() - layer + v, atrium);
  }
  while (!queue.empty()) {
    const Entry e = queue.top();
    queue.pop();
    if (label[static_cast<std::size_t>(e.voxel)] != open) continue;
    label[static_cast<std::size_t>(e.voxel)] = e.colour;
    grid.neighbours(e.voxel, [&](Voxel w, int) { push(w, e.colour); });
  }
}

/// Groups of atrial voxels next to ventricular ones, joined over faces, edges and corners.
std::vector<std::vector<Voxel>> meeting_places(const VoxelGrid& grid, const std::vector<std::uint8_t>& label) {
  std::vector<std::uint8_t> waiting(label.size(), 0);
  std::vector<Voxel> all;
  for (Voxel v = 0; v < grid.size(); ++v) {
    if (label[static_cast<std::size_t>(v)] != atrium) continue;
    grid.neighbours(v, [&](Voxel w, int) {
      if (label[static_cast<std::size_t>(w)] != ventricle || waiting[static_cast<std::size_t>(v)]) return;
      waiting[static_cast<std::size_t>(v)] = 1;
      all.push_back(v);
    });
  }
  std::vector<std::vector<Voxel>> groups;
  for (Voxel seed : all) {
    if (!waiting[static_cast<std::size_t>(seed)]) continue;
    waiting[static_cast<std::size_t>(seed)] = 0;
    std::vector<Voxel> group{seed};
    for (std::size_t q = 0; q < group.size(); ++q) {
      const auto c = grid.indices(group[q]);
      for (int k = std::max(0, c[2] - 1); k <= std::min(grid.n[2] - 1, c[2] + 1); ++k)
        for (int j = std::max(0, c[1] - 1); j <= std::min(grid.n[1] - 1, c[1] + 1); ++j)
          for (int i = std::max(0, c[0] - 1); i <= std::min(grid.n[0] - 1, c[0] + 1); ++i) {
            const Voxel w = grid.at(i, j, k);
            if (!waiting[static_cast<std::size_t>(w)]) continue;
            waiting[static_cast<std::size_t>(w)] = 0;
            group.push_back(w);
          }
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

double widest_at(const VoxelField& field, const std::vector<std::uint8_t>& label, const std::vector<Voxel>& group) {
  float best = 0;
  const auto slack = static_cast<float>(half_diagonal * field.grid().h);
  for (Voxel v : group)
    field.grid().neighbours(v, [&](Voxel w, int) {
      if (label[static_cast<std::size_t>(w)] != ventricle || std::min(field.distance(v), field.distance(w)) + slack <= best)
        return;
      best = std::max(best, std::min(field.peak(v), field.peak(w)));
    });
  return 2 * best;
}

/// The minimum cut through one meeting place. Cells: everything a ball of radius `level` touches on its way, within reach of the
/// meeting place; the rim of that neighbourhood is fixed to the colours.
class LocalCut {
 public:
  LocalCut(const VoxelField& field, const std::vector<std::uint8_t>& label, const std::vector<Voxel>& group, double level,
           double reach)
      : field_(field), grid_(field.grid()), steps_(static_cast<int>(std::ceil(1.5 * reach / grid_.h))) {
    choose_box(group, level);
    colour(label, level);
    spread_from(group);
  }

  Opening solve(const SealOptions& options) {
    CutProblem problem = pose();
    std::size_t active = 0;
    for (auto s : problem.state) active += s != cut_empty;
    int factor = 1;
    for (; active > cut_cells_wanted && factor < 4; factor *= 2) {
      problem = coarsen(problem);
      active /= 8;
    }
    const CutResult cut = solve_minimum_cut(problem, options.cut_gap, options.max_cut_iterations);
    const double h = factor * grid_.h;
    Opening out;
    out.area = cut.area * h * h;
    out.area_error = (cut.area - cut.lower) * h * h;
    const Vec3 corner = grid_.lower + grid_.h * Vec3(box_.low[0], box_.low[1], box_.low[2]);
    double weight = 0;
    for (int k = 0; k < problem.n[2]; ++k)
      for (int j = 0; j < problem.n[1]; ++j)
        for (int i = 0; i < problem.n[0]; ++i)
          if (const double d = cut.density[problem.at(i, j, k)]; d > 0) {
            out.place += d * (corner + h * Vec3(i + 0.5, j + 0.5, k + 0.5));
            weight += d;
          }
    if (weight > 0) out.place /= weight;
    return out;
  }

 private:
  void choose_box(const std::vector<Voxel>& group, double level) {
    std::array<int, 3> lo = grid_.indices(group[0]), hi = lo;
    for (Voxel v : group) {
      const auto c = grid_.indices(v);
      for (std::size_t d = 0; d < 3; ++d) {
        lo[d] = std::min(lo[d], c[d]);
        hi[d] = std::max(hi[d], c[d]);
      }
    }
    const int more = steps_ + 2 + static_cast<int>(std::ceil(level / grid_.h));
    for (std::size_t d = 0; d < 3; ++d) {
      box_.low[d] = std::max(0, lo[d] - more);
      box_.n[d] = std::min(grid_.n[d] - 1, hi[d] + more) - box_.low[d] + 1;
    }
  }

  // Colours of the box: the flooded voxels, and around them what the ball touches, each with the colour of a near flooded voxel.
  void colour(const std::vector<std::uint8_t>& label, double level) {
    colour_.assign(box_.size(), closed);
    constexpr int farther = 1 << 20;
    std::vector<int> best(box_.size(), farther + 1);
    share_.assign(box_.size(), -1.0f);
    const double radius = level / grid_.h + 1;
    const int r = static_cast<int>(radius);
    for_each([&](int i, int j, int k) {
      const Voxel v = grid_.at(i, j, k);
      const std::uint8_t own = label[static_cast<std::size_t>(v)];
      if (own < atrium) return;
      colour_[box_.at(i, j, k)] = own;
      best[box_.at(i, j, k)] = 0;
      bool rim = false;
      grid_.neighbours(v, [&](Voxel w, int) { rim = rim || label[static_cast<std::size_t>(w)] < atrium; });
      if (!rim) return;
      for (int c = -r; c <= r; ++c)
        for (int b = -r; b <= r; ++b)
          for (int a = -r; a <= r; ++a) {
            const int d2 = a * a + b * b + c * c;
            if (d2 > radius * radius || !box_.holds(i + a, j + b, k + c)) continue;
            const std::size_t s = box_.at(i + a, j + b, k + c);
            if (d2 >= best[s] || field_.is_wall(grid_.at(i + a, j + b, k + c))) continue;
            if (best[s] > farther && share_of(s, i + a, j + b, k + c) < least_share) continue;
            best[s] = d2;
            colour_[s] = own;
          }
    });
  }

  // Distance in steps from the meeting place. Where the colours meet elsewhere there is another hole or a chink narrower than the
  // threshold: the way across stays shut there.
  void spread_from(const std::vector<Voxel>& group) {
    steps_from_.assign(box_.size(), -1);
    std::vector<std::array<int, 3>> front;
    const auto add = [&](int i, int j, int k, int steps) {
      if (!box_.holds(i, j, k)) return;
      const std::size_t s = box_.at(i, j, k);
      if (steps_from_[s] >= 0 || colour_[s] == closed) return;
      steps_from_[s] = steps;
      front.push_back({i, j, k});
    };
    for (Voxel v : group) {
      const auto c = grid_.indices(v);
      add(c[0], c[1], c[2], 0);
    }
    // The meeting place continues over the voxels the ball touches besides the flooded ones.
    for (std::size_t q = 0; q < front.size(); ++q) {
      const auto c = front[q];
      for (int d = 0; d < 27; ++d) {
        const int i = c[0] + d % 3 - 1, j = c[1] + d / 3 % 3 - 1, k = c[2] + d / 9 - 1;
        if (box_.holds(i, j, k) && meets_other(i, j, k)) add(i, j, k, 0);
      }
    }
    for (std::size_t q = 0; q < front.size(); ++q) {
      const auto c = front[q];
      const int steps = steps_from_[box_.at(c[0], c[1], c[2])] + 1;
      if (steps > steps_) continue;
      for (std::size_t d = 0; d < 3; ++d)
        for (int side : {-1, 1}) {
          auto e = c;
          e[d] += side;
          if (!box_.holds(e[0], e[1], e[2])) continue;
          const std::size_t s = box_.at(c[0], c[1], c[2]), t = box_.at(e[0], e[1], e[2]);
          if (!may_cross(s, t)) continue;
          add(e[0], e[1], e[2], steps);
        }
    }
  }

  bool meets_other(int i, int j, int k) const {
    const std::uint8_t own = colour_[box_.at(i, j, k)];
    if (own == closed) return false;
    for (std::size_t d = 0; d < 3; ++d)
      for (int side : {-1, 1}) {
        std::array<int, 3> e{i, j, k};
        e[d] += side;
        if (!box_.holds(e[0], e[1], e[2])) continue;
        const std::uint8_t other = colour_[box_.at(e[0], e[1], e[2])];
        if (other != closed && other != own) return true;
      }
    return false;
  }

  bool may_cross(std::size_t s, std::size_t t) const {
    return colour_[s] == colour_[t] || steps_from_[s] == 0 || steps_from_[t] == 0;
  }

  float share_of(std::size_t s, int i, int j, int k) {
    if (share_[s] < 0) share_[s] = static_cast<float>(field_.open_fraction(grid_.at(i, j, k)));
    return share_[s];
  }

  CutProblem pose() {
    CutProblem problem(box_.n);
    std::vector<float>& share = share_;
    for_each([&](int i, int j, int k) {
      const std::size_t s = box_.at(i, j, k);
      if (steps_from_[s] < 0) return;
      share_of(s, i, j, k);
      problem.start[s] = colour_[s] == atrium ? 1.0f : 0.0f;
      const bool end = k == 0 || k == grid_.n[2] - 1;
      const bool rim = steps_from_[s] >= steps_;
      problem.state[s] = share[s] < least_share ? cut_empty
                         : !(rim || end)        ? cut_free
                         : colour_[s] == atrium ? cut_one
                                                : cut_zero;
    });
    for_each([&](int i, int j, int k) {
      const std::size_t s = box_.at(i, j, k);
      if (problem.state[s] == cut_empty) return;
      for (std::size_t d = 0; d < 3; ++d) {
        std::array<int, 3> e{i, j, k};
        e[d] += 1;
        if (!box_.holds(e[0], e[1], e[2])) continue;
        const std::size_t t = box_.at(e[0], e[1], e[2]);
        if (problem.state[t] != cut_empty && may_cross(s, t))
          problem.weight[d][s] = share[s] >= 1 && share[t] >= 1
                                     ? 1.0f
                                     : static_cast<float>(field_.open_face(grid_.at(i, j, k), static_cast<int>(d)));
      }
    });
    return problem;
  }

  template <class Visit>
  void for_each(Visit&& visit) const {
    for (int k = box_.low[2]; k < box_.low[2] + box_.n[2]; ++k)
      for (int j = box_.low[1]; j < box_.low[1] + box_.n[1]; ++j)
        for (int i = box_.low[0]; i < box_.low[0] + box_.n[0]; ++i) visit(i, j, k);
  }

  const VoxelField& field_;
  const VoxelGrid& grid_;
  int steps_;
  Box box_;
  std::vector<std::uint8_t> colour_;
  std::vector<int> steps_from_;
  std::vector<float> share_;  // open share, -1 where not asked for
};

}  // namespace

std::vector<Opening> find_openings(const VoxelField& field, double threshold, const SealOptions& options) {
  const double level = 0.5 * threshold, h = field.grid().h;
  std::vector<std::uint8_t> label;
  if (!flood_open(field, level, label)) return {};
  shed_from_both_ends(field, label);
  std::vector<Opening> openings;
  for (const auto& group : meeting_places(field.grid(), label)) {
    const double reach = std::max(6 * h, 0.6 * std::sqrt(static_cast<double>(group.size())) * h);
    Opening opening = LocalCut(field, label, group, level, reach).solve(options);
    opening.width = widest_at(field, label, group);
    openings.push_back(opening);
  }
  std::sort(openings.begin(), openings.end(), [](const Opening& a, const Opening& b) { return a.area > b.area; });
  return openings;
}

}  // namespace mv::seal
