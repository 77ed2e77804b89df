// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/config.h"

#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <sstream>
#include <stdexcept>

#include "geometry/core/case_files.h"
#include "geometry/core/config_values.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

using Kind = RawValue::Kind;

std::string location(const std::string& origin, const toml::source_region& source) {
  return source.begin.line > 0 ? origin + ":" + std::to_string(source.begin.line) : origin;
}

std::string written(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& n) { out << n; });
  std::string text = out.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() > 120) text = text.substr(0, 117) + "...";
  return text;
}

RawValue raw_value(const toml::node& node) {
  RawValue raw;
  raw.written = written(node);
  if (const auto* b = node.as_boolean())
    raw.kind = Kind::boolean, raw.boolean = b->get();
  else if (const auto* i = node.as_integer())
    raw.kind = Kind::integer, raw.integer = static_cast<long>(i->get());
  else if (const auto* f = node.as_floating_point())
    raw.kind = Kind::real, raw.real = f->get();
  else if (const auto* s = node.as_string())
    raw.kind = Kind::text, raw.text = s->get();
  else if (const auto* list = node.as_array()) {
    raw.kind = Kind::list;
    for (const toml::node& item : *list) raw.list.push_back(raw_value(item));
  }
  return raw;
}

const ConfigKey* find_key(const std::string& name) {
  for (const ConfigKey& key : config_schema()) {
    if (key.name == name) return &key;
  }
  return nullptr;
}

bool is_section(const std::string& name) {
  return std::any_of(config_schema().begin(), config_schema().end(),
                     [&](const ConfigKey& key) { return key.name.starts_with(name + "."); });
}

[[noreturn]] void refuse_unknown(const std::string& name, const std::string& value, const std::string& where) {
  if (is_section(name)) {
    throw ConfigError(where + ": '" + name + "' has the value " + value + ": expected a section with keys, such as [" + name +
                      "]");
  }
  std::vector<std::string> names;
  for (const ConfigKey& key : config_schema()) {
    const std::string section = key.name.substr(0, key.name.rfind('.'));
    if (names.empty() || !names.back().starts_with(section + ".")) names.push_back(section);
    names.push_back(key.name);
  }
  throw ConfigError(where + ": unknown key '" + name + "'" + (value.empty() ? "" : " (value " + value + ")") +
                    "; did you mean '" + nearest_name(name, names) + "'? expected one of the keys that `mvprep config` lists");
}

using Assign = std::function<void(const ConfigKey&, ConfigValue)>;

void read_table(const toml::table& table, const std::string& prefix, const std::string& origin, const Assign& assign) {
  for (const auto& [toml_key, node] : table) {
    const std::string name = prefix + std::string(toml_key.str());
    const std::string where = location(origin, toml_key.source());
    if (prefix.empty() && name == "format_version") {
      const auto format = node.value_exact<std::int64_t>();
      if (!format || *format < 1 || *format > case_format_version) {
        throw ConfigError(where + ": key 'format_version' has the value " + written(node) +
                          ": expected a whole number from 1 to " + std::to_string(case_format_version) +
                          ", the formats this program reads");
      }
    } else if (prefix.empty() && name == "provenance" && node.is_table()) {
      continue;
    } else if (const toml::table* section = node.as_table()) {
      if (const ConfigKey* key = find_key(name)) checked_value(*key, raw_value(node), where);  // refuses a table as a value
      if (!is_section(name) && section->empty()) refuse_unknown(name, "", where);
      read_table(*section, name + ".", origin, assign);
    } else if (const ConfigKey* key = find_key(name)) {
      assign(*key, checked_value(*key, raw_value(node), where));
    } else {
      refuse_unknown(name, written(node), where);
    }
  }
}

template <class T>
const T& value_as(const std::map<std::string, ConfigValue>& values, const std::string& key) {
  const auto found = values.find(key);
  if (found == values.end()) throw std::logic_error("the schema has no key '" + key + "'");
  const T* value = std::get_if<T>(&found->second);
  if (!value) throw std::logic_error("the key '" + key + "' is asked for as another type than " + config_key(key).type);
  return *value;
}

