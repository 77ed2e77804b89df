// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/reference_surface.h"

#include <fmt/format.h>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "geometry/core/errors.h"
#include "geometry/core/packed_file.h"

namespace mv {
namespace {

constexpr int vtk_triangle = 5, vtk_quad = 9;
constexpr long most_points = 50'000'000;

/// Words and numbers of the file, text or binary.
class Scanner {
 public:
  Scanner(std::string file, std::string text) : file_(std::move(file)), text_(std::move(text)) {}
  bool is_binary = false;

  std::string line() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string out = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    if (out.ends_with('\r')) out.pop_back();
    return out;
  }
  /// Empty at the end.
  std::string word() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    const std::size_t start = at_;
    while (at_ < text_.size() && !std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
    return text_.substr(start, at_ - start);
  }
  long count(const char* what) {
    const std::string w = word();
    long value = -1;
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc() || end != w.data() + w.size() || value < 0 || value > most_points) fail(fmt::format("'{}' where {} was expected", w, what));
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_ + ": " + what); }
  /// Numbers of a VTK type ("float", "double", "int", ...).
  std::vector<double> numbers(long how_many, const std::string& type, const char* what) {
    std::vector<double> out;
    out.reserve(static_cast<std::size_t>(how_many));
    if (is_binary) return binary(how_many, type, what);
    for (long i = 0; i < how_many; ++i) {
      const std::string w = word();
      double value = 0;
      const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
      if (w.empty()) fail(fmt::format("ends after {} of {} numbers of {}", i, how_many, what));
      if (error != std::errc() || end != w.data() + w.size()) fail(fmt::format("'{}' among the numbers of {}", w, what));
      out.push_back(value);
    }
    return out;
  }

 private:
  std::vector<double> binary(long how_many, const std::string& type, const char* what) {
    const std::size_t bytes = type == "double" || type == "long" || type == "vtkIdType" ? 8 : type == "float" || type == "int" || type == "unsigned_int" ? 4
                              : type == "short" || type == "unsigned_short"             ? 2
                              : type == "char" || type == "unsigned_char"               ? 1
                                                                                        : 0;
    if (bytes == 0) fail(fmt::format("type '{}' of {} is not understood", type, what));
    line();  // the rest of the keyword's line
    if (at_ + bytes * static_cast<std::size_t>(how_many) > text_.size()) fail(fmt::format("ends inside the numbers of {}", what));
    std::vector<double> out;
    for (long i = 0; i < how_many; ++i, at_ += bytes) {
      std::uint64_t bits = 0;
      for (std::size_t b = 0; b < bytes; ++b) bits = bits << 8 | static_cast<unsigned char>(text_[at_ + b]);
      if (type == "double") out.push_back(std::bit_cast<double>(bits));
      else if (type == "float") out.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
      else if (bytes == 8) out.push_back(static_cast<double>(static_cast<std::int64_t>(bits)));
      else if (type == "int") out.push_back(static_cast<std::int32_t>(bits));
      else if (type == "short") out.push_back(static_cast<std::int16_t>(bits));
      else out.push_back(static_cast<double>(bits));
    }
    return out;
  }

  std::string file_, text_;
  std::size_t at_ = 0;
};

/// Cells as lists: VTK's old form, count and indices one after the other.
std::vector<std::vector<int>> cells_of(Scanner& in, const char* what, long points) {
  const long cells = in.count("a number of cells"), size = in.count("a size");
  const std::vector<double> flat = in.numbers(size, "int", what);
  std::vector<std::vector<int>> out;
  for (std::size_t i = 0; static_cast<long>(out.size()) < cells;) {
    if (i >= flat.size()) in.fail(fmt::format("{}: the list ends after {} of {} cells", what, out.size(), cells));
    const auto corners = static_cast<std::size_t>(flat[i]);
    if (flat[i] < 0 || i + corners >= flat.size() + (corners == 0 ? 1 : 0)) in.fail(fmt::format("{}: cell {} is longer than the list", what, out.size()));
    auto& cell = out.emplace_back();
    for (std::size_t c = 1; c <= corners; ++c) {
      if (!(flat[i + c] >= 0 && flat[i + c] < static_cast<double>(points))) in.fail(fmt::format("{}: cell {} names point {}, there are {}", what, out.size() - 1, flat[i + c], points));
      cell.push_back(static_cast<int>(flat[i + c]));
    }
    i += corners + 1;
  }
  return out;
}

}  // namespace

std::vector<char> ReferenceSurface::is_on_surface() const {
  std::vector<char> on(points.size(), 0);
  for (const auto& t : triangles)
    for (const int p : t) on[static_cast<std::size_t>(p)] = 1;
  return on;
}

