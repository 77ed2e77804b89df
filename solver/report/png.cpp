// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/png.h"

#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

namespace mv {

namespace {

void put32(std::string& out, std::uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(v >> shift & 0xff);
}

void put_chunk(std::string& out, const std::string& type, const std::string& data) {
  put32(out, static_cast<std::uint32_t>(data.size()));
  const std::string body = type + data;
  out += body;
  put32(out, static_cast<std::uint32_t>(
                 crc32(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

int paeth(int a, int b, int c) {
  const int p = a + b - c, pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
  return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
}

/// One row behind its filter byte, with the filter (0 none, 1 left, 2 up, 4 Paeth) whose residuals are smallest in sum.
std::string filtered_row(const unsigned char* row, const unsigned char* above, int bytes) {
  std::string best, line(static_cast<std::size_t>(bytes) + 1, '\0');
  long best_cost = -1;
  for (int filter : {0, 1, 2, 4}) {
    line[0] = static_cast<char>(filter);
    long cost = 0;
    for (int i = 0; i < bytes; ++i) {
      const int left = i >= 3 ? row[i - 3] : 0, up = above != nullptr ? above[i] : 0,
                corner = i >= 3 && above != nullptr ? above[i - 3] : 0;
      const int predicted = filter == 0 ? 0 : filter == 1 ? left : filter == 2 ? up : paeth(left, up, corner);
      const auto residual = static_cast<signed char>(row[i] - predicted);
      cost += std::abs(static_cast<int>(residual));
      line[static_cast<std::size_t>(i) + 1] = static_cast<char>(residual);
    }
    if (best_cost < 0 || cost < best_cost) {
      best_cost = cost;
      best = line;
    }
  }
  return best;
}

}  // namespace

std::string encode_png(const Image& image, double pixels_per_mm) {
  std::string raw;
  const int bytes = 3 * image.width;
  for (int y = 0; y < image.height; ++y) {
    const unsigned char* row = image.rgb.data() + static_cast<std::ptrdiff_t>(y) * bytes;
    raw += filtered_row(row, y > 0 ? row - bytes : nullptr, bytes);
  }
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(raw.data()),
                static_cast<uLong>(raw.size()), 7) != Z_OK)
    throw std::runtime_error("zlib could not compress a picture");
  packed.resize(size);

  std::string header, density;
  put32(header, static_cast<std::uint32_t>(image.width));
  put32(header, static_cast<std::uint32_t>(image.height));
  header += std::string("\x08\x02\x00\x00\x00", 5);  // 8 bits, RGB, deflate, adaptive filters, not interlaced
  const auto per_metre = static_cast<std::uint32_t>(std::lround(1000 * pixels_per_mm));
  put32(density, per_metre);
  put32(density, per_metre);
  density += '\x01';

  std::string out = "\x89PNG\r\n\x1a\n";
  put_chunk(out, "IHDR", header);
  put_chunk(out, "pHYs", density);
  put_chunk(out, "IDAT", packed);
  put_chunk(out, "IEND", "");
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t block = 0;
    for (std::size_t k = 0; k < 3; ++k)
      block = block << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? digits[block >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace mv
