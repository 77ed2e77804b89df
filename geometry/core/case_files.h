// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Reading and writing the parts of CASE/ (VTK XML files; VTK stays inside the .cpp). Every file is written under a temporary name and
// renamed. Every file carries field data UnitSystem, SPACE (RAS) and one unit per array ("unit:NAME").
// All readers check sizes, index ranges and finiteness and throw InputError naming file and array; writers throw IoError.

#include <filesystem>
#include <string>

#include "geometry/core/case.h"

namespace mv {

void write_leaflets(const std::filesystem::path& file, const LeafletMesh& mesh);
LeafletMesh read_leaflets(const std::filesystem::path& file);

void write_chordae(const std::filesystem::path& file, const Chordae& chordae);
Chordae read_chordae(const std::filesystem::path& file);

void write_tube(const std::filesystem::path& file, const Tube& tube);
Tube read_tube(const std::filesystem::path& file);

void write_annulus(const std::filesystem::path& file, const Annulus& annulus);
Annulus read_annulus(const std::filesystem::path& file);

void write_papillary(const std::filesystem::path& file, const Papillary& papillary);
Papillary read_papillary(const std::filesystem::path& file);

/// Writes text to `file` through a temporary name in the same directory and a rename. Throws IoError (disk full, permissions)
/// and leaves neither a temporary nor a half-written file behind.
void write_text_atomically(const std::filesystem::path& file, const std::string& text);

/// Whole file as bytes. Throws IoError when missing or unreadable.
std::string read_file(const std::filesystem::path& file);

/// SHA-256 as lower-case hex.
std::string sha256(const std::string& bytes);
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace mv
