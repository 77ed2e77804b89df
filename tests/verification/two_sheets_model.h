// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Two parallel vertical sheets that a pressure p presses together, in a slab (slab_flow.h). SI units.
//
// clang-format off
//        z                 atrium, 0                    Both ends of each sheet are held. In blood, held blocks join the sheets'
//        |   ####|  |    |  |####  <- blocks            tops to the side walls and a held foot closes the film below: the blood
//        |       |  |film|  |                           outside the sheets has the pressure p of the ventricle, and the film is
//        |   p   |  |    |  |   p                       open to the atrium at the top only. Dry: p acts on the outer faces, the
//        |       |__|____|__|                           nodes move on their own damped mass.
//        |       ############      <- foot
//        |          ventricle, p
//        +-------------------------- x
// clang-format on
//
// On the grid the kernels of the held tops close the opening, too, as they do where leaflets meet at a real hinge: the film's
// blood stays, and its pressure follows from the balance of forces.
//
// What crosses the film in the middle of the belt. In one dimension the blood at rest obeys dp/dx = f. A sheet's own stresses add
// up to nothing over its thickness, so the pressure halfway is p_mid = p + p_c,grid, p_c,grid the pressure that the spread
// contact forces alone produce halfway (they are f = grad p_c,grid, negative between the faces):
//     p_mid - p_c,grid = p    whatever share the penalty carries.
// With faces closer than the kernel the two sheets' contact forces cancel on the grid, p_c,grid is near zero, and p_mid near p
// although the penalty carries all of p: the grid's pressure halfway is no film pressure then, and adding it to the penalty
// counts p twice.

#include "verification/slab_flow.h"

namespace mv::test {

struct TwoSheetsSpec {
  double h = 1e-3;          // m, fluid spacing (dry: what threshold and mesh follow from)
  double pressure = 16e3;   // Pa, p: 120 mmHg
  double thickness = 1e-3;  // m
  double length = 32e-3;    // m, of the sheets
  double gap = 1.0;         // cells, between the faces at rest: where interpolation would leave them
  int cells_deep = 3;
  Kernel kernel = Kernel::ib4;
  bool is_drained = true;
  Relaxation relaxation = Relaxation::all_forces;
  double ramp = 5e-3;           // s, until p is reached
  double drainage_time = 5e-3;  // s, default of coupling.drainage_time
};

/// Averages over the middle half of the belt, present state.
struct BeltMeans {
  double penalty = 0;                       // Pa, SelfContact::pressure over the facing faces
  double gap = 0;                           // m, between opposite nodes
  double film = 0;                          // Pa, pressure_at halfway
  double contact_on_grid = 0;               // Pa, p_c,grid halfway: negative where contact pushes the faces apart
  double sum_min = 0, sum_max = 0;          // Pa, extremes of film - contact_on_grid over points and times
  double penalty_min = 0, penalty_max = 0;  // Pa, extremes over nodes and times
  double sum() const { return film - contact_on_grid; }
};

struct TwoSheets {
  SlabTissue tissue;
  Plate left, right;
  std::vector<double> held_points;
  FluidGrid grid;
};
TwoSheets make_two_sheets(const TwoSheetsSpec& spec);

/// As Structure sets them for a case with spacing h (solver/time/structure.cpp).
ContactOptions sheet_contact(const TwoSheetsSpec& spec);
Material sheet_material();

/// Ramps p and runs in blood to `end` (s) with steps `dt`; the means are taken over the last fifth of the time.
BeltMeans press_in_blood(const TwoSheetsSpec& spec, double dt, double end);
/// The same without blood; `film` and `contact_on_grid` stay zero.
BeltMeans press_dry(const TwoSheetsSpec& spec, double dt, double end);

}  // namespace mv::test
