// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "geometry/core/errors.h"
#include "geometry/surface/surface_formats.h"

namespace mv {
namespace {

struct Property {
  std::string name, type, count_type;  // count_type: of a list
};
struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

const std::map<std::string, std::pair<int, char>> types = {  // bytes; i signed, u unsigned, f real
    {"char", {1, 'i'}},  {"int8", {1, 'i'}},  {"uchar", {1, 'u'}},  {"uint8", {1, 'u'}},   {"short", {2, 'i'}},  {"int16", {2, 'i'}},
    {"ushort", {2, 'u'}}, {"uint16", {2, 'u'}}, {"int", {4, 'i'}},    {"int32", {4, 'i'}},   {"uint", {4, 'u'}},   {"uint32", {4, 'u'}},
    {"float", {4, 'f'}}, {"float32", {4, 'f'}}, {"double", {8, 'f'}}, {"float64", {8, 'f'}}};

/// Numbers of the body one after the other.
class Body {
 public:
  Body(const std::string& file, std::string_view data, const std::string& format) : file_(file), data_(data), format_(format) {}

  double next(const std::string& type) {
    if (format_ == "ascii") return next_word();
    const auto [bytes, kind] = types.at(type);
    if (data_.size() - place_ < static_cast<std::size_t>(bytes)) truncated();
    std::array<char, 8> raw{};
    std::memcpy(raw.data(), data_.data() + place_, static_cast<std::size_t>(bytes));
    place_ += static_cast<std::size_t>(bytes);
    const bool is_big = format_ == "binary_big_endian";
    if (is_big == (std::endian::native == std::endian::little)) std::reverse(raw.begin(), raw.begin() + bytes);
    const auto as = [&](auto value) {
      std::memcpy(&value, raw.data(), sizeof value);
      return static_cast<double>(value);
    };
    if (kind == 'f') return bytes == 4 ? as(float{}) : as(double{});
    if (kind == 'i') return bytes == 1 ? as(std::int8_t{}) : bytes == 2 ? as(std::int16_t{}) : as(std::int32_t{});
    return bytes == 1 ? as(std::uint8_t{}) : bytes == 2 ? as(std::uint16_t{}) : as(std::uint32_t{});
  }
  std::size_t left() const { return data_.size() - place_; }
  [[noreturn]] void truncated() const {
    throw InputError(fmt::format("surface: {}: truncated: the body ends after {} bytes; copy or export it again", file_, data_.size()));
  }

 private:
  double next_word() {
    while (place_ < data_.size() && std::isspace(static_cast<unsigned char>(data_[place_]))) ++place_;
    if (place_ == data_.size()) truncated();
    std::size_t end = place_;
    while (end < data_.size() && !std::isspace(static_cast<unsigned char>(data_[end]))) ++end;
    double value = 0;
    const char* first = data_.data() + place_ + (data_[place_] == '+');
    const auto [stop, error] = std::from_chars(first, data_.data() + end, value);
    if (error != std::errc() || stop != data_.data() + end)
      throw InputError(fmt::format("surface: {}: '{}' in the body is no number", file_, data_.substr(place_, std::min<std::size_t>(end - place_, 40))));
    place_ = end;
    return value;
  }
  std::string file_;
  std::string_view data_;
  std::string format_;
  std::size_t place_ = 0;
};

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < line.size();) {
    while (i < line.size() && std::isspace(static_cast<unsigned char>(line[i]))) ++i;
    std::size_t end = i;
    while (end < line.size() && !std::isspace(static_cast<unsigned char>(line[end]))) ++end;
    if (end > i) words.emplace_back(line.substr(i, end - i));
    i = end;
  }
  return words;
}

}  // namespace

