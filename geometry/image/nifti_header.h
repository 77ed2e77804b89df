// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The header of a NIfTI file, read field by field from its bytes: NIfTI-1 (348 bytes) and NIfTI-2 (540 bytes), either byte order.
// nifti.nimh.nih.gov/nifti-1, nifti-2.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "geometry/core/case.h"

namespace mv {

inline constexpr std::size_t nifti_header_bytes_1 = 348, nifti_header_bytes_2 = 540;

struct NiftiHeader {
  int version = 1;            // 1 or 2
  bool is_swapped = false;    // the other byte order
  std::array<std::int64_t, 8> dim{};
  int datatype = 0, bits = 0;
  std::array<double, 8> pixdim{};
  double data_offset = 0;     // bytes from the start of the (uncompressed) file
  double slope = 0, inter = 0;
  int units = 0;              // xyzt_units as in the file; lengths are its lowest three bits
  int qform_code = 0, sform_code = 0;
  Vec3 quaternion = Vec3::Zero(), q_offset = Vec3::Zero();
  Eigen::Matrix<double, 3, 4> srow = Eigen::Matrix<double, 3, 4>::Zero();
};

/// The header in `bytes` (the start of the file: 540 bytes, or 348 if there are no more). `name` opens the messages. Throws InputError: too
/// short, no NIfTI header, a header for a separate .img file, inconsistent dimensions or types.
NiftiHeader parse_nifti_header(std::span<const unsigned char> bytes, const std::string& name);

/// "uint8", "RGB24", ... or "type 77".
std::string nifti_type_name(int datatype);
/// Bytes of one value of a whole or real number type; 0 for every other type.
int nifti_type_bytes(int datatype);

}  // namespace mv
