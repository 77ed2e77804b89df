// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Inside the core: from what was written (TOML or --set) to a checked value in SI units.

#include "geometry/core/config.h"

namespace mv {

/// A value as it was written, before the schema is asked what it should be.
struct RawValue {
  enum class Kind { boolean, integer, real, text, list, other };
  Kind kind = Kind::other;
  bool boolean = false;
  long integer = 0;
  double real = 0;
  std::string text;
  std::vector<RawValue> list;
  std::string written;  // for messages
};

/// Checks type, unit, choice, list length and range. `where` opens the message ("demo.toml:12"). Throws ConfigError.
ConfigValue checked_value(const ConfigKey& key, const RawValue& raw, const std::string& where);

/// The same from text in which quotes around strings are optional: 0.5 mm, true, [1 mm, 2 mm], "arc".
ConfigValue value_from_text(const ConfigKey& key, std::string_view text, const std::string& where);

}  // namespace mv
