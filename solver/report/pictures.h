// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The report's pictures of the valve, drawn by raster.h from the first and the last frame.

#include <optional>
#include <string>
#include <vector>

#include "solver/report/map_view.h"
#include "solver/report/raster.h"

namespace mv {

struct ValveFrames {
  std::optional<LeafletsFrame> open, closed;  // first and last
  std::optional<ChordaeFrame> open_chordae, closed_chordae;
};

struct Picture {
  std::string name;  // file name without .png
  std::string caption;
  Image image;
  std::string png;  // the image as a file
};

/// open_atrial, open_ventricular, open_cut, closed_atrial, closed_ventricular, closed_cut, and stress_atrial, stress_ventricular
/// when the frame has von Mises stresses. A pressure_scale of 0 draws no contact. Views from the atrium have the anterior leaflet
/// at the top; the cut runs through the middle of both leaflets. Contact pressure is drawn in viridis up to `pressure_scale` kPa,
/// stress in cividis up to `stress_scale` kPa.
std::vector<Picture> draw_valve(const ValveFrames& frames, double pressure_scale, double stress_scale);

/// The contact map with belt, names, scale and colour bar.
Picture draw_contact_map(const ContactMap& map, const MapView& view, double pressure_scale);

/// Closed valve from the atrium and its contact map on one sheet.
Picture draw_overview(const Picture& closed_atrial, const Picture& closed_cut, const Picture& contact_map);

/// Upper end of the pressure scale: 99th percentile of the pressures above zero, rounded up nicely; 0 when there are none.
double pressure_scale_of(const std::vector<double>& contact_pressures);

/// Upper end of the stress scale: 99th percentile of the frame's von Mises stresses, rounded up nicely; 0 without.
double stress_scale_of(const LeafletsFrame& frame);

}  // namespace mv
