// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// NIfTI files made for the tests, sound or broken in one place.

#include <zlib.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "geometry/core/case.h"

namespace mv::test {

struct NiftiFile {
  int version = 1;
  bool is_swapped = false;  // the other byte order
  std::vector<std::int64_t> dim{3, 1, 1, 1, 1, 1, 1, 1};
  std::array<double, 8> pixdim{1, 1, 1, 1, 1, 1, 1, 1};
  int datatype = 2, bits = 8, units = 2;
  double slope = 0, inter = 0;
  int qform = 1, sform = 1;
  Vec3 quaternion = Vec3::Zero(), q_offset = Vec3::Zero();
  Eigen::Matrix<double, 3, 4> srow = Eigen::Matrix<double, 3, 4>::Identity();
  std::string magic;  // empty: the right one
  std::vector<double> values;

  void set_size(int nx, int ny, int nz) {
    dim = {3, nx, ny, nz, 1, 1, 1, 1};
    values.assign(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz), 0);
  }
  /// Both transforms from axes (mm) and origin; the axes must be perpendicular.
  void place(const Mat3& axes, const Vec3& origin) {
    srow << axes, origin;
    q_offset = origin;
    Mat3 turn = axes;
    for (int a = 0; a < 3; ++a) {
      pixdim[static_cast<std::size_t>(a) + 1] = axes.col(a).norm();
      turn.col(a).normalize();
    }
    pixdim[0] = 1;
    if (turn.determinant() < 0) turn.col(2) = -turn.col(2), pixdim[0] = -1;
    Eigen::Quaterniond q(turn);
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    quaternion = q.vec();
  }
  void set_type(int code, int bits_of_it) { datatype = code, bits = bits_of_it; }
};

namespace detail {
template <class T>
void put(std::string& bytes, std::size_t at, double value, bool is_swapped) {
  T x;
  if constexpr (std::is_floating_point_v<T>) x = static_cast<T>(value);
  else x = value < 0 ? static_cast<T>(static_cast<std::int64_t>(value)) : static_cast<T>(static_cast<std::uint64_t>(value));
  unsigned char raw[sizeof(T)];
  std::memcpy(raw, &x, sizeof(T));
  if (is_swapped) std::reverse(raw, raw + sizeof(T));
  std::memcpy(bytes.data() + at, raw, sizeof(T));
}
template <class T>
void put_values(std::string& bytes, const NiftiFile& f) {
  const std::size_t start = bytes.size();
  bytes.resize(start + f.values.size() * sizeof(T));
  for (std::size_t v = 0; v < f.values.size(); ++v) put<T>(bytes, start + v * sizeof(T), f.values[v], f.is_swapped);
}
}  // namespace detail

inline std::string nifti_header(const NiftiFile& f) {
  using detail::put;
  const bool s = f.is_swapped;
  const bool one = f.version == 1;
  std::string b(one ? 352 : 544, '\0');
  put<std::int32_t>(b, 0, one ? 348 : 540, s);
  const std::string magic = !f.magic.empty() ? f.magic : one ? std::string("n+1\0", 4) : std::string("n+2\0\r\n\032\n", 8);
  std::memcpy(b.data() + (one ? 344 : 4), magic.data(), magic.size());
  for (std::size_t i = 0; i < 8; ++i) {
    if (one) put<std::int16_t>(b, 40 + 2 * i, static_cast<double>(f.dim[i]), s), put<float>(b, 76 + 4 * i, f.pixdim[i], s);
    else put<std::int64_t>(b, 16 + 8 * i, static_cast<double>(f.dim[i]), s), put<double>(b, 104 + 8 * i, f.pixdim[i], s);
  }
  put<std::int16_t>(b, one ? 70 : 12, f.datatype, s);
  put<std::int16_t>(b, one ? 72 : 14, f.bits, s);
  const auto real = [&](std::size_t at_1, std::size_t at_2, double x) { one ? put<float>(b, at_1, x, s) : put<double>(b, at_2, x, s); };
  if (one) put<float>(b, 108, 352, s);
  else put<std::int64_t>(b, 168, 544, s);
  real(112, 176, f.slope), real(116, 184, f.inter);
  if (one) b[123] = static_cast<char>(f.units), put<std::int16_t>(b, 252, f.qform, s), put<std::int16_t>(b, 254, f.sform, s);
  else put<std::int32_t>(b, 500, f.units, s), put<std::int32_t>(b, 344, f.qform, s), put<std::int32_t>(b, 348, f.sform, s);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    real(256 + 4 * a, 352 + 8 * a, f.quaternion[i]), real(268 + 4 * a, 376 + 8 * a, f.q_offset[i]);
    for (std::size_t c = 0; c < 4; ++c) real(280 + 16 * a + 4 * c, 400 + 32 * a + 8 * c, f.srow(i, static_cast<Eigen::Index>(c)));
  }
  return b;
}

inline std::string nifti_bytes(const NiftiFile& f) {
  std::string b = nifti_header(f);
  switch (f.datatype) {
    case 4: detail::put_values<std::int16_t>(b, f); break;
    case 8: detail::put_values<std::int32_t>(b, f); break;
    case 16: detail::put_values<float>(b, f); break;
    case 64: detail::put_values<double>(b, f); break;
    case 256: detail::put_values<std::int8_t>(b, f); break;
    case 512: detail::put_values<std::uint16_t>(b, f); break;
    case 768: detail::put_values<std::uint32_t>(b, f); break;
    case 1024: detail::put_values<std::int64_t>(b, f); break;
    case 1280: detail::put_values<std::uint64_t>(b, f); break;
    default: detail::put_values<std::uint8_t>(b, f);
  }
  return b;
}

inline void write_bytes(const std::string& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

/// Compressed when the name ends in .gz.
inline void write_nifti(const std::string& file, const NiftiFile& f) {
  const std::string bytes = nifti_bytes(f);
  if (!file.ends_with(".gz")) return write_bytes(file, bytes);
  gzFile out = gzopen(file.c_str(), "wb");
  gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size()));
  gzclose(out);
}

/// Fills the values: value(x) at every voxel's centre (mm).
inline void voxelise(NiftiFile& f, const std::function<double(const Vec3&)>& value) {
  std::size_t v = 0;
  for (std::int64_t k = 0; k < f.dim[3]; ++k)
    for (std::int64_t j = 0; j < f.dim[2]; ++j)
      for (std::int64_t i = 0; i < f.dim[1]; ++i, ++v)
        f.values[v] = value(f.srow * Eigen::Vector4d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k), 1));
}

}  // namespace mv::test
