// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/png.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>

using namespace mv;

namespace {

std::uint32_t read32(const std::string& s, std::size_t at) {
  std::uint32_t v = 0;
  for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<unsigned char>(s[at + k]);
  return v;
}

/// A decoder of its own: checks signature, chunk lengths and CRCs, inflates, undoes the row filters.
Image decode(const std::string& png) {
  EXPECT_EQ(png.substr(0, 8), std::string("\x89PNG\r\n\x1a\n", 8));
  std::map<std::string, std::string> chunks;
  std::size_t at = 8;
  while (at < png.size()) {
    const std::size_t length = read32(png, at);
    const std::string type = png.substr(at + 4, 4);
    EXPECT_EQ(read32(png, at + 8 + length),
              crc32(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(png.data() + at + 4), static_cast<uInt>(length + 4)))
        << type;
    chunks[type] += png.substr(at + 8, length);
    at += 12 + length;
  }
  EXPECT_EQ(at, png.size());
  EXPECT_TRUE(chunks.contains("IEND"));
  const std::string& header = chunks["IHDR"];
  Image image;
  image.width = static_cast<int>(read32(header, 0));
  image.height = static_cast<int>(read32(header, 4));
  EXPECT_EQ(header.substr(8), std::string("\x08\x02\x00\x00\x00", 5));
  const int bytes = 3 * image.width;
  std::string raw(static_cast<std::size_t>((bytes + 1) * image.height), '\0');
  uLongf size = raw.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(raw.data()), &size, reinterpret_cast<const Bytef*>(chunks["IDAT"].data()),
                       chunks["IDAT"].size()),
            Z_OK);
  EXPECT_EQ(size, raw.size());
  image.rgb.resize(static_cast<std::size_t>(bytes * image.height));
  const auto pixel = [&](int y, int i) -> int { return y < 0 || i < 0 ? 0 : image.rgb[static_cast<std::size_t>(y * bytes + i)]; };
  for (int y = 0; y < image.height; ++y) {
    const int filter = raw[static_cast<std::size_t>(y * (bytes + 1))];
    for (int i = 0; i < bytes; ++i) {
      const int left = pixel(y, i - 3), up = pixel(y - 1, i), corner = i < 3 ? 0 : pixel(y - 1, i - 3);
      int predicted = 0;
      if (filter == 1) predicted = left;
      if (filter == 2) predicted = up;
      if (filter == 3) predicted = (left + up) / 2;
      if (filter == 4) {
        const int p = left + up - corner, a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
        predicted = a <= b && a <= c ? left : b <= c ? up : corner;
      }
      image.rgb[static_cast<std::size_t>(y * bytes + i)] =
          static_cast<unsigned char>(raw[static_cast<std::size_t>(y * (bytes + 1) + 1 + i)] + predicted);
    }
  }
  return image;
}

TEST(Png, every_pixel_comes_back) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 5}, {64, 40}, {3, 100}}) {
    Image image = Image::filled(width, height, Rgb(1, 1, 1));
    unsigned state = 7;
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      state = state * 1664525u + 1013904223u;
      // smooth, flat and noisy stretches, so that each filter gets its turn
      const auto band = i / 300 % 3;
      image.rgb[i] = static_cast<unsigned char>(band == 0 ? i / 5 : band == 1 ? 200 : state >> 24);
    }
    const Image back = decode(encode_png(image));
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_EQ(back.rgb, image.rgb);
  }
}

TEST(Png, a_flat_picture_packs_well) { EXPECT_LT(encode_png(Image::filled(500, 500, Rgb(1, 1, 1))).size(), 4000u); }

TEST(Base64, known_texts) {
  // RFC 4648, section 10
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe\xfd"), "//79");
}

}  // namespace
