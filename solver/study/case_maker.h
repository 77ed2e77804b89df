// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Cases for studies. Making a case is mvprep's work: it runs as a program of its own on a configuration that the study writes, so that
// mvsolve links nothing of it. The two meet in the case directory only.

#include <filesystem>
#include <string>

namespace mv {

struct MadeCase {
  std::filesystem::path directory;  // what load_scene reads
  int exit_code = 0;                // of mvprep (ExitCode), 128 + signal when it was killed
  std::string error;                // its last error, "" when it succeeded
  bool is_made() const { return exit_code == 0; }
};

/// The first of: `given` (when not empty), "mvprep" beside the running program, "mvprep" in PATH. Throws IoError when there is none.
std::filesystem::path find_mvprep(const std::filesystem::path& given = {});

/// Makes and reuses cases in a study's directory.
class CaseMaker {
 public:
  /// Cases go to `study_directory`/cases. mvprep is looked for at the first case (find_mvprep).
  explicit CaseMaker(std::filesystem::path study_directory, std::filesystem::path mvprep = {});

  /// Writes cases/NAME.toml and runs `mvprep run -c cases/NAME.toml -o cases/NAME`, whose log goes to cases/NAME.log. mvprep skips what
  /// is unchanged since the last call, of an earlier study too. A case that mvprep refuses is returned with its exit code and error. Throws
  /// UsageError for a name that is no plain file name, IoError when mvprep is missing or cannot be started, or a file cannot be written.
  MadeCase make(const std::string& name, const std::string& toml);

 private:
  std::filesystem::path directory_, mvprep_;
};

}  // namespace mv
