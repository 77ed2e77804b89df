// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// One list per node (or per slot of a tree of nodes), all in one array, filled by several threads.

#include <algorithm>
#include <utility>
#include <vector>

#include "geometry/core/parallel.h"

namespace mv {

/// Entries of node n: entry[start[n] .. start[n + 1]), for `nodes` nodes. `fill(n, list)` appends those of node n to `list`. Nodes are handed out in pieces of 256, in ascending order within each, so that
/// threads share work that is bunched up; the result does not depend on them. `scratch` keeps its memory between calls.
template <class Entry, class Fill>
void fill_node_lists(int nodes, std::vector<std::vector<Entry>>& scratch, std::vector<int>& start, std::vector<Entry>& entry, const Fill& fill) {
  constexpr std::ptrdiff_t piece = 256;
  const std::ptrdiff_t pieces = (nodes + piece - 1) / piece;
  scratch.resize(static_cast<std::size_t>(pieces));
  start.resize(static_cast<std::size_t>(nodes) + 1);
  start[0] = 0;
  const auto last = [&](std::ptrdiff_t p) { return std::min<std::ptrdiff_t>(nodes, (p + 1) * piece); };
  parallel_pieces(
      pieces, 1,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        for (std::ptrdiff_t p = begin; p < end; ++p) {
          // Moved here and back: threads would share the cache line of neighbouring vectors.
          std::vector<Entry> list = std::move(scratch[static_cast<std::size_t>(p)]);
          list.clear();
          for (std::ptrdiff_t n = p * piece; n < last(p); ++n) {
            const std::size_t before = list.size();
            fill(static_cast<int>(n), list);
            start[static_cast<std::size_t>(n) + 1] = static_cast<int>(list.size() - before);
          }
          scratch[static_cast<std::size_t>(p)] = std::move(list);
        }
      },
      2);
  for (std::size_t n = 0; n < static_cast<std::size_t>(nodes); ++n) start[n + 1] += start[n];
  entry.resize(static_cast<std::size_t>(start.back()));
  parallel_pieces(
      pieces, 1,
      [&](std::ptrdiff_t begin, std::ptrdiff_t end, int) {
        for (std::ptrdiff_t p = begin; p < end; ++p) {
          const auto& list = scratch[static_cast<std::size_t>(p)];
          std::copy(list.begin(), list.end(), entry.begin() + start[static_cast<std::size_t>(p * piece)]);
        }
      },
      2);
}

}  // namespace mv
