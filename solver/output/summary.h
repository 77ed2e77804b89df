// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// summary.json and run.json: named values with their units in the names, in the order in which they were set.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace mv {

using Json = nlohmann::ordered_json;

/// Nested JSON object addressed by dotted names: set("seal.sealed", true) gives {"seal": {"sealed": true}}. Values that are not
/// finite are written as null.
class Summary {
 public:
  template <class T>
  void set(const std::string& dotted_name, T&& value) {
    at(dotted_name) = Json(std::forward<T>(value));
  }
  const Json& json() const { return root_; }

  /// Atomically. Throws IoError.
  void write(const std::filesystem::path& file) const;

 private:
  Json& at(const std::string& dotted_name);
  Json root_ = Json::object();
};

/// Throws IoError when missing, InputError (with the position) when it is not JSON.
Json read_json(const std::filesystem::path& file);

/// Value at a dotted name, or null.
const Json& json_at(const Json& root, const std::string& dotted_name);

/// Atomically, indented, with a final newline. Throws IoError.
void write_json(const std::filesystem::path& file, const Json& value);

}  // namespace mv