ReferenceSurface read_reference_surface(const std::filesystem::path& file) {
  Scanner in(file.string(), read_file_unpacked(file));
  if (!in.line().starts_with("# vtk DataFile")) in.fail("no legacy VTK file: the first line must start with '# vtk DataFile'");
  in.line();
  const std::string format = in.word();
  if (format != "ASCII" && format != "BINARY") in.fail("'" + format + "' where ASCII or BINARY was expected");
  in.is_binary = format == "BINARY";
  ReferenceSurface surface;
  std::vector<std::vector<int>> cells;
  std::optional<std::vector<double>> types;
  long entries = 0;
  bool is_point_data = false;
  for (std::string keyword = in.word(); !keyword.empty(); keyword = in.word()) {
    if (keyword == "DATASET") {
      if (const std::string kind = in.word(); kind != "POLYDATA" && kind != "UNSTRUCTURED_GRID") in.fail("DATASET " + kind + ": expected POLYDATA or UNSTRUCTURED_GRID");
    } else if (keyword == "POINTS") {
      const long n = in.count("a number of points");
      const std::string type = in.word();
      const std::vector<double> x = in.numbers(3 * n, type, "POINTS");
      for (std::size_t i = 0; i + 2 < x.size(); i += 3) {
        surface.points.emplace_back(x[i], x[i + 1], x[i + 2]);
        if (!surface.points.back().allFinite()) in.fail(fmt::format("POINTS: point {} is not finite", i / 3));
      }
    } else if (keyword == "CELLS" || keyword == "POLYGONS" || keyword == "LINES" || keyword == "VERTICES" || keyword == "TRIANGLE_STRIPS") {
      const auto read = cells_of(in, keyword.c_str(), static_cast<long>(surface.points.size()));
      if (keyword == "CELLS" || keyword == "POLYGONS") cells = read;
    } else if (keyword == "CELL_TYPES") {
      types = in.numbers(in.count("a number of cells"), "int", "CELL_TYPES");
    } else if (keyword == "POINT_DATA" || keyword == "CELL_DATA") {
      entries = in.count("a number of entries");
      is_point_data = keyword == "POINT_DATA";
      if (is_point_data && entries != static_cast<long>(surface.points.size())) in.fail(fmt::format("POINT_DATA has {} entries for {} points", entries, surface.points.size()));
    } else if (keyword == "SCALARS") {
      const std::string name = in.word(), type = in.word();
      std::string next = in.word();
      long components = 1;
      if (next != "LOOKUP_TABLE") {
        components = std::strtol(next.c_str(), nullptr, 10);
        next = in.word();
      }
      if (next != "LOOKUP_TABLE" || components < 1 || components > 9) in.fail("SCALARS " + name + ": expected a number of components and LOOKUP_TABLE");
      in.word();
      const std::vector<double> values = in.numbers(entries * components, type, name.c_str());
      if (is_point_data && components == 1) surface.point_scalars[name] = values;
    } else if (keyword == "VECTORS" || keyword == "NORMALS") {
      const std::string name = in.word(), type = in.word();
      in.numbers(3 * entries, type, name.c_str());
    } else if (keyword == "TENSORS") {
      const std::string name = in.word(), type = in.word();
      in.numbers(9 * entries, type, name.c_str());
    } else if (keyword == "FIELD") {
      in.word();
      const long arrays = in.count("a number of arrays");
      for (long a = 0; a < arrays; ++a) {
        const std::string name = in.word();
        const long components = in.count("components"), tuples = in.count("tuples");
        const std::string type = in.word();
        if (type == "string") in.fail("FIELD " + name + ": strings are not understood");
        const std::vector<double> values = in.numbers(components * tuples, type, name.c_str());
        if (is_point_data && components == 1 && tuples == entries) surface.point_scalars[name] = values;
      }
    } else if (keyword == "METADATA") {
      while (!in.line().empty()) {
      }
      while (true)
        if (in.line().empty()) break;
    } else {
      in.fail("keyword '" + keyword + "' is not understood");
    }
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& cell = cells[c];
    if (types && (c >= types->size() || ((*types)[c] != vtk_triangle && (*types)[c] != vtk_quad))) continue;
    for (std::size_t k = 2; k < cell.size(); ++k) surface.triangles.push_back({cell[0], cell[k - 1], cell[k]});
  }
  if (surface.triangles.empty()) in.fail("no triangles or quads; expected the closed leaflets as a surface");
  return surface;
}

}  // namespace mv