std::string shortest(double value) {
  std::array<char, 40> buffer;
  const auto [end, failure] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  (void)failure;
  return std::string(buffer.data(), end);
}

/// Shortest decimal whose product with the unit's factor is exactly `si`; if none exists, the nearest quotient.
std::string number_in_unit(double si, double factor) {
  const double quotient = si / factor;
  for (int digits = 1; digits <= 17; ++digits) {
    std::array<char, 40> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), quotient, std::chars_format::general, digits).ptr;
    double back = 0;
    std::from_chars(buffer.data(), end, back);
    if (back * factor == si) return std::string(shortest(back));
  }
  for (double candidate : {std::nextafter(quotient, -HUGE_VAL), std::nextafter(quotient, HUGE_VAL)}) {
    if (candidate * factor == si) return shortest(candidate);
  }
  return shortest(quotient);
}

std::string quoted(const std::string& text) {
  std::string out(1, '"');
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      std::array<char, 8> escape;
      std::snprintf(escape.data(), escape.size(), "\\u%04X", static_cast<unsigned>(static_cast<unsigned char>(c)));
      out += escape.data();
    } else {
      out += c;
    }
  }
  out += '"';
  return out;
}

/// The reader takes whole numbers for real ones, so that 2 stays 2.
std::string quantity_text(const ConfigKey& key, double si) {
  if (key.dimension == Dimension::none) return shortest(si);
  const double factor = unit_factor(key.unit);
  const std::string number = number_in_unit(si, factor);
  double back = 0;
  std::from_chars(number.data(), number.data() + number.size(), back);
  if (back * factor == si) return quoted(number + " " + key.unit);
  for (const std::string& unit : units_of(key.dimension)) {  // a unit of factor one always returns the same bits
    if (unit_factor(unit) == 1.0) return quoted(shortest(si) + " " + unit);
  }
  return quoted(number + " " + key.unit);
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = static_cast<std::size_t>(-1);
  for (const std::string& candidate : candidates) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= name.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i;
      for (std::size_t j = 1; j <= candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (name[i - 1] != candidate[j - 1]);
        diagonal = row[j];
        row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
      }
    }
    if (row.back() < best_distance) best_distance = row.back(), best = candidate;
  }
  return best;
}

std::string value_text(const ConfigKey& key, const ConfigValue& value) {
  if (const bool* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const long* integer = std::get_if<long>(&value)) return std::to_string(*integer);
  if (const double* number = std::get_if<double>(&value)) return std::isnan(*number) ? "\"auto\"" : quantity_text(key, *number);
  if (const auto* text = std::get_if<std::string>(&value)) return quoted(*text);
  std::string list;
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) {
    if (numbers->empty() && key.can_be_auto) return "\"auto\"";
    for (double n : *numbers) list += (list.empty() ? "" : ", ") + quantity_text(key, n);
  } else {
    for (const auto& t : std::get<std::vector<std::string>>(value)) list += (list.empty() ? "" : ", ") + quoted(t);
  }
  return "[" + list + "]";
}

Config::Config() {
  for (const ConfigKey& key : config_schema()) {
    values_[key.name] = key.default_value;
    given_[key.name] = false;
  }
}

Config Config::from_file(const std::filesystem::path& file) {
  Config config = from_string(read_file(file), file.string());
  config.base_directory_ = std::filesystem::absolute(file).parent_path();
  return config;
}

Config Config::from_case_file(const std::filesystem::path& file) {
  Config config = from_file(file);
  const std::string text = "\n" + read_file(file);
  for (const char* part : {"\nformat_version", "\n[provenance]"})
    if (text.find(part) == std::string::npos)
      throw ConfigError(file.string() + ": incomplete: " + (part + 1) + " is missing, which mvprep writes " + (part[1] == 'f' ? "first" : "last") +
                        "; copy the case again, or make it again with mvprep run");
  return config;
}

