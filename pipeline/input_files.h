// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The files (or folders of files) that a configuration names, and their copies in the case.

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

/// A named file, or a folder's regular files (hidden ones and sub-folders are left out), as they are copied.
struct InputFile {
  std::string name;  // of the copy, relative to the case
  std::string text;
};
struct Input {
  std::string
      name;  // of the copy of the file or folder, relative to the case: inputs/KEY.EXT, inputs/KEY.NUMBER.EXT or inputs/KEY
  std::vector<InputFile> files;
};

/// Reads a file or a folder. `label`: the key, with its number for a list. Double extensions such as .nii.gz and .mrk.json are
/// kept. Throws IoError for what is missing or unreadable, and for an empty folder.
Input read_input(const std::string& label, const std::filesystem::path& path);

/// SHA-256 of a file; of a folder: of the names and hashes of its files in alphabetical order. Throws IoError.
std::string sha256_of_input(const std::filesystem::path& path);

}  // namespace mv
