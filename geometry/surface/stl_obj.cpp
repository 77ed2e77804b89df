// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>

#include "geometry/core/errors.h"
#include "geometry/surface/surface_formats.h"

namespace mv {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is little-endian");

/// Words of a text, line by line.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
    ++number_;
    return true;
  }
  std::string_view word() {
    const std::size_t begin = line_.find_first_not_of(" \t\r\f\v");
    if (begin == std::string_view::npos) return line_ = {};
    line_.remove_prefix(begin);
    const std::string_view w = line_.substr(0, line_.find_first_of(" \t\r\f\v"));
    line_.remove_prefix(w.size());
    return w;
  }
  std::string_view rest_of_line() const { return line_; }
  long number() const { return number_; }

 private:
  std::string_view rest_, line_;
  long number_ = 0;
};

std::string clip(std::string_view text) { return std::string(text.substr(0, 40)); }

double real_of(const std::string& file, long line, std::string_view word) {
  double value = 0;
  if (!word.empty() && word[0] == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
    throw InputError(fmt::format("surface: {}: line {}: found '{}', expected a finite number", file, line, clip(word)));
  return value;
}

std::string lower(std::string_view word) {
  std::string out(word);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

/// STL repeats each corner: exactly equal ones become one point.
struct Weld {
  std::map<std::array<double, 3>, int> index;
  int operator()(RawSurface& s, const Vec3& p) {
    const auto [entry, added] = index.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, static_cast<int>(s.points.size()));
    if (added) s.points.push_back(p);
    return entry->second;
  }
};

RawSurface binary_stl(const std::string& file, std::string_view text) {
  std::uint32_t count = 0;
  std::memcpy(&count, text.data() + 80, 4);
  const std::size_t expected = 84 + 50 * static_cast<std::size_t>(count);
  if (text.size() < expected)
    throw InputError(fmt::format("surface: {}: truncated: its header tells {} triangles, which take {} bytes, but it has {}; copy or export it "
                                 "again", file, count, expected, text.size()));
  RawSurface s;
  Weld weld;
  for (std::uint32_t t = 0; t < count; ++t) {
    std::array<float, 9> x;
    std::memcpy(x.data(), text.data() + 84 + 50 * static_cast<std::size_t>(t) + 12, 36);
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p(x[3 * k], x[3 * k + 1], x[3 * k + 2]);
      if (!p.allFinite()) throw InputError(fmt::format("surface: {}: triangle {} has a corner that is not finite", file, t));
      triangle[k] = weld(s, p);
    }
    s.triangles.push_back(triangle);
  }
  if (text.size() > expected) s.notes.push_back(fmt::format("{}: {} bytes after the last triangle ignored", file, text.size() - expected));
  return s;
}

RawSurface ascii_stl(const std::string& file, std::string_view text) {
  RawSurface s;
  Weld weld;
  Lines lines(text);
  std::vector<int> corners;
  bool has_end = false, in_facet = false;
  int group = -1;
  while (lines.next()) {
    const std::string word = lower(lines.word());
    if (word == "solid") {
      std::string name(lines.word());
      group = static_cast<int>(s.group_names.size());
      s.group_names.push_back(name.empty() ? fmt::format("solid {}", group) : name);
      has_end = false;
    } else if (word == "facet") {
      if (in_facet) throw InputError(fmt::format("surface: {}: line {}: a facet begins inside a facet", file, lines.number()));
      in_facet = true;
    } else if (word == "vertex") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = real_of(file, lines.number(), lines.word());
      corners.push_back(weld(s, p));
    } else if (word == "endfacet") {
      if (corners.size() != 3)
        throw InputError(fmt::format("surface: {}: line {}: a facet with {} corners, expected 3", file, lines.number(), corners.size()));
      s.triangles.push_back({corners[0], corners[1], corners[2]});
      if (group >= 0) s.group.push_back(group);
      corners.clear();
      in_facet = false;
    } else if (word == "endsolid") {
      has_end = true;
    } else if (!word.empty() && word != "outer" && word != "endloop") {
      throw InputError(fmt::format("surface: {}: line {}: '{}' is no word of an STL file", file, lines.number(), clip(word)));
    }
  }
  if (in_facet || !has_end)
    throw InputError(fmt::format("surface: {}: truncated: it ends at line {} without endsolid; copy or export it again", file, lines.number()));
  if (s.group_names.size() < 2) s.group.clear(), s.group_names.clear();
  return s;
}

}  // namespace

