// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/config_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr double automatic = std::numeric_limits<double>::quiet_NaN();
using Kind = RawValue::Kind;

bool holds_texts(const ConfigKey& key) { return key.type == "strings" || key.type == "paths"; }
bool is_list_type(const ConfigKey& key) { return key.type == "numbers" || key.type == "integers" || holds_texts(key); }

std::string in_unit(const ConfigKey& key, double si) {
  ConfigKey single = key;
  single.type = "number";
  std::string text = value_text(single, ConfigValue(si));
  std::erase(text, '"');
  return text;
}

std::string expected(const ConfigKey& key) {
  const std::string with_auto = key.can_be_auto ? ", or \"auto\"" : "";
  const std::string times = key.count ? std::to_string(key.count) + " " : "";
  if (key.type == "bool") return "true or false";
  if (key.type == "integer") return "a whole number" + range_text(key) + with_auto;
  if (key.type == "integers") return "a list of " + times + "whole numbers" + range_text(key) + ", such as [0, 3]" + with_auto;
  if (key.type == "string") return "a text in quotes";
  if (key.type == "path") return "a path in quotes";
  if (key.type == "paths") return "a list of " + times + "paths, such as [\"a.csv\", \"b.csv\"]";
  if (key.type == "strings") return "a list of " + times + "texts, such as [\"a\", \"b\"]";
  if (key.type == "choice") {
    std::string list;
    for (const auto& c : key.choices) list += (list.empty() ? "\"" : ", \"") + c + "\"";
    return "one of " + list;
  }
  if (key.dimension == Dimension::none) {
    return (key.type == "numbers" ? "a list of " + times + "numbers" : std::string("a number")) + range_text(key) + with_auto;
  }
  std::string unit_list;
  for (const auto& u : units_of(key.dimension)) unit_list += (unit_list.empty() ? "" : ", ") + u;
  const std::string quantity = dimension_name(key.dimension) + range_text(key) + " as a text with a unit (" + unit_list + ")";
  const std::string sample = "\"1.5 " + key.unit + "\"";
  if (key.type == "numbers") return "a list of " + times + "values, each a " + quantity + ", such as " + sample + with_auto;
  return "a " + quantity + ", such as " + sample + with_auto;
}

[[noreturn]] void refuse(const ConfigKey& key, const RawValue& raw, const std::string& where, const std::string& why) {
  throw ConfigError(where + ": key '" + key.name + "' has the value " + raw.written + ": " + (why.empty() ? "" : why + "; ") +
                    "expected " + expected(key));
}

double checked_number(const ConfigKey& key, const RawValue& whole, const RawValue& raw, const std::string& where) {
  double value = 0;
  if (key.dimension == Dimension::none) {
    if (key.type == "integers" && raw.kind != Kind::integer) refuse(key, whole, where, "");
    if (raw.kind == Kind::integer)
      value = static_cast<double>(raw.integer);
    else if (raw.kind == Kind::real)
      value = raw.real;
    else
      refuse(key, whole, where, "");
  } else {
    if (raw.kind == Kind::integer || raw.kind == Kind::real) refuse(key, whole, where, "a bare number has no unit");
    if (raw.kind != Kind::text) refuse(key, whole, where, "");
    value = parse_quantity(raw.text, key.dimension, where + ": key '" + key.name + "'");
  }
  if (!std::isfinite(value)) refuse(key, whole, where, "not finite");
  if (value < key.minimum || value > key.maximum) refuse(key, whole, where, "out of range");
  return value;
}

bool asks_for_auto(const RawValue& raw) { return raw.kind == Kind::text && (raw.text.empty() || raw.text == "auto"); }

std::string_view trimmed(std::string_view s) {
  const auto first = s.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t") - first + 1);
}

std::string without_quotes(std::string_view s) {
  if (s.size() >= 2 && (s.front() == '"' || s.front() == '\'') && s.back() == s.front()) s = s.substr(1, s.size() - 2);
  return std::string(s);
}

