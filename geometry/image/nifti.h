// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Label maps from NIfTI-1 and NIfTI-2 files, .nii or .nii.gz.

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/image/label_image.h"
#include "geometry/image/nifti_header.h"

namespace mv {

struct NiftiOptions {
  /// auto: sform and qform when they agree, or the only one that is set. spacing: voxel sizes only, no orientation (left and right may be
  /// swapped).
  std::string transform = "auto";  // auto | sform | qform | spacing
  std::string unit = "auto";       // auto: as the header says | mm | m | um
  double agreement = 0.1;          // voxels: by how far a corner of the image may differ between sform and qform
};

struct NiftiLabels {
  LabelImage image;
  std::vector<std::string> notes;  // what was assumed: unit, chosen transform, left-handed axes
};

/// The image's place in the world, mm: columns of axes, then the origin. `notes` receives what was assumed. Throws InputError when sform and
/// qform disagree (both printed, with the key that chooses), none is set, a value is not finite, a voxel size is zero or the axes are
/// singular.
Eigen::Matrix<double, 3, 4> nifti_transform(const NiftiHeader& header, const NiftiOptions& options, const std::string& name,
                                            std::vector<std::string>& notes);

/// Reads a label map. Values are scaled by scl_slope and scl_inter when these are set and must then be whole numbers. Nothing is allocated
/// before the file is known to be able to hold what its header promises. Throws IoError when unreadable, InputError when damaged.
NiftiLabels read_nifti_labels(const std::filesystem::path& file, const NiftiOptions& options = {});

}  // namespace mv
