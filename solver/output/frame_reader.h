// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Reads back what FrameWriter wrote, for the report and for checks. Units as in the files: mm, kPa, N, mmHg, m/s; world frame.
// All readers check array sizes, index ranges and finiteness and throw InputError naming file and array, IoError when unreadable.

#include <array>
#include <filesystem>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

struct LeafletsFrame {
  double time = 0;  // s
  Vec3 annulus_origin = Vec3::Zero();
  Vec3 annulus_normal = -Vec3::UnitZ();  // atrium -> ventricle
  LeafletMesh mesh;                      // points deformed; fibre and sheet_normal empty
  std::vector<Vec3> displacement;        // mm
  // empty when the frame does not carry them
  std::vector<Vec3> contact_force;       // N per point
  std::vector<double> contact_pressure;  // kPa per point
  std::vector<double> von_mises;         // kPa per element
  std::vector<double> fibre_stress;      // kPa per element
};

struct ChordaeFrame {
  double time = 0;
  std::vector<Vec3> points;          // mm
  std::vector<int> muscle_of_point;  // papillary tip index for a root point, else -1
  std::vector<std::array<int, 2>> segments;
  std::vector<ChordaKind> kind;  // per segment
  std::vector<double> tension;   // N per segment, may be empty
};

struct FluidFrame {
  double time = 0;
  Vec3 lower = Vec3::Zero();     // world position of the grid's lower corner, mm
  Mat3 axes = Mat3::Identity();  // rows: grid directions in the world frame
  std::array<int, 3> cells{0, 0, 0};
  double spacing = 0;            // mm
  std::vector<Vec3> velocity;    // m/s, world components, per cell, first index fastest
  std::vector<double> pressure;  // mmHg
  std::vector<char> inside;      // empty, or 1 in blood
};

LeafletsFrame read_leaflets_frame(const std::filesystem::path& file);
ChordaeFrame read_chordae_frame(const std::filesystem::path& file);
FluidFrame read_fluid_frame(const std::filesystem::path& file);

}  // namespace mv
