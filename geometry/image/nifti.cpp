// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/image/nifti.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include "geometry/core/errors.h"

namespace mv {
namespace {

/// Voxels of the largest image that is read: 2 GB of labels.
constexpr std::int64_t voxel_limit = std::int64_t{1} << 29;
/// What deflate can reach at best.
constexpr double compression_limit = 1032;
constexpr std::size_t piece_bytes = 1 << 20;

[[noreturn]] void fail(const std::string& name, const std::string& what) { throw InputError(name + ": " + what); }

/// A file that may be compressed; zlib passes uncompressed ones through.
class Stream {
 public:
  explicit Stream(const std::filesystem::path& file) : name_(file.string()) {
    std::error_code failure;
    if (!std::filesystem::exists(file, failure)) throw IoError(name_ + " does not exist");
    if (!std::filesystem::is_regular_file(file, failure)) throw IoError(name_ + " is not a file");
    bytes_on_disk_ = static_cast<double>(std::filesystem::file_size(file, failure));
    if (!failure) file_.reset(gzopen(file.c_str(), "rb"));
    if (!file_) throw IoError("cannot open " + name_);
    gzbuffer(file_.get(), piece_bytes);
  }

  /// Up to n bytes; fewer only at the end of the file.
  std::size_t read(unsigned char* target, std::size_t n) {
    std::size_t done = 0;
    while (done < n) {
      const int got = gzread(file_.get(), target + done, static_cast<unsigned>(std::min(n - done, piece_bytes)));
      if (got < 0) fail_compressed();
      if (got == 0) break;
      done += static_cast<std::size_t>(got);
    }
    if (done < n) {
      int code = Z_OK;
      gzerror(file_.get(), &code);
      if (code != Z_OK && code != Z_STREAM_END) fail_compressed();
    }
    return done;
  }

  bool is_compressed() { return gzdirect(file_.get()) == 0; }
  double bytes_on_disk() const { return bytes_on_disk_; }
  const std::string& name() const { return name_; }

 private:
  [[noreturn]] void fail_compressed() {
    int code = Z_OK;
    const std::string message = gzerror(file_.get(), &code);
    if (code == Z_ERRNO) throw IoError("cannot read " + name_ + ": " + std::strerror(errno));
    fail(name_, code == Z_BUF_ERROR ? "the compressed file is cut off before its end; copy or download it again"
                                    : "the compressed data are damaged (" + message + "); copy or download the file again");
  }

