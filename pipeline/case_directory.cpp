// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/case_directory.h"

#include <toml++/toml.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/version.h"
#include "pipeline/input_files.h"
#include "pipeline/interrupt.h"

namespace mv {
namespace {

const std::string work_prefix = ".stage-";
const std::string folder_key = "curves.slices";  // the one that may name a folder

std::string quoted(const std::string& text) {
  static const ConfigKey plain{"", "string", Dimension::none, "", std::string(), false, 0, {}, 0, 0, ""};
  return value_text(plain, ConfigValue(text));
}

/// A file or folder that a key names.
struct NamedInput {
  std::string key, label, source, hash;
  Input input;
};

/// Reads everything before anything is written, so that a case may be set up from its own copies.
std::vector<NamedInput> read_inputs(const Config& config, const std::filesystem::path& origin, const std::vector<MadeInput>& made) {
  std::vector<NamedInput> inputs;
  for (const MadeInput& m : made) {
    const std::string name = "inputs/" + m.key + m.extension;
    inputs.push_back({m.key, m.key, m.source, sha256(m.text), Input{name, {{name, m.text}}}});
  }
  for (const ConfigKey& key : config_schema()) {
    if (key.type != "path" && key.type != "paths") continue;
    if (std::any_of(made.begin(), made.end(), [&](const MadeInput& m) { return m.key == key.name; })) continue;
    const bool is_list = key.type == "paths";
    const auto sources = is_list ? config.texts(key.name) : std::vector<std::string>{config.text(key.name)};
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const std::string& source = sources[i];
      if (source.empty()) continue;
      const std::string label = is_list ? key.name + "." + std::to_string(i + 1) : key.name;
      const auto path = config.base_directory() / source;
      if (key.name != folder_key && std::filesystem::is_directory(path))
        throw IoError(origin.string() + ": key '" + key.name + "' = \"" + source + "\" is a directory; expected a file: " + key.doc);
      try {
        inputs.push_back({key.name, label, source, sha256_of_input(path), read_input(label, path)});
      } catch (const IoError& e) {
        throw IoError(origin.string() + ": key '" + key.name + "' = \"" + source + "\": " + e.what());
      }
    }
  }
  return inputs;
}

std::string list_text(const std::vector<std::string>& texts) {
  std::string list;
  for (const std::string& text : texts) list += (list.empty() ? "" : ", ") + quoted(text);
  return "[" + list + "]";
}

}  // namespace

Config set_up_case(const Config& config, const std::filesystem::path& origin, const std::filesystem::path& case_directory,
                   std::map<std::string, std::string>& inputs, const std::vector<MadeInput>& made) {
  const std::vector<NamedInput> copies = read_inputs(config, origin, made);
  const std::string origin_hash = std::filesystem::exists(origin) ? sha256_of_file(origin) : "";

  make_directory(case_directory);
  const Uninterrupted writes;
  remove_leftovers(case_directory);
  if (!copies.empty()) make_directory(case_directory / "inputs");
  Config resolved = config;
  inputs.clear();
  std::string provenance = "\n[provenance]\nprogram = " + quoted("mvprep " + version()) +
                           "\nrevision = " + quoted(git_revision()) + "\nconfig = " + quoted(origin.filename().string()) +
                           "\nconfig_sha256 = " + quoted(origin_hash) + "\n";
  std::map<std::string, std::vector<std::string>> lists;
  for (const NamedInput& copy : copies) {
    if (copy.input.files.front().name != copy.input.name) make_directory(case_directory / copy.input.name);
    for (const InputFile& file : copy.input.files) {
      write_text_atomically(case_directory / file.name, file.text);
      inputs[file.name] = sha256(file.text);
    }
    if (config_key(copy.key).type == "path")
      resolved.set(copy.key + "=" + copy.input.name);
    else
      lists[copy.key].push_back(copy.input.name);
    provenance += "\n[provenance.inputs." + quoted(copy.label) + "]\nsource = " + quoted(copy.source) +
                  "\nsha256 = " + quoted(copy.hash) + "\n";
  }
  for (const auto& [key, names] : lists) resolved.set(key + "=" + list_text(names));
  resolved.set_base_directory(std::filesystem::absolute(case_directory));
  write_text_atomically(case_directory / "case.toml",
                        "format_version = " + std::to_string(case_format_version) + "\n\n" + resolved.to_toml() + provenance);
  return resolved;
}

Config read_case_config(const std::filesystem::path& case_directory) {
  const auto file = case_directory / "case.toml";
  if (!std::filesystem::exists(file)) {
    throw IoError(case_directory.string() + " is no case: it has no case.toml; make one with `mvprep run -c config.toml -o " +
                  case_directory.string() + "`");
  }
  return Config::from_case_file(file);
}

std::string with_sources(std::string text, const std::filesystem::path& case_directory) {
  std::vector<std::pair<std::string, std::string>> sources;  // KEY, or KEY.NUMBER for a list, and what the user's configuration says
  try {
    const toml::table table = toml::parse_file((case_directory / "case.toml").string());
    if (const toml::table* inputs = table["provenance"]["inputs"].as_table())
      for (const auto& [label, input] : *inputs)
        if (const auto source = input.at_path("source").value<std::string>(); source && !source->empty()) sources.emplace_back(label.str(), *source);
  } catch (const toml::parse_error&) {
    return text;  // whoever reads the case says so
  }
  std::stable_sort(sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });  // KEY.10 before KEY.1
  const auto is_word = [&](std::size_t i) { return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0; };
  for (const auto& [label, source] : sources) {
    const std::string copy = (std::filesystem::absolute(case_directory) / "inputs" / label).string();
    for (std::size_t begin = 0; (begin = text.find(copy, begin)) != std::string::npos; begin += source.size()) {
      std::size_t end = begin + copy.size();  // its ending goes with it
      while (is_word(end) || (end < text.size() && text[end] == '.' && is_word(end + 1))) ++end;
      text.replace(begin, end - begin, source);
    }
  }
  return text;
}

StageDirectory::StageDirectory(const std::filesystem::path& case_directory, const std::string& stage)
    : case_directory_(case_directory), directory_(case_directory / (work_prefix + stage + "-" + std::to_string(::getpid()))) {}

std::map<std::string, std::string> StageDirectory::publish(const std::vector<std::string>& files) {
  std::map<std::string, std::string> hashes;
  for (const std::string& file : files) {
    if (!std::filesystem::exists(path() / file)) throw std::logic_error("the stage has not written " + file);
    hashes[file] = sha256_of_file(path() / file);
  }
  const Uninterrupted writes;
  for (const std::string& file : files) {
    std::error_code failure;
    std::filesystem::rename(path() / file, case_directory_ / file, failure);
    if (failure) throw IoError("cannot replace " + (case_directory_ / file).string() + ": " + failure.message());
  }
  return hashes;
}

void remove_leftovers(const std::filesystem::path& case_directory) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(case_directory, ignored)) {
    if (entry.path().filename().string().starts_with(work_prefix)) std::filesystem::remove_all(entry.path(), ignored);
  }
}

}  // namespace mv
