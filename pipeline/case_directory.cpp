// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/case_directory.h"

#include <unistd.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/version.h"

namespace mv {
namespace {

const std::string work_prefix = ".stage-";

std::string quoted(const std::string& text) {
  static const ConfigKey plain{"", "string", Dimension::none, "", std::string(), false, 0, {}, 0, 0, ""};
  return value_text(plain, ConfigValue(text));
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure || !std::filesystem::is_directory(directory)) {
    throw IoError("cannot create the directory " + directory.string() + ": " +
                  (failure ? failure.message() : "a file is in the way"));
  }
}

}  // namespace

Config set_up_case(const Config& config, const std::filesystem::path& origin, const std::filesystem::path& case_directory,
                   std::map<std::string, std::string>& inputs) {
  struct Copy {
    std::string key, name, text, hash, source;
  };
  std::vector<Copy> copies;
  for (const ConfigKey& key : config_schema()) {
    if (key.type != "path" || config.text(key.name).empty()) continue;
    const auto source = config.path(key.name);
    std::string text;
    try {
      text = read_file(source);
    } catch (const IoError& e) {
      throw IoError(origin.string() + ": key '" + key.name + "' = \"" + config.text(key.name) + "\": " + e.what());
    }
    copies.push_back({key.name, "inputs/" + key.name + source.extension().string(), text, sha256(text), config.text(key.name)});
  }
  const std::string origin_hash = std::filesystem::exists(origin) ? sha256_of_file(origin) : "";

  make_directory(case_directory);
  remove_leftovers(case_directory);
  if (!copies.empty()) make_directory(case_directory / "inputs");
  Config resolved = config;
  inputs.clear();
  std::string provenance = "\n[provenance]\nprogram = " + quoted("mvprep " + version()) +
                           "\nrevision = " + quoted(git_revision()) + "\nconfig = " + quoted(origin.filename().string()) +
                           "\nconfig_sha256 = " + quoted(origin_hash) + "\n";
  for (const Copy& copy : copies) {
    write_text_atomically(case_directory / copy.name, copy.text);
    resolved.set(copy.key + "=" + copy.name);
    inputs[copy.name] = copy.hash;
    provenance += "\n[provenance.inputs." + quoted(copy.key) + "]\nsource = " + quoted(copy.source) +
                  "\nsha256 = " + quoted(copy.hash) + "\n";
  }
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
  return Config::from_file(file);
}

StageDirectory::StageDirectory(const std::filesystem::path& case_directory, const std::string& stage)
    : case_directory_(case_directory), path_(case_directory / (work_prefix + stage + "-" + std::to_string(::getpid()))) {
  make_directory(path_);
}

StageDirectory::~StageDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::map<std::string, std::string> StageDirectory::publish(const std::vector<std::string>& files) {
  std::map<std::string, std::string> hashes;
  for (const std::string& file : files) {
    if (!std::filesystem::exists(path_ / file)) throw std::logic_error("the stage has not written " + file);
    hashes[file] = sha256_of_file(path_ / file);
  }
  for (const std::string& file : files) {
    std::error_code failure;
    std::filesystem::rename(path_ / file, case_directory_ / file, failure);
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
