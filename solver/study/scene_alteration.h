// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Ways to make a sound scene extreme or wrong, for the stability study and tests. What a configuration cannot ask for, because mvprep would
// refuse it.

#include "solver/time/scene.h"

namespace mv {

/// Moves some twelve nodes into their elements until the smallest dihedral angle around each is `degrees`; 0 flattens an element, a negative
/// value inverts it.
void squash_elements(Scene& scene, double degrees);

/// Shears the middle of the anterior leaflet towards the posterior one, by up to `distance` (mm) at its border; volumes stay.
void bring_together(Scene& scene, double distance);

/// As far as that goes without crossing triangles, less a twentieth of a millimetre: borders touch within the contact's range.
void bring_to_touch(Scene& scene);

/// Leaves one chorda, the primary one of the anterior leaflet nearest to its middle.
void keep_one_chorda(Scene& scene);

/// Pressure of many short beats (stability_cases.h), written into the case as pressure.csv: closes, holds its peak, opens at -5 mmHg.
void set_beats(Scene& scene, int count, double length, double peak_mmHg);

}  // namespace mv
