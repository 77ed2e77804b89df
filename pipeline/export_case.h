// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A case for other programs.

#include <filesystem>
#include <string>
#include <vector>

namespace mv {

/// Copies of the case's VTK files (mid_surface.vtp, annulus.vtp, papillary.vtp,
/// leaflets.vtu, chordae.vtp, tube.vtu; those that exist) in the asked space, which their field data SPACE names. LPS negates x
/// and y of points and of vectors in space (fibre, sheet_normal, normal, axis ...); lengths, indices and what lives in the tube's
/// own frame stay. Prints what was written. mvsolve and mvprep refuse files in LPS: they are for other programs. Throws
/// UsageError for `directory` being the case itself, IoError, InputError.
std::vector<std::filesystem::path> export_case(const std::filesystem::path& case_directory, const std::filesystem::path& directory,
                    const std::string& space);

}  // namespace mv
