// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/core/config.h"
#include "geometry/deck/deck_valve.h"
#include "pipeline/source_file.h"

namespace mv {

/// The valve in deck.file. Throws ConfigError when the key is empty, and what read_abaqus_deck() and build_deck_valve() throw.
DeckValve read_deck_valve(const Config& config);

/// The deck's own nodes as mid-surface, with flat pattern, normals and tips; with deck.remesh what make_patient_source() makes of them (two leaflets
/// only: ConfigError otherwise).
SourceGeometry make_deck_source(const Config& config);

/// The deck's trusses on leaflets made from its mid-surface. Throws ConfigError when the leaflets are not (other source.kind, deck.remesh).
Chordae make_deck_chordae(const Config& config, const LeafletMesh& mesh);

/// The deck's orientations as fibres, on leaflets made from its mid-surface. Throws ConfigError when they are not, InputError when sections have none.
void take_deck_fibres(const Config& config, LeafletMesh& mesh);

}  // namespace mv
