// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What can be known before a run to be wrong, so that no time is spent on it and no answer looks right that is not.

#include "solver/time/scene.h"
#include "solver/time/waveform.h"

namespace mv {

/// Checks a scene before its first step; logs what is allowed but harms (solid points too far apart for the fluid's grid). Throws
///   ConfigError  settings that cannot be solved as meant: a tissue with negative Poisson's ratio, tissue much heavier or lighter than
///                the blood it moves with, pressures beyond physiology by a wrong unit, more steps or memory than a machine has;
///   GateError    geometry: flat or inverted elements, leaflets that cross at the start or lie outside the tube, no room to move.
/// Every message names the key or place, the value, the bound and the remedy.
void preflight(const Scene& scene, const Waveform& waveform);

/// Smallest dihedral angle (degrees) of a tetrahedron; 0 when it is flat, negative when it is inverted.
double smallest_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace mv
