// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// CASE/ as a directory: it takes the configuration and the files this names, so that it can be moved and archived by itself.

#include <filesystem>

#include "pipeline/interrupt.h"
#include "pipeline/manifest.h"

namespace mv {

/// A file that a key is to name and that mvprep makes itself, such as a motion table from a deck.
struct MadeInput {
  std::string key, extension;  // ".csv"
  std::string text;
  std::string source;          // what it was made from, for the provenance
};

/// Creates the directory if needed, copies every file the configuration names to inputs/KEY.EXT, writes case.toml
/// (format_version, all values, [provenance]) and returns the configuration as the case holds it. `origin` is the configuration
/// file. `inputs` receives the hashes. `made` stands in place of the files that its keys name. Throws IoError.
Config set_up_case(const Config& config, const std::filesystem::path& origin, const std::filesystem::path& case_directory,
                   std::map<std::string, std::string>& inputs, const std::vector<MadeInput>& made = {});

/// case.toml of an existing case. Throws IoError when there is none, naming the command that makes one.
Config read_case_config(const std::filesystem::path& case_directory);

/// The text of a message with the user's files named in place of their copies in the case's inputs/.
std::string with_sources(std::string text, const std::filesystem::path& case_directory);

/// A directory inside the case for one stage's files. publish() renames them into the case; what was not published disappears
/// with the object.
class StageDirectory {
 public:
  StageDirectory(const std::filesystem::path& case_directory, const std::string& stage);

  const std::filesystem::path& path() const { return directory_.path(); }
  /// Returns file -> SHA-256. Throws std::logic_error when the stage has not written one of them.
  std::map<std::string, std::string> publish(const std::vector<std::string>& files);

 private:
  std::filesystem::path case_directory_;
  UnfinishedDirectory directory_;
};

/// Removes what a killed run left behind.
void remove_leftovers(const std::filesystem::path& case_directory);

}  // namespace mv
