// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"
#include "geometry/image/slice.h"

namespace mv {
namespace {

/// "a2" before "a10".
bool is_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      std::size_t m = i, n = j;
      while (m < a.size() && digit(a[m])) ++m;
      while (n < b.size() && digit(b[n])) ++n;
      std::string x = a.substr(i, m - i), y = b.substr(j, n - j);
      x.erase(0, std::min(x.find_first_not_of('0'), x.size())), y.erase(0, std::min(y.find_first_not_of('0'), y.size()));
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
      i = m, j = n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

Vec3 to_ras(const Vec3& x, bool is_lps) { return is_lps ? Vec3(-x.x(), -x.y(), x.z()) : x; }

/// Place of one picture: directions and spacing from the table or the keys.
struct Place {
  std::string file;
  std::optional<Vec3> position, row, column;
  std::optional<std::array<double, 2>> spacing;
};

std::vector<Place> read_table(const std::filesystem::path& file) {
  const CsvTable table(file, "file,x_mm,y_mm,z_mm and optionally row_x,row_y,row_z,column_x,column_y,column_z,spacing_x_mm,spacing_y_mm");
  for (const char* name : {"file", "x_mm", "y_mm", "z_mm"}) table.column(name);
  std::vector<Place> places;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto vector = [&](const char* x, const char* y, const char* z) -> std::optional<Vec3> {
      const auto i = table.find(x), j = table.find(y), k = table.find(z);
      if (!i || !j || !k) return std::nullopt;
      return Vec3(table.number(row, *i), table.number(row, *j), table.number(row, *k));
    };
    Place place{table.text(row, table.column("file")), vector("x_mm", "y_mm", "z_mm"), vector("row_x", "row_y", "row_z"), vector("column_x", "column_y", "column_z"), {}};
    if (const auto x = table.find("spacing_x_mm"), y = table.find("spacing_y_mm"); x && y) place.spacing = {table.number(row, *x), table.number(row, *y)};
    places.push_back(place);
  }
  if (places.empty()) throw InputError(file.string() + ": no slices below the header");
  return places;
}

std::vector<std::string> pictures_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failure)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
    if (extension == ".png") names.push_back(entry.path().filename().string());
  }
  if (failure) throw IoError("cannot read the folder " + folder.string() + ": " + failure.message());
  if (names.empty()) throw IoError("the folder " + folder.string() + " holds no PNG files; expected one per slice");
  std::sort(names.begin(), names.end(), is_before);
  return names;
}

GreySlice read_picture(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) throw InputError(file.string() + ": named in slices.csv, but not there");
  cv::Mat picture;
  try {
    picture = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& e) {
    throw InputError(fmt::format("{}: cannot be decoded as PNG ({})", file.string(), e.err));
  }
  if (picture.empty()) throw InputError(file.string() + ": cannot be decoded as PNG; truncated, or another format?");
  if (picture.depth() != CV_8U && picture.depth() != CV_16U) throw InputError(file.string() + ": expected 8 or 16 bits per channel");
  GreySlice slice;
  slice.place.name = file.string();
  slice.place.width = picture.cols;
  slice.place.height = picture.rows;
  const int channels = picture.channels();
  for (int j = 0; j < picture.rows; ++j)
    for (int i = 0; i < picture.cols; ++i) {
      const auto value = [&](int c) -> int {
        return picture.depth() == CV_8U ? picture.ptr<std::uint8_t>(j)[i * channels + c] : picture.ptr<std::uint16_t>(j)[i * channels + c];
      };
      if (channels >= 3 && (value(0) != value(1) || value(0) != value(2)))
        throw InputError(fmt::format("{}: pixel ({}, {}) is coloured; expected grey values that are labels", file.string(), i, j));
      slice.values.push_back(value(0));
    }
  return slice;
}

void place_slice(Slice& slice, const Place& place, const PngPlacement& keys, std::size_t number) {
  const auto spacing = place.spacing ? place.spacing : keys.pixel_spacing;
  if (!spacing)
    throw ConfigError("key 'curves.pixel_spacing' is \"auto\", but PNG files hold no pixel size; expected two lengths such as [\"0.7 mm\", \"0.7 mm\"], or the columns "
                      "spacing_x_mm,spacing_y_mm in slices.csv");
  if (!((*spacing)[0] > 0 && (*spacing)[1] > 0)) throw InputError(slice.name + ": the pixel spacing is not positive");
  const Vec3 row = place.row.value_or(keys.row), column = place.column.value_or(keys.column);
  if (!(row.norm() > 0.5 && column.norm() > 0.5) || std::abs(row.normalized().dot(column.normalized())) > 0.01)
    throw InputError(slice.name + ": the directions of row and column are not perpendicular vectors; expected e.g. [1, 0, 0] and [0, 1, 0]");
  Vec3 position = keys.position;
  if (place.position) {
    position = *place.position;
  } else {
    if (!keys.slice_spacing)
      throw ConfigError("key 'curves.slice_spacing' is \"auto\", but PNG files hold no distance between slices; expected a length such as \"3 mm\", or a table slices.csv "
                        "beside the pictures");
    position += row.normalized().cross(column.normalized()) * *keys.slice_spacing * static_cast<double>(number);
  }
  slice.origin = to_ras(position, keys.is_lps);
  slice.step_x = to_ras(row.normalized() * (*spacing)[0], keys.is_lps);
  slice.step_y = to_ras(column.normalized() * (*spacing)[1], keys.is_lps);
}

}  // namespace

std::vector<GreySlice> read_png_slices(const std::filesystem::path& folder, const PngPlacement& placement) {
  std::vector<Place> places;
  if (std::filesystem::exists(folder / "slices.csv")) {
    places = read_table(folder / "slices.csv");
  } else {
    for (const std::string& name : pictures_of(folder)) places.push_back({name, {}, {}, {}, {}});
  }
  std::vector<GreySlice> slices;
  std::set<std::string> seen;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (!seen.insert(places[k].file).second) throw InputError(fmt::format("{}: {} is named twice", (folder / "slices.csv").string(), places[k].file));
    slices.push_back(read_picture(folder / places[k].file));
    Slice& place = slices.back().place;
    const Slice& first = slices.front().place;
    if (place.width != first.width || place.height != first.height)
      throw InputError(fmt::format("{}: {} x {} pixels, but {} has {} x {}; expected slices of one stack", place.name, place.width, place.height, first.name, first.width, first.height));
    place_slice(place, places[k], placement, k);
  }
  return slices;
}

}  // namespace mv
