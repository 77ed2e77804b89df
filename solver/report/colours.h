// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "solver/report/raster.h"

namespace mv {

/// Colour maps that keep their order in grey and for colour-blind readers: viridis (S. van der Walt, N. Smith, CC0) for contact,
/// cividis (Nunez, Anderton, Renslow 2018, doi 10.1371/journal.pone.0199239) for stress. Stops evenly spaced over [0, 1].
inline constexpr unsigned viridis_stops[] = {0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e,
                                             0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725};
inline constexpr unsigned cividis_stops[] = {0x00224e, 0x123570, 0x3b496c, 0x575d6d, 0x707173,
                                             0x8a8678, 0xa59c74, 0xc3b369, 0xe1cc55, 0xfee838};

inline Rgb rgb(unsigned hex) {
  return Rgb(static_cast<float>(hex >> 16 & 255), static_cast<float>(hex >> 8 & 255), static_cast<float>(hex & 255)) / 255.0f;
}

inline Rgb map_colour(std::span<const unsigned> stops, double share) {
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const auto w = static_cast<float>(at - static_cast<double>(i));
  return (1 - w) * rgb(stops[i]) + w * rgb(stops[i + 1]);
}

/// One meaning, one colour, in pictures and in plots (blue and vermilion of Okabe and Ito's set).
inline const Rgb anterior_colour = rgb(0xe9c7b8), posterior_colour = rgb(0xbfd0e0), ink_colour = rgb(0x22262b),
                 primary_colour = rgb(0xd55e00), secondary_colour = rgb(0x0072b2), muscle_colour = rgb(0x8a5a44),
                 no_contact_colour = rgb(0xe3e6ea);

}  // namespace mv
