// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <utility>

#include "geometry/deck/abaqus_deck.h"

namespace mv {
namespace {

using Kind = DeckElementType::Kind;

constexpr std::array<std::pair<const char*, DeckElementType>, 38> known_types{{
    {"S3", {Kind::shell, 3, 3}},        {"S3R", {Kind::shell, 3, 3}},       {"S3RS", {Kind::shell, 3, 3}},     {"STRI3", {Kind::shell, 3, 3}},
    {"S4", {Kind::shell, 4, 4}},        {"S4R", {Kind::shell, 4, 4}},       {"S4RS", {Kind::shell, 4, 4}},     {"S4RSW", {Kind::shell, 4, 4}},
    {"S4R5", {Kind::shell, 4, 4}},      {"STRI65", {Kind::shell, 6, 3}},    {"S8R", {Kind::shell, 8, 4}},      {"M3D3", {Kind::membrane, 3, 3}},
    {"M3D4", {Kind::membrane, 4, 4}},   {"M3D4R", {Kind::membrane, 4, 4}},  {"M3D6", {Kind::membrane, 6, 3}},  {"M3D8", {Kind::membrane, 8, 4}},
    {"M3D8R", {Kind::membrane, 8, 4}},  {"T3D2", {Kind::truss, 2, 2}},      {"T3D2H", {Kind::truss, 2, 2}},    {"T3D3", {Kind::truss, 3, 2}},
    {"B31", {Kind::beam, 2, 2}},        {"B31H", {Kind::beam, 2, 2}},       {"B31OS", {Kind::beam, 2, 2}},     {"B33", {Kind::beam, 2, 2}},
    {"PIPE31", {Kind::beam, 2, 2}},     {"C3D4", {Kind::solid, 4, 4}},      {"C3D4H", {Kind::solid, 4, 4}},    {"C3D10", {Kind::solid, 10, 4}},
    {"C3D10M", {Kind::solid, 10, 4}},   {"C3D10H", {Kind::solid, 10, 4}},   {"C3D10MH", {Kind::solid, 10, 4}}, {"C3D6", {Kind::solid, 6, 6}},
    {"C3D8", {Kind::solid, 8, 8}},      {"C3D8R", {Kind::solid, 8, 8}},     {"C3D8H", {Kind::solid, 8, 8}},    {"C3D8RH", {Kind::solid, 8, 8}},
    {"CONN3D2", {Kind::connector, 2, 2}}, {"SPRINGA", {Kind::connector, 2, 2}},
}};

}  // namespace

std::optional<DeckElementType> deck_element_type(const std::string& type) {
  for (const auto& [name, entry] : known_types)
    if (type == name) return entry;
  return std::nullopt;
}

int DeckElement::corners() const { return deck_element_type(type)->corners; }

}  // namespace mv