RawSurface parse_ply(const std::string& file, std::string_view text) {
  const auto fail = [&](const std::string& why) { throw InputError("surface: " + file + ": " + why); };
  std::string format;
  std::vector<Element> elements;
  std::size_t place = 0;
  bool is_first = true, has_end = false;
  while (place < text.size() && !has_end) {
    const std::size_t end = text.find('\n', place);
    const auto words = words_of(text.substr(place, end == std::string_view::npos ? end : end - place));
    place = end == std::string_view::npos ? text.size() : end + 1;
    if (is_first) {
      if (words.empty() || words[0] != "ply") fail("does not begin with 'ply'");
      is_first = false;
    } else if (words.empty() || words[0] == "comment" || words[0] == "obj_info") {
      continue;
    } else if (words[0] == "format" && words.size() >= 2) {
      format = words[1];
      if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian") fail("unknown format '" + format + "'");
    } else if (words[0] == "element" && words.size() == 3) {
      long count = -1;
      const auto [stop, error] = std::from_chars(words[2].data(), words[2].data() + words[2].size(), count);
      if (error != std::errc() || stop != words[2].data() + words[2].size() || count < 0) fail("element " + words[1] + " with the count '" + words[2] + "'");
      elements.push_back({words[1], count, {}});
    } else if (words[0] == "property" && !elements.empty() && words.size() >= 3) {
      Property p;
      if (words[1] == "list") {
        if (words.size() != 5) fail("a list property needs two types and a name");
        p = {words[4], words[3], words[2]};
        if (!types.count(p.count_type)) fail("unknown type '" + p.count_type + "'");
      } else {
        p = {words[2], words[1], ""};
      }
      if (!types.count(p.type)) fail("unknown type '" + p.type + "'");
      elements.back().properties.push_back(p);
    } else if (words[0] == "end_header") {
      has_end = true;
    } else {
      fail("header line '" + words[0].substr(0, 40) + " ...' is not understood");
    }
  }
  if (!has_end || format.empty()) fail("its header is incomplete; copy or export it again");

  static const std::set<std::string> label_names = {"region", "label", "labels", "leaflet", "material", "material_index", "group"};
  RawSurface s;
  Body body(file, text.substr(place), format);
  std::map<long, int> groups;
  long polygons = 0;
  for (const Element& element : elements) {
    // Each element takes at least one byte a property: a count beyond that is refused before anything is reserved.
    if (element.count > 0 && !element.properties.empty() && static_cast<std::size_t>(element.count) > body.left())
      fail(fmt::format("its header tells {} elements '{}', but only {} bytes follow", element.count, element.name, body.left()));
    const auto has = [&](const char* name) {
      return std::any_of(element.properties.begin(), element.properties.end(), [&](const Property& p) { return p.name == name; });
    };
    if (element.name == "vertex" && !(has("x") && has("y") && has("z"))) fail("its vertices have no x, y, z");
    const bool is_faces = element.name == "face";
    for (long i = 0; i < element.count; ++i) {
      Vec3 p = Vec3::Zero();
      std::vector<int> corners;
      long label = 0;
      bool has_label = false;
      for (const Property& property : element.properties) {
        if (property.count_type.empty()) {
          const double value = body.next(property.type);
          if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z') p[property.name[0] - 'x'] = value;
          if (label_names.count(property.name) && std::isfinite(value) && std::abs(value) < 1e9) label = std::lround(value), has_label = true;
          continue;
        }
        const double length = body.next(property.count_type);
        if (!(length >= 0 && length <= static_cast<double>(body.left()))) fail(fmt::format("{} {} has a list of length {}", element.name, i, length));
        for (long k = 0; k < static_cast<long>(length); ++k) {
          const double value = body.next(property.type);
          if (!is_faces || property.name.rfind("vertex_ind", 0) != 0) continue;
          if (!(value >= 0 && value < static_cast<double>(s.points.size()) && value == std::floor(value)))
            fail(fmt::format("face {} refers to point {} of {}", i, value, s.points.size()));
          corners.push_back(static_cast<int>(value));
        }
      }
      if (element.name == "vertex") s.points.push_back(p);
      if (!is_faces) continue;
      if (corners.size() < 3) fail(fmt::format("face {} has {} corners, expected at least 3", i, corners.size()));
      polygons += corners.size() > 3;
      const int group = has_label ? groups.try_emplace(label, static_cast<int>(groups.size())).first->second : -1;
      if (has_label && group == static_cast<int>(s.group_names.size())) s.group_names.push_back(std::to_string(label));
      if (i == 0)
        for (std::size_t v = 0; v < s.points.size(); ++v)
          if (!s.points[v].allFinite()) fail(fmt::format("point {} is not finite", v));
      add_polygon(s, corners, group);
    }
  }
  if (polygons > 0) s.notes.push_back(fmt::format("{}: {} polygons cut into triangles", file, polygons));
  return s;
}

}  // namespace mv
