// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/summary.h"

#include <stdexcept>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {

Json& Summary::at(const std::string& dotted_name) {
  Json* node = &root_;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t dot = dotted_name.find('.', begin);
    const std::string key = dotted_name.substr(begin, dot == std::string::npos ? dot : dot - begin);
    if (!node->is_object() && !node->is_null())
      throw std::logic_error("summary: '" + dotted_name + "' passes through a value that is not an object");
    node = &(*node)[key];
    if (dot == std::string::npos) return *node;
    begin = dot + 1;
  }
}

void Summary::write(const std::filesystem::path& file) const { write_json(file, root_); }

Json read_json(const std::filesystem::path& file) {
  const std::string text = read_file(file);
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::parse_error& e) {
    throw InputError(file.string() + ": not valid JSON at byte " + std::to_string(e.byte) + " (damaged or incomplete?)");
  }
}

const Json& json_at(const Json& root, const std::string& dotted_name) {
  static const Json nothing;
  const Json* node = &root;
  std::size_t begin = 0;
  for (;;) {
    const std::size_t dot = dotted_name.find('.', begin);
    const std::string key = dotted_name.substr(begin, dot == std::string::npos ? dot : dot - begin);
    if (!node->is_object()) return nothing;
    const auto found = node->find(key);
    if (found == node->end()) return nothing;
    node = &*found;
    if (dot == std::string::npos) return *node;
    begin = dot + 1;
  }
}

void write_json(const std::filesystem::path& file, const Json& value) {
  write_text_atomically(file, value.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace mv
