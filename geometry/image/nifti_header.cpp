// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/nifti_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "geometry/core/errors.h"

namespace mv {
namespace {

struct TypeRow {
  int code, bits;
  bool is_number;  // one whole or real number a voxel
  const char* name;
};
constexpr TypeRow types[] = {{2, 8, true, "uint8"},        {4, 16, true, "int16"},      {8, 32, true, "int32"},
                             {16, 32, true, "float32"},    {64, 64, true, "float64"},   {256, 8, true, "int8"},
                             {512, 16, true, "uint16"},    {768, 32, true, "uint32"},   {1024, 64, true, "int64"},
                             {1280, 64, true, "uint64"},   {1, 1, false, "1-bit binary"}, {32, 64, false, "complex64"},
                             {128, 24, false, "RGB24"},    {1536, 128, false, "float128"}, {1792, 128, false, "complex128"},
                             {2048, 256, false, "complex256"}, {2304, 32, false, "RGBA32"}};

/// Reads numbers at byte offsets in the file's byte order.
class Fields {
 public:
  Fields(std::span<const unsigned char> bytes, bool is_swapped) : bytes_(bytes), is_swapped_(is_swapped) {}
  template <class T>
  T at(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (is_swapped_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

 private:
  std::span<const unsigned char> bytes_;
  bool is_swapped_;
};

/// Where each field lies; `Whole` and `Real` are the types of dimensions and of real numbers.
struct Layout {
  std::size_t dim, datatype, bits, pixdim, slope, inter, q, q_offset, srow;
};
constexpr Layout layout_1{40, 70, 72, 76, 112, 116, 256, 268, 280}, layout_2{16, 12, 14, 104, 176, 184, 352, 376, 400};

template <class Whole, class Real>
void read_common(const Fields& in, const Layout& at, NiftiHeader& h) {
  for (std::size_t i = 0; i < 8; ++i) {
    h.dim[i] = in.at<Whole>(at.dim + i * sizeof(Whole));
    h.pixdim[i] = in.at<Real>(at.pixdim + i * sizeof(Real));
  }
  h.datatype = in.at<std::int16_t>(at.datatype);
  h.bits = in.at<std::int16_t>(at.bits);
  h.slope = in.at<Real>(at.slope);
  h.inter = in.at<Real>(at.inter);
  for (int a = 0; a < 3; ++a) {
    h.quaternion[a] = in.at<Real>(at.q + static_cast<std::size_t>(a) * sizeof(Real));
    h.q_offset[a] = in.at<Real>(at.q_offset + static_cast<std::size_t>(a) * sizeof(Real));
    for (int c = 0; c < 4; ++c) h.srow(a, c) = in.at<Real>(at.srow + static_cast<std::size_t>(4 * a + c) * sizeof(Real));
  }
}

[[noreturn]] void fail(const std::string& name, const std::string& what) { throw InputError(name + ": " + what); }

void check_magic(std::span<const unsigned char> bytes, const NiftiHeader& h, const std::string& name) {
  const auto* magic = reinterpret_cast<const char*>(bytes.data()) + (h.version == 1 ? 344 : 4);
  const std::string found(magic, strnlen(magic, 3));
  const char digit = h.version == 1 ? '1' : '2';
  if (found == std::string("n+") + digit) return;
  if (found == std::string("ni") + digit)
    fail(name, "is the header of a separate .img file; save the label map as one .nii or .nii.gz file");
  if (h.version == 1 && found.empty())
    fail(name, "is an Analyze 7.5 file, which has no orientation; save the label map as NIfTI (.nii or .nii.gz)");
  fail(name, "is no NIfTI file: its magic is not \"n+1\" or \"n+2\"; the file is damaged or of another format");
}

void check_dimensions(const NiftiHeader& h, const std::string& name) {
  if (h.dim[0] < 1 || h.dim[0] > 7)
    fail(name, fmt::format("damaged header: dim[0] = {} where 1 to 7 dimensions are possible", h.dim[0]));
  for (std::size_t i = 1; i <= static_cast<std::size_t>(h.dim[0]); ++i)
    if (h.dim[i] < 1) fail(name, fmt::format("damaged header: dim[{}] = {}, a size must be at least 1", i, h.dim[i]));
  for (std::size_t i = 4; i <= static_cast<std::size_t>(h.dim[0]); ++i)
    if (h.dim[i] > 1)
      fail(name, fmt::format("holds more than one volume (dim[{}] = {}): a label map is one 3D volume; extract the frame you want, with one label per voxel",
                             i, h.dim[i]));
  if (h.dim[0] < 3 || h.dim[1] < 2 || h.dim[2] < 2 || h.dim[3] < 2)
    fail(name, fmt::format("holds a single slice ({} x {} x {} voxels): a valve needs several slices", h.dim[1],
                           h.dim[0] < 2 ? 1 : h.dim[2], h.dim[0] < 3 ? 1 : h.dim[3]));
}

void check_type(const NiftiHeader& h, const std::string& name) {
  if (nifti_type_bytes(h.datatype) == 0)
    fail(name, fmt::format("holds {} values: expected one whole number per voxel (uint8, int16, ..., float32, float64)", nifti_type_name(h.datatype)));
  if (h.bits != 8 * nifti_type_bytes(h.datatype))
    fail(name, fmt::format("damaged header: {} bits per voxel, but its type {} has {}", h.bits, nifti_type_name(h.datatype), 8 * nifti_type_bytes(h.datatype)));
}

}  // namespace

std::string nifti_type_name(int datatype) {
  for (const TypeRow& row : types)
    if (row.code == datatype) return row.name;
  return "type " + std::to_string(datatype);
}

int nifti_type_bytes(int datatype) {
  for (const TypeRow& row : types)
    if (row.code == datatype && row.is_number) return row.bits / 8;
  return 0;
}

NiftiHeader parse_nifti_header(std::span<const unsigned char> bytes, const std::string& name) {
  if (bytes.size() < nifti_header_bytes_1)
    fail(name, fmt::format("is too short for a NIfTI header: {} bytes, at least {} needed; the file is cut off or of another format", bytes.size(), nifti_header_bytes_1));
  NiftiHeader h;
  std::int32_t length = 0;
  for (const bool is_swapped : {false, true}) {
    length = Fields(bytes, is_swapped).at<std::int32_t>(0);
    h.is_swapped = is_swapped;
    if (length == 348 || length == 540) break;
  }
  if (length != 348 && length != 540)
    fail(name, "is no NIfTI file: it does not start with the header length 348 or 540; the file is damaged or of another format");
  h.version = length == 348 ? 1 : 2;
  if (h.version == 2 && bytes.size() < nifti_header_bytes_2)
    fail(name, fmt::format("is too short for a NIfTI-2 header: {} bytes of {}; the file is cut off", bytes.size(), nifti_header_bytes_2));
  check_magic(bytes, h, name);
  const Fields in(bytes, h.is_swapped);
  if (h.version == 1) {
    read_common<std::int16_t, float>(in, layout_1, h);
    h.data_offset = in.at<float>(108);
    h.units = in.at<unsigned char>(123);
    h.qform_code = in.at<std::int16_t>(252);
    h.sform_code = in.at<std::int16_t>(254);
  } else {
    read_common<std::int64_t, double>(in, layout_2, h);
    h.data_offset = static_cast<double>(in.at<std::int64_t>(168));
    h.units = in.at<std::int32_t>(500);
    h.qform_code = in.at<std::int32_t>(344);
    h.sform_code = in.at<std::int32_t>(348);
  }
  check_dimensions(h, name);
  check_type(h, name);
  return h;
}

}  // namespace mv