/// Reads one item as what the key's type asks for; what does not fit stays a text and is refused later.
RawValue raw_item(const ConfigKey& key, std::string_view text) {
  RawValue raw;
  raw.written = std::string(text);
  raw.kind = Kind::text;
  raw.text = without_quotes(text);
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (key.type == "bool" && (text == "true" || text == "false")) {
    raw.kind = Kind::boolean;
    raw.boolean = text == "true";
  } else if (key.type == "integer" || key.type == "integers") {
    const auto [stop, failure] = std::from_chars(begin, end, raw.integer);
    if (failure == std::errc{} && stop == end) raw.kind = Kind::integer;
  } else if (key.type == "number" || key.type == "numbers") {
    const auto [stop, failure] = std::from_chars(begin, end, raw.real);
    if (failure == std::errc{} && stop == end) raw.kind = Kind::real;
  }
  return raw;
}

}  // namespace

std::string range_text(const ConfigKey& key) {
  const bool has_low = key.minimum > -1e300, has_high = key.maximum < 1e300;
  if (has_low && has_high) return " from " + in_unit(key, key.minimum) + " to " + in_unit(key, key.maximum);
  if (has_low) return " of at least " + in_unit(key, key.minimum);
  if (has_high) return " of at most " + in_unit(key, key.maximum);
  return "";
}

ConfigValue checked_value(const ConfigKey& key, const RawValue& raw, const std::string& where) {
  if (is_list_type(key)) {
    if (key.can_be_auto && asks_for_auto(raw))
      return holds_texts(key) ? ConfigValue(std::vector<std::string>{}) : ConfigValue(std::vector<double>{});
    if (raw.kind != Kind::list) refuse(key, raw, where, "");
    if (key.count && raw.list.size() != key.count) refuse(key, raw, where, std::to_string(raw.list.size()) + " values");
    if (holds_texts(key)) {
      std::vector<std::string> texts;
      for (const RawValue& item : raw.list) {
        if (item.kind != Kind::text) refuse(key, raw, where, "");
        texts.push_back(item.text);
      }
      return texts;
    }
    std::vector<double> numbers;
    for (const RawValue& item : raw.list) numbers.push_back(checked_number(key, raw, item, where));
    return numbers;
  }
  if (key.type == "bool") {
    if (raw.kind != Kind::boolean) refuse(key, raw, where, "");
    return raw.boolean;
  }
  if (key.type == "integer") {
    if (raw.kind != Kind::integer) refuse(key, raw, where, "");
    const auto value = static_cast<double>(raw.integer);
    if (value < key.minimum || value > key.maximum) refuse(key, raw, where, "out of range");
    return raw.integer;
  }
  if (key.type == "number") {
    if (key.can_be_auto && asks_for_auto(raw)) return automatic;
    return checked_number(key, raw, raw, where);
  }
  if (raw.kind != Kind::text) refuse(key, raw, where, "");
  if (key.type == "choice" && std::find(key.choices.begin(), key.choices.end(), raw.text) == key.choices.end()) {
    refuse(key, raw, where, "nearest is \"" + nearest_name(raw.text, key.choices) + "\"");
  }
  return raw.text;
}

ConfigValue value_from_text(const ConfigKey& key, std::string_view text, const std::string& where) {
  const std::string_view body = trimmed(text);
  if (!is_list_type(key) || !body.starts_with('[') || !body.ends_with(']')) return checked_value(key, raw_item(key, body), where);
  RawValue raw;
  raw.kind = Kind::list;
  raw.written = std::string(body);
  std::string_view inside = body.substr(1, body.size() - 2);
  while (!trimmed(inside).empty()) {
    const auto comma = std::min(inside.find(','), inside.size());
    raw.list.push_back(raw_item(key, trimmed(inside.substr(0, comma))));
    inside = inside.substr(std::min(comma + 1, inside.size()));
  }
  return checked_value(key, raw, where);
}

}  // namespace mv
