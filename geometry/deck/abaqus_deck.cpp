// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/deck/abaqus_deck.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "geometry/core/config.h"  // nearest_name
#include "geometry/deck/deck_parser.h"

namespace mv {

double DeckAmplitude::at(double time) const {
  if (times.empty()) return 1;
  if (time <= times.front()) return values.front();
  if (time >= times.back()) return values.back();
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  const double s = (time - times[after - 1]) / (times[after] - times[after - 1]);
  const double share = is_smooth ? s * s * s * (10 - 15 * s + 6 * s * s) : s;
  return values[after - 1] + share * (values[after] - values[after - 1]);
}

std::vector<int> AbaqusDeck::section_of_element() const {
  std::vector<int> section(elements.size(), -1);
  for (std::size_t s = 0; s < sections.size(); ++s)
    for (const int e : element_set(sections[s].elset, sections[s].place)) section[static_cast<std::size_t>(e)] = static_cast<int>(s);
  return section;
}

const std::vector<int>& AbaqusDeck::element_set(const std::string& name, const DeckPlace& place) const {
  const auto found = element_sets.find(deck_name(name));
  if (found != element_sets.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [set, members] : element_sets) known.push_back(set);
  lines.fail(place, fmt::format("there is no element set '{}'{}", name, known.empty() ? "" : "; did you mean '" + nearest_name(deck_name(name), known) + "'?"));
}

AbaqusDeck read_abaqus_deck(const std::filesystem::path& file) {
  AbaqusDeck deck;
  deck.lines = read_deck_lines(file);
  DeckParser(deck).run();
  return deck;
}

}  // namespace mv
