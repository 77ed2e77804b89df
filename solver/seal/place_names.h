// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Where on the valve a point lies, in the words of a surgeon (Carpentier's A1-A3, P1-P3). Internal to solver/seal.

#include <array>
#include <string>
#include <vector>

#include "solver/seal/seal.h"

namespace mv::seal {

struct PlaceName {
  std::string location = "unnamed";
  int region = 0;
  double u = 0;
};

/// Names need region and unfolded per point. Segments are thirds of a leaflet's u interval; a commissure is its outer tenth.
/// Segment 1 is the anterolateral end; with an unknown direction segments count along u. A valve with a leaflet besides the mitral two gets the names of
/// its leaflets alone ("between anterior and septal leaflet").
class PlaceNames {
 public:
  explicit PlaceNames(const SealInput& input);
  PlaceName at(const Vec3& world) const;


 private:
  struct Leaflet {
    bool present = false;
    double u_min = 0, u_max = 0;
    bool reversed = false;  // segment 1 lies at u_max
  };
  struct Near {
    double distance = 1e300;
    double u = 0;
  };
  Near nearest(const Vec3& world, int region) const;
  PlaceName by_leaflets(const Vec3& world) const;
  double position(const Leaflet& leaflet, double u) const;  // 0 anterolateral to 1 posteromedial

  const SealInput& input_;
  bool oriented_ = false;
  bool has_other_leaflets_ = false;
  std::array<Leaflet, 3> leaflet_;  // by Region
};

}  // namespace mv::seal
