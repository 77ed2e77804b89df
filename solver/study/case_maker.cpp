// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/case_maker.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <vector>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "solver/study/timed_process.h"

namespace mv {

namespace fs = std::filesystem;

namespace {

bool is_program(const fs::path& file) { return fs::is_regular_file(file) && ::access(file.c_str(), X_OK) == 0; }

/// Text of the last error in a log, all its lines in one.
std::string last_error(const std::string& log) {
  std::istringstream lines(log);
  std::string error;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("error ")) error = line.substr(6);
    else if (line.starts_with("info ") || line.starts_with("warning ") || line.starts_with("debug ")) continue;
    else if (!error.empty() && !line.empty()) error += "; " + line.substr(line.find_first_not_of(" \t") == std::string::npos ? 0 : line.find_first_not_of(" \t"));
  }
  return error;
}

}  // namespace

fs::path find_mvprep(const fs::path& given) {
  if (!given.empty()) {
    if (is_program(given)) return fs::absolute(given);
    throw IoError(fmt::format("{}: is no program that can be run; --mvprep must name mvprep", given.string()));
  }
  std::error_code ignored;
  const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
  if (const fs::path beside = self.parent_path() / "mvprep"; !self.empty() && is_program(beside)) return beside;
  if (const char* path = std::getenv("PATH")) {
    std::istringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');)
      if (!folder.empty() && is_program(fs::path(folder) / "mvprep")) return fs::absolute(fs::path(folder) / "mvprep");
  }
  throw IoError("mvprep was found neither beside mvsolve nor in PATH; studies make their cases with it: build it, or name it with --mvprep");
}

CaseMaker::CaseMaker(fs::path study_directory, fs::path mvprep) : directory_(fs::absolute(study_directory) / "cases"), mvprep_(std::move(mvprep)) {}

MadeCase CaseMaker::make(const std::string& name, const std::string& toml) {
  if (name.empty() || name.starts_with('.') || name.find('/') != std::string::npos)
    throw UsageError(fmt::format("case name '{}': a plain file name was expected", name));
  mvprep_ = find_mvprep(mvprep_);
  std::error_code code;
  fs::create_directories(directory_, code);
  if (code) throw IoError(fmt::format("{}: cannot be created: {}", directory_.string(), code.message()));
  const fs::path config = directory_ / (name + ".toml"), log = directory_ / (name + ".log");
  write_text_atomically(config, toml);
  MadeCase made;
  made.directory = directory_ / name;
  made.exit_code = run_timed(mvprep_, {"run", "-c", config.string(), "-o", made.directory.string()}, log).exit_code;
  if (!made.is_made()) {
    made.error = last_error(read_file(log));
    if (made.error.empty()) made.error = fmt::format("mvprep ended with code {}, see {}", made.exit_code, log.string());
  }
  return made;
}

}  // namespace mv
