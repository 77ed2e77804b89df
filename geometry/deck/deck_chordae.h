// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>

#include "geometry/deck/deck_valve.h"

namespace mv {

/// Fills valve.chordae, tips and tip_displacement from trusses, beams and connectors. Internal to geometry/deck. `point_of`: mid-surface point per deck node
/// or -1; `held`: displacement (mm) of the held nodes.
void collect_chordae(const AbaqusDeck& deck, const DeckValveOptions& options, const DeckUnits& units, const std::vector<int>& point_of,
                     const std::vector<int>& section, const std::map<int, Vec3>& held, DeckValve& valve);

/// The same chordae on a mesh thickened from the valve's mid-surface by `layers` levels (point of level l = l n + i): each leaflet end hangs on the nodes of its
/// column, with the shares of the column's mass. Kind: primary at the free edge, else secondary.
Chordae hang_chordae(const DeckValve& valve, const LeafletMesh& mesh, int layers);

}  // namespace mv
