// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/input_files.h"

#include <algorithm>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

std::string full_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  const std::string inner = path.stem().extension().string();
  if (extension == ".gz" || inner == ".mrk") extension = inner + extension;
  return extension;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file() && !entry.path().filename().string().starts_with(".")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) throw IoError(folder.string() + " holds no files");
  return files;
}

}  // namespace

Input read_input(const std::string& label, const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) {
    const std::string name = "inputs/" + label + full_extension(path);
    return {name, {{name, read_file(path)}}};
  }
  Input input{"inputs/" + label, {}};
  for (const auto& file : files_in(path)) input.files.push_back({input.name + "/" + file.filename().string(), read_file(file)});
  return input;
}

std::string sha256_of_input(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return sha256_of_file(path);
  std::string text;
  for (const auto& file : files_in(path)) text += file.filename().string() + " " + sha256_of_file(file) + "\n";
  return sha256(text);
}

}  // namespace mv
