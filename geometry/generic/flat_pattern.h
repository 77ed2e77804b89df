// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The flat pattern of the generic valve (papers/s0, figure 2b; DESIGN 4): four semicircles in a row on a straight strip.

#include <vector>

#include "geometry/core/case.h"

namespace mv {

/// Lengths in mm.
struct PatternParameters {
  double perimeter = 107.2;        // length of the base = annulus
  double strip_height = 6;         // commissural height: base of the semicircles
  double anterior_radius = 18;     // half the anterior base
  double anterior_height = 0.9;    // height of the anterior half-ellipse over its radius
  double posterior_height = 0.75;  // same for the posterior scallops, which share the rest of the perimeter evenly
  int posterior_scallops = 3;
  double notch_radius = 1;  // fillet in the cusps between neighbouring scallops; raises the notch floor (see notch_height)
};

/// u runs along the annulus from the first commissure: the anterior leaflet is [0, 2 anterior_radius], then the posterior
/// scallops; v runs from the annulus (0) to the free edge, v = height(u):
///   height(u) = strip + k sqrt(r^2 - (u - u_c)^2) on each scallop, and the lower half of a circle of radius notch_radius that
///   touches
/// both neighbours in each cusp. The tissue is 0 <= v <= height(u); u is periodic.
class FlatPattern {
 public:
  /// Throws ConfigError naming the parameter that leaves no room (non-positive lengths, anterior base wider than 90 % of the
  /// perimeter, fillet larger than a scallop).
  explicit FlatPattern(const PatternParameters& parameters);

  const PatternParameters& parameters() const { return parameters_; }
  double perimeter() const { return parameters_.perimeter; }
  double height(double u) const;
  Region region(double u) const;
  int scallop(double u) const;                                     // 0 anterior, 1.. posterior in order of u
  const std::vector<double>& notches() const { return notches_; }  // u of the cusps: 0, 2 r_anterior, ...
  double notch_height(int i) const;                                // height of the fillet's lowest point in notch i
  double area() const;                                             // mm2
  /// Free edge as a dense polyline (u ascending from 0, below the perimeter), points no further apart than `step` mm in the flat
  /// pattern.
  std::vector<Vec2> free_edge(double step) const;

 private:
  struct Scallop {
    double centre, radius, factor;
  };
  struct Fillet {
    double centre_u, centre_v, u_begin, u_end;
  };  // around its notch; may reach below u = 0
  double wrap(double u) const;
  PatternParameters parameters_;
  std::vector<Scallop> scallops_;
  std::vector<double> notches_;
  std::vector<Fillet> fillets_;
};

}  // namespace mv
