// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace mv {

/// Whole file as bytes, unpacked when it is a gzip file (by its first two bytes, whatever its name). Throws IoError when unreadable, InputError when the
/// packed data are damaged, truncated or unpack to more than 2 GB.
std::string read_file_unpacked(const std::filesystem::path& file);

}  // namespace mv
