// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <numbers>

#include "geometry/core/config.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

struct Unit {
  const char* name;
  Dimension dimension;
  double factor;  // to SI
};

constexpr double mmHg = 133.322387415;  // Pa, conventional millimetre of mercury

constexpr Unit units[] = {
    {"mm", Dimension::length, 1e-3},
    {"cm", Dimension::length, 1e-2},
    {"m", Dimension::length, 1.0},
    {"um", Dimension::length, 1e-6},
    {"mm2", Dimension::area, 1e-6},
    {"cm2", Dimension::area, 1e-4},
    {"m2", Dimension::area, 1.0},
    {"ml", Dimension::volume, 1e-6},
    {"mm3", Dimension::volume, 1e-9},
    {"cm3", Dimension::volume, 1e-6},
    {"l", Dimension::volume, 1e-3},
    {"m3", Dimension::volume, 1.0},
    {"s", Dimension::time, 1.0},
    {"ms", Dimension::time, 1e-3},
    {"us", Dimension::time, 1e-6},
    {"Pa", Dimension::pressure, 1.0},
    {"kPa", Dimension::pressure, 1e3},
    {"MPa", Dimension::pressure, 1e6},
    {"mmHg", Dimension::pressure, mmHg},
    {"kg/m3", Dimension::density, 1.0},
    {"g/cm3", Dimension::density, 1e3},
    {"Pa s", Dimension::viscosity, 1.0},
    {"mPa s", Dimension::viscosity, 1e-3},
    {"N", Dimension::force, 1.0},
    {"mN", Dimension::force, 1e-3},
    {"m/s", Dimension::velocity, 1.0},
    {"cm/s", Dimension::velocity, 1e-2},
    {"mm/s", Dimension::velocity, 1e-3},
    {"deg", Dimension::angle, std::numbers::pi / 180.0},
    {"rad", Dimension::angle, 1.0},
    {"N/m", Dimension::stiffness, 1.0},
    {"N/mm", Dimension::stiffness, 1e3},
    {"ml/s", Dimension::flow, 1e-6},
    {"m3/s", Dimension::flow, 1.0},
};

std::string_view trimmed(std::string_view s) {
  const auto first = s.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t") - first + 1);
}

const Unit* find_unit(std::string_view name) {
  for (const Unit& u : units) {
    if (name == u.name) return &u;
  }
  return nullptr;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& w : words) text += (text.empty() ? "" : ", ") + w;
  return text;
}

}  // namespace

std::string dimension_name(Dimension dimension) {
  switch (dimension) {
    case Dimension::none:
      return "number";
    case Dimension::length:
      return "length";
    case Dimension::area:
      return "area";
    case Dimension::volume:
      return "volume";
    case Dimension::time:
      return "time";
    case Dimension::pressure:
      return "pressure";
    case Dimension::density:
      return "density";
    case Dimension::viscosity:
      return "viscosity";
    case Dimension::force:
      return "force";
    case Dimension::velocity:
      return "velocity";
    case Dimension::angle:
      return "angle";
    case Dimension::stiffness:
      return "stiffness";
    case Dimension::flow:
      return "flow rate";
  }
  return "number";
}

std::vector<std::string> units_of(Dimension dimension) {
  std::vector<std::string> names;
  for (const Unit& u : units) {
    if (u.dimension == dimension) names.emplace_back(u.name);
  }
  return names;
}

double unit_factor(std::string_view unit) {
  const Unit* u = find_unit(trimmed(unit));
  if (!u) throw ConfigError("unknown unit '" + std::string(unit) + "'");
  return u->factor;
}

double parse_quantity(std::string_view text, Dimension dimension, const std::string& what) {
  const std::string_view body = trimmed(text);
  const std::string unit_list = joined(units_of(dimension));
  const std::string expected = dimension == Dimension::none
                                   ? std::string("expected a number")
                                   : "expected a " + dimension_name(dimension) + " with a unit (" + unit_list +
                                         "), such as \"1.5 " + units_of(dimension).front() + "\"";
  auto refuse = [&](const std::string& why) -> double {
    throw ConfigError(what + " has the value \"" + std::string(text) + "\": " + why + expected);
  };
  double value = 0;
  const bool has_plus = body.starts_with('+') && !body.starts_with("+-");
  const char* begin = body.data() + (has_plus ? 1 : 0);
  const auto [end, failure] = std::from_chars(begin, body.data() + body.size(), value);
  if (failure != std::errc{}) return refuse("");
  if (!std::isfinite(value)) return refuse("not finite; ");
  const std::string_view unit = trimmed(body.substr(static_cast<std::size_t>(end - body.data())));
  if (dimension == Dimension::none) return unit.empty() ? value : refuse("");
  if (unit.empty()) return refuse("the unit is missing; ");
  const Unit* u = find_unit(unit);
  if (!u) return refuse("unknown unit '" + std::string(unit) + "'" + (unit.starts_with(",") ? ": numbers need decimal points" : "") + "; ");
  if (u->dimension != dimension) return refuse("'" + std::string(unit) + "' is a unit of " + dimension_name(u->dimension) + "; ");
  return value * u->factor;
}

}  // namespace mv