RawSurface parse_stl(const std::string& file, std::string_view text) {
  // Binary headers may begin with "solid", too: the size decides, then what follows.
  std::uint32_t count = 0;
  if (text.size() >= 84) std::memcpy(&count, text.data() + 80, 4);
  const bool size_fits = text.size() >= 84 && text.size() == 84 + 50 * static_cast<std::size_t>(count);
  const bool has_zero = text.find('\0') != std::string_view::npos;
  if (!size_fits && !has_zero && lower(text.substr(0, 5)) == "solid") return ascii_stl(file, text);
  if (text.size() < 84)
    throw InputError(fmt::format("surface: {}: {} bytes are too few for an STL file; copy or export it again", file, text.size()));
  return binary_stl(file, text);
}

RawSurface parse_obj(const std::string& file, std::string_view text) {
  RawSurface s;
  Lines lines(text);
  std::map<std::string, int> groups;
  int group = -1;
  std::array<std::string, 3> name;  // object, group, material: the last of them that was set names a triangle
  std::map<std::string, long> ignored;
  long polygons = 0;
  std::vector<std::pair<std::vector<int>, std::pair<long, int>>> faces;
  while (lines.next()) {
    const std::string_view word = lines.word();
    if (word.empty() || word[0] == '#') continue;
    if (word == "v") {
      Vec3 p;
      for (int k = 0; k < 3; ++k) p[k] = real_of(file, lines.number(), lines.word());
      s.points.push_back(p);
    } else if (word == "f") {
      std::vector<int> corners;
      for (std::string_view w = lines.word(); !w.empty(); w = lines.word()) {
        w = w.substr(0, w.find('/'));
        long index = 0;
        const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), index);
        if (error != std::errc() || end != w.data() + w.size() || index == 0)
          throw InputError(fmt::format("surface: {}: line {}: '{}' is no point number (they count from 1)", file, lines.number(), clip(w)));
        if (index < 0) index += static_cast<long>(s.points.size()) + 1;
        if (index < 1 || index > 2'000'000'000)
          throw InputError(fmt::format("surface: {}: line {}: point {} does not exist", file, lines.number(), clip(w)));
        corners.push_back(static_cast<int>(index - 1));
      }
      if (corners.size() < 3)
        throw InputError(fmt::format("surface: {}: line {}: a face with {} corners, expected at least 3", file, lines.number(), corners.size()));
      polygons += corners.size() > 3;
      faces.push_back({std::move(corners), {lines.number(), group}});
    } else if (word == "o" || word == "g" || word == "usemtl") {
      name[word == "o" ? 0 : word == "g" ? 1 : 2] = std::string(lines.word());
      std::string full;
      for (const std::string& part : name)
        if (!part.empty() && part != "default") full += (full.empty() ? "" : "/") + part;
      group = full.empty() ? -1 : groups.try_emplace(full, static_cast<int>(groups.size())).first->second;
    } else if (word != "vn" && word != "vt" && word != "s" && word != "mtllib" && word != "l" && word != "p") {
      ++ignored[clip(word)];
    }
  }
  // A face may name points that come later.
  const bool has_groups = groups.size() > 1;
  for (const auto& [corners, where] : faces) {
    for (int v : corners)
      if (v >= static_cast<int>(s.points.size()))
        throw InputError(fmt::format("surface: {}: line {}: point {} of {} does not exist", file, where.first, v + 1, s.points.size()));
    add_polygon(s, corners, has_groups ? std::max(where.second, 0) : -1);
  }
  if (has_groups) {
    s.group_names.resize(groups.size());
    for (const auto& [key, index] : groups) s.group_names[static_cast<std::size_t>(index)] = key;
  }
  if (polygons > 0) s.notes.push_back(fmt::format("{}: {} polygons cut into triangles", file, polygons));
  for (const auto& [word, count] : ignored) s.notes.push_back(fmt::format("{}: {} lines beginning with '{}' ignored", file, count, word));
  return s;
}

}  // namespace mv
