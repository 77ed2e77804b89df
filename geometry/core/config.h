// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The configuration both programs share: a TOML file checked against one schema (config_schema.cpp) that gives every key its
// type, dimension, default, range and one line of documentation.

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "geometry/core/case.h"

namespace mv {

enum class Dimension { none, length, area, volume, time, pressure, density, viscosity, force, velocity, angle, stiffness, flow };

/// Value in SI units (angles in radians).
using ConfigValue = std::variant<bool, long, double, std::string, std::vector<double>, std::vector<std::string>>;

struct ConfigKey {
  std::string name;  // dotted, e.g. "mesh.spacing"
  std::string type;  // "bool" "integer" "number" "string" "choice" "path" "numbers" "integers" "strings" "paths"
  Dimension dimension = Dimension::none;
  std::string unit;           // unit in which the value is written back, e.g. "mm"
  ConfigValue default_value;  // NaN or an empty list stands for "auto"
  bool can_be_auto = false;   // "auto" (or "") is accepted: the program chooses the value
  std::size_t count = 0;      // length of a list, 0 for any
  std::vector<std::string> choices;
  double minimum = -1e300;  // SI, inclusive
  double maximum = 1e300;
  std::string doc;
};

/// The key of that name. Throws std::logic_error for an unknown one.
const ConfigKey& config_key(const std::string& name);

/// Value as it is written in TOML, e.g. "\"0.5 mm\"" or "[1, 0, 0]".
std::string value_text(const ConfigKey& key, const ConfigValue& value);

/// " from 0.05 mm to 10 mm", " of at least 0 Pa", or nothing.
std::string range_text(const ConfigKey& key);

/// All keys, in the order in which they are written back.
const std::vector<ConfigKey>& config_schema();

class Config {
 public:
  /// Defaults only.
  Config();

  /// Reads and checks a TOML file. A dimensional value is a string with a unit ("1.0 mm"); arrays of them are arrays of such
  /// strings. Throws ConfigError (file, line, key, value, expected; the nearest known key for an unknown one), IoError when
  /// unreadable.
  static Config from_file(const std::filesystem::path& file);
  /// A case's case.toml, which mvprep writes with every value, format_version first and [provenance] last. Throws ConfigError where either is missing: what was cut off
  /// or emptied would be read as defaults.
  static Config from_case_file(const std::filesystem::path& file);
  /// Besides the schema's keys the file may hold format_version and a table [provenance], which are what case.toml adds.
  static Config from_string(std::string_view toml, const std::string& origin);

  /// Applies "key=value" as given to --set: mesh.spacing=0.5 mm, fibers.model=arc, generic.anterior_direction=[0, 1, 0]; quotes
  /// around strings are optional. Throws ConfigError.
  void set(const std::string& assignment);

  bool flag(const std::string& key) const;
  long integer(const std::string& key) const;
  double number(const std::string& key) const;  // SI; std::logic_error when automatic: ask is_auto first
  double number_in(const std::string& key, const std::string& unit) const;  // e.g. number_in("mesh.spacing", "mm")
  const std::string& text(const std::string& key) const;
  const std::vector<double>& numbers(const std::string& key) const;  // SI; "integers" too; empty when automatic
  const std::vector<std::string>& texts(const std::string& key) const;
  bool is_auto(const std::string& key) const;    // the value is left to the program ("auto")
  bool was_given(const std::string& key) const;  // false when the default stands
  /// Value of a "path" key, relative ones taken from base_directory(); empty when the key is empty.
  std::filesystem::path path(const std::string& key) const;
  /// Values of a "path" or "paths" key, in order, without empty ones.
  std::vector<std::filesystem::path> paths(const std::string& key) const;

  /// The resolved configuration as TOML, every default written out with its unit, in schema order; `commented` adds the docs.
  /// Reading it back gives bit-identical values.
  std::string to_toml(bool commented = false) const;

  /// Canonical text of the values under the given key prefixes ("mesh" covers mesh.*, "mesh.layers" itself), for hashing a
  /// stage's inputs. Paths enter as text: hash the files they name besides.
  std::string fingerprint(const std::vector<std::string>& prefixes) const;

  /// Directory that relative paths in the file refer to.
  std::filesystem::path base_directory() const { return base_directory_; }
  void set_base_directory(std::filesystem::path directory) { base_directory_ = std::move(directory); }

 private:
  std::map<std::string, ConfigValue> values_;
  std::map<std::string, bool> given_;
  std::filesystem::path base_directory_;
};

/// Version of the case.toml format this program writes (top-level key format_version) and the newest it reads.
inline constexpr long case_format_version = 1;

/// Parses "1.0 mm" into SI. Throws ConfigError naming the expected dimension and its known units.
double parse_quantity(std::string_view text, Dimension dimension, const std::string& what);

/// "length", "pressure", ... as used in messages.
std::string dimension_name(Dimension dimension);

/// Units of a dimension, the customary one first.
std::vector<std::string> units_of(Dimension dimension);

/// Factor from the unit to SI: factor("mm") = 1e-3, factor("mmHg") = 133.322387415. Throws ConfigError for an unknown unit.
double unit_factor(std::string_view unit);

/// The candidate with the smallest edit distance.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace mv