  struct Close {
    void operator()(gzFile f) const { gzclose(f); }
  };
  std::string name_;
  double bytes_on_disk_ = 0;
  std::unique_ptr<std::remove_pointer_t<gzFile>, Close> file_;
};

struct Scaling {
  double slope = 1, inter = 0;
  bool is_used = false;
};

/// scl_slope of 0 or NaN means "none" (NaN is what nibabel writes).
Scaling scaling_of(const NiftiHeader& h, const std::string& name) {
  if (h.slope == 0 || std::isnan(h.slope)) return {};
  const double inter = std::isnan(h.inter) ? 0 : h.inter;
  if (!std::isfinite(h.slope) || !std::isfinite(inter)) fail(name, fmt::format("scl_slope = {}, scl_inter = {}: expected finite numbers", h.slope, h.inter));
  return {h.slope, inter, h.slope != 1 || inter != 0};
}

std::string place_of(std::size_t voxel, const std::array<int, 3>& size) {
  const auto nx = static_cast<std::size_t>(size[0]), ny = static_cast<std::size_t>(size[1]);
  return fmt::format("voxel ({}, {}, {})", voxel % nx, voxel / nx % ny, voxel / nx / ny);
}

struct Conversion {
  bool is_swapped;
  Scaling scaling;
  const std::array<int, 3>& size;
  const std::string& name;
};

template <class T>
void convert(const unsigned char* raw, std::size_t n, std::size_t first, const Conversion& how, std::int32_t* out) {
  for (std::size_t v = 0; v < n; ++v) {
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, raw + v * sizeof(T), sizeof(T));
    if (how.is_swapped) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    double x = static_cast<double>(value);
    if (how.scaling.is_used) x = how.scaling.slope * x + how.scaling.inter;
    const double whole = std::round(x);
    if (!(std::abs(x) <= std::numeric_limits<std::int32_t>::max()))
      fail(how.name, fmt::format("{} holds {}: expected a label, a whole number of 32 bits", place_of(first + v, how.size), x));
    if (std::abs(x - whole) > 1e-4)
      fail(how.name, fmt::format("{} holds {}{}: labels are whole numbers; this looks like an intensity image or a probability map, or a label map that was "
                                 "resampled with interpolation (use nearest neighbour)",
                                 place_of(first + v, how.size), x, how.scaling.is_used ? " after scl_slope and scl_inter" : ""));
    out[v] = static_cast<std::int32_t>(whole);
  }
}

using Converter = void (*)(const unsigned char*, std::size_t, std::size_t, const Conversion&, std::int32_t*);
Converter converter_of(int datatype) {
  switch (datatype) {
    case 2: return convert<std::uint8_t>;
    case 4: return convert<std::int16_t>;
    case 8: return convert<std::int32_t>;
    case 16: return convert<float>;
    case 64: return convert<double>;
    case 256: return convert<std::int8_t>;
    case 512: return convert<std::uint16_t>;
    case 768: return convert<std::uint32_t>;
    case 1024: return convert<std::int64_t>;
    default: return convert<std::uint64_t>;
  }
}

/// Dimensions that the file can hold, or an error.
std::array<int, 3> checked_size(const NiftiHeader& h, Stream& in) {
  double voxels = 1;
  for (std::size_t a = 1; a <= 3; ++a) voxels *= static_cast<double>(h.dim[a]);
  const double bytes = voxels * nifti_type_bytes(h.datatype) + h.data_offset;
  const double most = in.is_compressed() ? in.bytes_on_disk() * compression_limit : in.bytes_on_disk();
  const std::string shape = fmt::format("{} x {} x {} voxels of {}", h.dim[1], h.dim[2], h.dim[3], nifti_type_name(h.datatype));
  if (bytes > most)
    fail(in.name(), fmt::format("the header promises {} ({:.3g} MB), but the file of {:.3g} MB holds {} {:.3g} MB: it is cut off, or the header is damaged", shape,
                                bytes / 1e6, in.bytes_on_disk() / 1e6, in.is_compressed() ? "at most" : "only", most / 1e6));
  if (voxels > static_cast<double>(voxel_limit))
    fail(in.name(), fmt::format("{}: more than {} million voxels; crop the image to the valve", shape, voxel_limit / 1000000));
  return {static_cast<int>(h.dim[1]), static_cast<int>(h.dim[2]), static_cast<int>(h.dim[3])};
}

/// Bytes between what has been read of the header and the data.
void skip_to_data(const NiftiHeader& h, std::size_t read_already, std::vector<unsigned char>& rest, Stream& in) {
  const double least = h.version == 1 ? 348 : 540;
  // some writers leave 0: the data then start at the usual place, after four bytes of extension flags
  const double offset = h.data_offset == 0 ? least + 4 : h.data_offset;
  if (!(offset >= least && offset < 1e9 && offset == std::floor(offset)))
    fail(in.name(), fmt::format("damaged header: vox_offset = {}, expected a whole number of at least {}", h.data_offset, least));
  const auto start = static_cast<std::size_t>(offset);
  if (start <= read_already) {
    rest.erase(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(start));
    return;
  }
  rest.clear();
  std::vector<unsigned char> skipped(std::min(start - read_already, piece_bytes));
  for (std::size_t left = start - read_already; left > 0;) {
    const std::size_t got = in.read(skipped.data(), std::min(left, skipped.size()));
    if (got == 0) fail(in.name(), "ends before its data begin: the file is cut off");
    left -= got;
  }
}

/// Takes what it needs of `rest`, the bytes read together with the header.
void read_values(const NiftiHeader& h, std::vector<unsigned char>& rest, Stream& in, LabelImage& image) {
  const std::size_t width = static_cast<std::size_t>(nifti_type_bytes(h.datatype));
  const std::size_t voxels = static_cast<std::size_t>(image.size[0]) * static_cast<std::size_t>(image.size[1]) * static_cast<std::size_t>(image.size[2]);
  const Converter converter = converter_of(h.datatype);
  const Conversion how{h.is_swapped, scaling_of(h, in.name()), image.size, in.name()};
  image.values.resize(voxels);
  std::vector<unsigned char> buffer(piece_bytes / 8 * 8);
  for (std::size_t done = 0; done < voxels;) {
    const std::size_t wanted = std::min(buffer.size(), (voxels - done) * width);
    const std::size_t from_rest = std::min(wanted, rest.size());
    std::copy_n(rest.begin(), from_rest, buffer.begin());
    rest.erase(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(from_rest));
    const std::size_t got = from_rest + in.read(buffer.data() + from_rest, wanted - from_rest);
    if (got < wanted)
      fail(in.name(), fmt::format("ends after {} of {} voxels: the file is cut off, or its header promises more than it holds", done + got / width, voxels));
    converter(buffer.data(), wanted / width, done, how, image.values.data() + done);
    done += wanted / width;
  }
}

/// Reads to the end, so that zlib checks the sum at the end of a compressed file. Returns the bytes found.
std::size_t read_to_end(Stream& in, std::size_t limit) {
  std::vector<unsigned char> buffer(piece_bytes);
  std::size_t bytes = 0;
  while (bytes <= limit) {
    const std::size_t got = in.read(buffer.data(), buffer.size());
    if (got == 0) break;
    bytes += got;
  }
  return bytes;
}

}  // namespace

NiftiLabels read_nifti_labels(const std::filesystem::path& file, const NiftiOptions& options) {
  Stream in(file);
  std::vector<unsigned char> start(nifti_header_bytes_2);
  start.resize(in.read(start.data(), start.size()));
  const std::size_t read_already = start.size();
  const NiftiHeader header = parse_nifti_header(start, in.name());
  NiftiLabels labels;
  labels.image.size = checked_size(header, in);
  const auto transform = nifti_transform(header, options, in.name(), labels.notes);
  labels.image.axes = transform.leftCols<3>();
  labels.image.origin = transform.col(3);
  skip_to_data(header, read_already, start, in);
  read_values(header, start, in, labels.image);
  if (const std::size_t extra = start.size() + read_to_end(in, 1 << 26); extra > 0)
    labels.notes.push_back(fmt::format("{} bytes follow the data and are ignored; check the header's dimensions", extra));
  return labels;
}

}  // namespace mv
