// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/manifest.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/version.h"
#include "pipeline/input_files.h"
#include "pipeline/interrupt.h"
#include "pipeline/stage_table.h"

namespace mv {
namespace {

constexpr int manifest_version = 1;

/// The revision tells two builds apart, except where it does not name the sources exactly.
const std::string& build_identity() {
  static const std::string identity = [] {
    std::string text = version() + " " + git_revision();
    if (git_revision() == "unknown" || git_revision().ends_with("-dirty")) text += " " + sha256_of_file("/proc/self/exe");
    return text;
  }();
  return identity;
}

/// The stage that leaves the file as it stays: the last in the table that has run and names it.
const StageRecord* last_writer(const std::string& file, const Manifest& manifest) {
  const StageRecord* last = nullptr;
  for (const Stage& stage : stage_table()) {
    const auto record = manifest.stages.find(stage.name);
    if (record != manifest.stages.end() && record->second.outputs.contains(file)) last = &record->second;
  }
  return last;
}

bool is_under(const std::string& key, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(),
                     [&](const std::string& p) { return key == p || key.starts_with(p + "."); });
}

}  // namespace

Manifest read_manifest(const std::filesystem::path& case_directory) {
  const auto file = case_directory / "manifest.json";
  Manifest manifest;
  if (!std::filesystem::exists(file)) return manifest;
  try {
    const auto json = nlohmann::json::parse(read_file(file));
    if (json.at("manifest_version").get<int>() != manifest_version) return manifest;
    manifest.inputs = json.at("inputs").get<std::map<std::string, std::string>>();
    for (const auto& [name, record] : json.at("stages").items()) {
      manifest.stages[name] = {record.at("key").get<std::string>(),
                               record.at("outputs").get<std::map<std::string, std::string>>()};
    }
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": damaged (" + e.what() + "); delete it and run mvprep again");
  }
  return manifest;
}

void write_manifest(const std::filesystem::path& case_directory, const Manifest& manifest, const Config& config) {
  const Uninterrupted writes;
  nlohmann::ordered_json json;
  json["manifest_version"] = manifest_version;
  json["program"] = "mvprep";
  json["version"] = version();
  json["revision"] = git_revision();
  std::istringstream libraries(library_versions());
  for (std::string line; std::getline(libraries, line);) {
    const auto space = line.find(' ');
    json["libraries"][line.substr(0, space)] = line.substr(space + 1);
  }
  for (const ConfigKey& key : config_schema()) {
    const std::string written = config.fingerprint({key.name});
    json["options"][key.name] = written.substr(key.name.size() + 3, written.size() - key.name.size() - 4);
  }
  json["inputs"] = manifest.inputs;
  json["stages"] = nlohmann::ordered_json::object();
  for (const Stage& stage : stage_table()) {
    const auto record = manifest.stages.find(stage.name);
    if (record == manifest.stages.end()) continue;
    json["stages"][stage.name] = {{"key", record->second.key}, {"outputs", record->second.outputs}};
  }
  write_text_atomically(case_directory / "manifest.json", json.dump(2) + "\n");
}

std::string stage_key(const Stage& stage, const Config& config, const Manifest& manifest) {
  std::string text = stage.name + "\n" + build_identity() + "\n" + config.fingerprint(stage.config_keys);
  for (const ConfigKey& key : config_schema()) {
    if ((key.type != "path" && key.type != "paths") || !is_under(key.name, stage.config_keys)) continue;
    for (const auto& path : config.paths(key.name)) text += key.name + " " + sha256_of_input(path) + "\n";
  }
  for (const std::string& need : stage.needs) {
    const auto record = manifest.stages.find(need);
    if (record == manifest.stages.end()) return "";
    for (const auto& [file, hash] : record->second.outputs) text += need + " " + file + " " + hash + "\n";
  }
  return sha256(text);
}

bool is_up_to_date(const Stage& stage, const Config& config, const Manifest& manifest,
                   const std::filesystem::path& case_directory) {
  const auto record = manifest.stages.find(stage.name);
  if (record == manifest.stages.end() || record->second.key.empty()) return false;
  if (record->second.key != stage_key(stage, config, manifest)) return false;
  return std::all_of(stage.outputs.begin(), stage.outputs.end(), [&](const std::string& file) {
    const StageRecord* writer = last_writer(file, manifest);
    const auto path = case_directory / file;
    return record->second.outputs.contains(file) && std::filesystem::exists(path) &&
           sha256_of_file(path) == writer->outputs.at(file);
  });
}

std::vector<std::string> changed_outputs(const Stage& stage, const Manifest& manifest,
                                         const std::filesystem::path& case_directory) {
  std::vector<std::string> changed;
  for (const std::string& file : stage.outputs) {
    const StageRecord* writer = last_writer(file, manifest);
    const auto path = case_directory / file;
    if (writer && std::filesystem::exists(path) && sha256_of_file(path) != writer->outputs.at(file)) changed.push_back(file);
  }
  return changed;
}

}  // namespace mv
