// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/packed_file.h"

#include <zlib.h>

#include <vector>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {

std::string read_file_unpacked(const std::filesystem::path& file) {
  const std::string raw = read_file(file);
  if (raw.size() < 2 || static_cast<unsigned char>(raw[0]) != 0x1f || static_cast<unsigned char>(raw[1]) != 0x8b) return raw;
  constexpr int gzip_window = 15 + 16;
  constexpr std::size_t most = std::size_t{1} << 31;
  z_stream stream{};
  if (inflateInit2(&stream, gzip_window) != Z_OK) throw IoError(file.string() + ": zlib cannot be started");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(raw.data()));
  stream.avail_in = static_cast<uInt>(raw.size());
  std::string text;
  std::vector<char> buffer(1 << 16);
  int status = Z_OK;
  do {
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    status = inflate(&stream, Z_NO_FLUSH);
    text.append(buffer.data(), buffer.size() - stream.avail_out);
  } while (status == Z_OK && text.size() <= most);
  inflateEnd(&stream);
  if (status != Z_STREAM_END) throw InputError(file.string() + ": damaged, truncated or too large gzip file; unpack it by gunzip to see");
  return text;
}

}  // namespace mv
