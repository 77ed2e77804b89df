// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What a deck says besides its mesh, as settings of the case: thickness, laws, densities, friction, pressure, motion. A key that the configuration gives stands.

#include <vector>

#include "geometry/core/config.h"
#include "pipeline/case_directory.h"

namespace mv {

struct DeckSettings {
  Config config;
  std::vector<MadeInput> made;  // motion tables, and the deck with its includes in one file
};

/// The same configuration for any source but "deck". Logs what is taken from the deck, and warns of what is not understood. Throws as read_deck_valve().
DeckSettings deck_settings(const Config& config);

}  // namespace mv
