// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Writes the time-resolved VTK files of RESULTS/: frames/leaflets_NNNN.vtu, frames/chordae_NNNN.vtp, frames/fluid_NNNN.vti and
// the collections leaflets.pvd, chordae.pvd, fluid.pvd (times in seconds). Input is SI in the solver's frame; files are mm, kPa,
// mmHg, m/s, N in the world (RAS) frame. A file appears under its name only when it is complete, and a .pvd names only files that
// exist.

#include <array>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Rigid frame of the solver: x_solver = axes * (x_world - origin). `origin` in mm, rows of `axes` orthonormal and right-handed.
/// The default is the world frame itself; Tube::origin and Tube::axes give the tube's frame.
struct SolverFrame {
  Vec3 origin = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};

/// Leaflets at one instant, SI, solver frame. Vectors are xyz-interleaved, three numbers per mesh point. Any span but `positions`
/// may be empty, and its array is then left out of the file. Per element: mean over its quadrature points.
struct LeafletsState {
  double time = 0;                            // s
  std::span<const double> positions;          // m, 3 per point
  std::span<const double> velocities;         // m/s, 3 per point
  std::span<const double> contact_forces;     // N, 3 per point: what crosses the belt (penalty + film)
  std::span<const double> contact_pressures;  // Pa per point
  std::span<const double> von_mises;          // Pa per element
  std::span<const double> fibre_stresses;     // Pa per element, Cauchy stress along the deformed fibre
  std::span<const double> fibre_strains;      // 1 per element, fibre stretch minus one
  std::span<const double> volume_ratios;      // J per element
};

/// Chordae at one instant: positions of all Chordae::points (m, xyz-interleaved, solver frame), tension per segment (N; may be
/// empty).
struct ChordaeState {
  double time = 0;
  std::span<const double> positions;
  std::span<const double> tensions;
};

/// Uniform grid of the fluid in the solver frame (m): cell (i, j, k) covers lower + spacing * [i, i+1] x [j, j+1] x [k, k+1].
struct FluidGridView {
  Vec3 lower = Vec3::Zero();
  std::array<int, 3> cells{0, 0, 0};
  double spacing = 0;
};

/// Fluid at one instant, by value at cell centres, SI, solver frame. `is_blood` may be empty (every cell inside the tube); else
/// its answer goes to the cell array `inside` (1 blood, 0 beyond the tube's wall).
struct FluidState {
  double time = 0;
  FluidGridView grid;
  std::function<Vec3(int, int, int)> velocity;    // m/s
  std::function<double(int, int, int)> pressure;  // Pa
  std::function<bool(int, int, int)> is_blood;
};

/// One line of a .pvd collection.
struct PvdEntry {
  double time = 0;   // s
  std::string file;  // relative to the .pvd
};

class FrameWriter {
 public:
  /// `results` is created with its folder frames/. mesh, chordae and annulus must outlive the writer. A fresh run (resume_time <
  /// 0) removes frames and collections of an earlier run; a resumed one keeps the frames up to resume_time and drops later ones.
  /// Throws IoError.
  FrameWriter(std::filesystem::path results, const LeafletMesh& mesh, const Chordae& chordae, const Annulus& annulus,
              const SolverFrame& frame, double resume_time = -1);

  /// Each writes one frame and extends its collection; returns the file written. Throws IoError (disk full, permissions), leaving
  /// earlier frames and collections as they were.
  std::filesystem::path write_leaflets(const LeafletsState& state);
  std::filesystem::path write_chordae(const ChordaeState& state);
  std::filesystem::path write_fluid(const FluidState& state);

 private:
  struct Collection {
    std::string name;
    std::string extension;
    std::vector<PvdEntry> entries;
  };
  void open_collection(Collection& collection, double resume_time);
  std::filesystem::path store(Collection& collection, double time,
                              const std::function<void(const std::filesystem::path&)>& write);

  std::filesystem::path results_;
  const LeafletMesh& mesh_;
  const Chordae& chordae_;
  const Annulus& annulus_;
  SolverFrame frame_;
  Collection leaflets_{"leaflets", "vtu", {}};
  Collection chordae_frames_{"chordae", "vtp", {}};
  Collection fluid_{"fluid", "vti", {}};
};

/// Entries in file order. A missing file gives an empty list; damaged XML throws InputError.
std::vector<PvdEntry> read_pvd(const std::filesystem::path& file);

/// Valid XML whatever the entries; written atomically. Throws IoError.
void write_pvd(const std::filesystem::path& file, std::span<const PvdEntry> entries);

}  // namespace mv