Config Config::from_string(std::string_view text, const std::string& origin) {
  Config config;
  toml::table table;
  try {
    table = toml::parse(text, origin);
  } catch (const toml::parse_error& e) {
    throw ConfigError(location(origin, e.source()) + ": not valid TOML: " + std::string(e.description()));
  }
  read_table(table, "", origin, [&](const ConfigKey& key, ConfigValue value) {
    config.values_[key.name] = std::move(value);
    config.given_[key.name] = true;
  });
  return config;
}

void Config::set(const std::string& assignment) {
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    throw ConfigError("--set: '" + assignment + "': expected key=value, such as mesh.spacing=\"0.5 mm\"");
  }
  std::string name = assignment.substr(0, equals);
  while (name.ends_with(' ')) name.pop_back();
  const ConfigKey* key = find_key(name);
  if (!key) refuse_unknown(name, assignment.substr(equals + 1), "--set");
  values_[name] = value_from_text(*key, std::string_view(assignment).substr(equals + 1), "--set");
  given_[name] = true;
}

bool Config::flag(const std::string& key) const { return value_as<bool>(values_, key); }
long Config::integer(const std::string& key) const { return value_as<long>(values_, key); }
const std::string& Config::text(const std::string& key) const { return value_as<std::string>(values_, key); }
const std::vector<double>& Config::numbers(const std::string& key) const { return value_as<std::vector<double>>(values_, key); }
const std::vector<std::string>& Config::texts(const std::string& key) const {
  return value_as<std::vector<std::string>>(values_, key);
}

double Config::number(const std::string& key) const {
  const double value = value_as<double>(values_, key);
  if (std::isnan(value)) throw std::logic_error("the key '" + key + "' is automatic: ask is_auto first");
  return value;
}

double Config::number_in(const std::string& key, const std::string& unit) const { return number(key) / unit_factor(unit); }

bool Config::is_auto(const std::string& key) const {
  if (!config_key(key).can_be_auto) return false;
  const ConfigValue& value = values_.at(key);
  if (const double* number = std::get_if<double>(&value)) return std::isnan(*number);
  if (const auto* numbers = std::get_if<std::vector<double>>(&value)) return numbers->empty();
  return false;
}

std::filesystem::path Config::path(const std::string& key) const {
  const std::string& value = text(key);
  return value.empty() ? std::filesystem::path() : base_directory_ / value;
}

std::vector<std::filesystem::path> Config::paths(const std::string& key) const {
  const bool is_list = config_key(key).type == "paths";
  std::vector<std::filesystem::path> all;
  for (const std::string& value : is_list ? texts(key) : std::vector<std::string>{text(key)}) {
    if (!value.empty()) all.push_back(base_directory_ / value);
  }
  return all;
}

bool Config::was_given(const std::string& key) const {
  const auto found = given_.find(key);
  if (found == given_.end()) throw std::logic_error("the schema has no key '" + key + "'");
  return found->second;
}

std::string Config::to_toml(bool commented) const {
  std::string text, section;
  for (const ConfigKey& key : config_schema()) {
    const auto dot = key.name.rfind('.');
    const std::string here = key.name.substr(0, dot);
    if (here != section) {
      text += (text.empty() ? "[" : "\n[") + here + "]\n";
      section = here;
    }
    if (commented) {
      text += "# " + key.doc;
      const std::string range = range_text(key);
      if (!range.empty()) text += ";" + range;
      for (std::size_t i = 0; i < key.choices.size(); ++i) text += (i ? " | " : ": ") + key.choices[i];
      text += "\n";
    }
    text += key.name.substr(dot + 1) + " = " + value_text(key, values_.at(key.name)) + "\n";
  }
  return text;
}

std::string Config::fingerprint(const std::vector<std::string>& prefixes) const {
  std::string text;
  for (const ConfigKey& key : config_schema()) {
    const bool covered = std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& prefix) {
      return key.name == prefix || key.name.starts_with(prefix + ".");
    });
    if (covered) text += key.name + " = " + value_text(key, values_.at(key.name)) + "\n";
  }
  return text;
}

}  // namespace mv
