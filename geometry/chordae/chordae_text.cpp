// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "geometry/chordae/network_builder.h"
#include "geometry/core/case_files.h"
#include "geometry/core/config.h"
#include "geometry/core/csv_table.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

constexpr const char* csv_header = "x0,y0,z0,x1,y1,z1 and optional radius, diameter, area, rest_length, kind, from, to";

std::string trimmed(const std::string& text) {
  const auto a = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF"), b = text.find_last_not_of(" \t\r\n");
  return a == std::string::npos ? "" : text.substr(a, b - a + 1);
}

double number(const std::string& text, const std::string& where) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    throw InputError(where + ": '" + text + "' is not a finite number");
  return value;
}

/// "x0_mm" -> "x0", with the factor to mm (or mm2) of its unit; 0 when it carries none.
std::string split_unit(const std::string& column, double& to_mm, const std::string& where) {
  to_mm = 0;
  for (const char* plain : {"rest_length", "x0", "y0", "z0", "x1", "y1", "z1", "radius", "diameter", "area", "kind", "from", "to"}) {
    const std::string name = plain;
    if (column == name) return name;
    if (column.size() <= name.size() + 1 || column.compare(0, name.size() + 1, name + "_") != 0) continue;
    const std::string unit = column.substr(name.size() + 1);
    const Dimension dimension = name == "area" ? Dimension::area : Dimension::length;
    for (const std::string& known : units_of(dimension))
      if (unit == known) {
        to_mm = unit_factor(unit) / unit_factor(name == "area" ? "mm2" : "mm");
        return name;
      }
    std::string known;
    for (const std::string& u : units_of(dimension)) known += (known.empty() ? "" : ", ") + u;
    throw InputError(where + ": column '" + column + "' has the unknown unit '" + unit + "'; expected one of " + known);
  }
  return "";
}

struct CsvColumns {
  std::map<std::string, std::size_t> index;
  std::map<std::string, double> to_mm;
  bool has_own_unit = false;  // one that differs from the file's

  bool has(const std::string& name) const { return index.count(name) > 0; }
};

CsvColumns read_header(const CsvTable& table, double unit_in_mm) {
  CsvColumns columns;
  for (std::size_t c = 0; c < table.columns().size(); ++c) {
    double to_mm = 0;
    const std::string name = split_unit(table.columns()[c], to_mm, table.file() + ": line 1");
    if (name.empty()) continue;
    columns.index[name] = table.column(table.columns()[c]);
    columns.to_mm[name] = to_mm;
    columns.has_own_unit = columns.has_own_unit || (to_mm > 0 && name != "area" && to_mm != unit_in_mm);
  }
  for (const char* needed : {"x0", "y0", "z0", "x1", "y1", "z1"})
    if (!columns.has(needed)) throw InputError(fmt::format("{}: line 1: column '{}' (or '{}_mm') is missing; expected {}", table.file(), needed, needed, csv_header));
  for (const char* read : {"area", "radius", "diameter", "rest_length", "kind"})
    if (columns.has(read)) table.expect_in_every_row(columns.index.at(read));
  return columns;
}

}  // namespace

RawChordae read_chordae_csv(const std::filesystem::path& file, const ChordaeFileOptions& options) {
  NetworkBuilder network(file, options);
  const CsvTable table(file, csv_header);
  const CsvColumns columns = read_header(table, network.scale());
  if (columns.has_own_unit && options.unit != "mm") network.note("the columns name their own unit; chordae.file_unit = \"" + options.unit + "\" is not used for them");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string where = table.line(row), place = table.where(row);
    const auto text = [&](const std::string& name) -> const std::string& { return table.text(row, columns.index.at(name)); };
    const auto is_given = [&](const std::string& name) { return columns.has(name) && !text(name).empty(); };
    const auto factor = [&](const std::string& name) {  // from the column to the file's unit, which the builder turns into mm
      const double own = columns.to_mm.at(name);
      return own > 0 ? own / (name == "area" ? network.scale() * network.scale() : network.scale()) : 1.0;
    };
    const auto value = [&](const std::string& name) { return table.number(row, columns.index.at(name)) * factor(name); };
    const int a = network.point({value("x0"), value("y0"), value("z0")}, where), b = network.point({value("x1"), value("y1"), value("z1")}, where);
    NetworkBuilder::Segment values;
    if (is_given("area"))
      values.area = value("area");
    else if (is_given("radius"))
      values.area = area_of_radius(value("radius"));
    else if (is_given("diameter"))
      values.area = area_of_radius(0.5 * value("diameter"));
    if (is_given("rest_length")) values.rest_length = value("rest_length");
    if (is_given("kind")) values.kind = static_cast<int>(chorda_kind_from_name(text("kind"), place));
    for (const auto& [column, p] : {std::pair("from", a), std::pair("to", b)}) {
      if (!columns.has(column)) continue;
      const std::string& role = text(column);
      if (role == "root")
        network.mark_root(p);
      else if (role == "leaflet")
        network.mark_leaflet_end(p);
      else if (!role.empty() && role != "branch")
        throw InputError(place + ": " + column + " is '" + role + "', expected root, branch, leaflet or nothing");
    }
    network.segment(a, b, values, where);
  }
  return network.take();
}

RawChordae read_chordae_swc(const std::filesystem::path& file, const ChordaeFileOptions& options) {
  struct Sample {
    long parent;
    Vec3 x;
    double radius;
    int line;
  };
  NetworkBuilder network(file, options);
  std::istringstream in(read_file(file));
  std::map<long, Sample> samples;
  std::string line;
  for (int row = 1; std::getline(in, line); ++row) {
    const std::string text = trimmed(line.substr(0, line.find('#')));
    if (text.empty()) continue;
    std::istringstream words(text);
    std::vector<std::string> word;
    for (std::string w; words >> w;) word.push_back(w);
    const std::string place = file.string() + ": line " + std::to_string(row);
    if (word.size() != 7)
      throw InputError(place + " has " + std::to_string(word.size()) + " values, expected 7: id type x y z radius parent");
    const auto whole = [&](std::size_t k) {
      const double v = number(word[k], place);
      if (v != std::floor(v) || std::abs(v) > 1e9) throw InputError(place + ": '" + word[k] + "' is not a whole number");
      return static_cast<long>(v);
    };
    const Sample sample{whole(6), {number(word[2], place), number(word[3], place), number(word[4], place)}, number(word[5], place), row};
    if (!samples.emplace(whole(0), sample).second) throw InputError(place + ": id " + word[0] + " appears twice");
  }
  // Up from every sample to its root; a walk longer than the file goes round.
  for (const auto& [id, sample] : samples) {
    long at = id;
    std::size_t steps = 0;
    while (samples.at(at).parent >= 0) {
      const long parent = samples.at(at).parent;
      if (!samples.count(parent))
        throw InputError(fmt::format("{}: line {}: parent {} of id {} does not exist; a root has parent -1", file.string(), samples.at(at).line, parent, at));
      if (++steps > samples.size())
        throw InputError(fmt::format("{}: line {}: id {} is its own ancestor (a cycle of parents); every tree needs one root with parent -1", file.string(), sample.line, id));
      at = parent;
    }
  }
  for (const auto& [id, sample] : samples) {
    const std::string where = "line " + std::to_string(sample.line);
    const int b = network.point(sample.x, where);
    if (sample.parent < 0) {
      network.mark_root(b);
      continue;
    }
    const Sample& parent = samples.at(sample.parent);
    NetworkBuilder::Segment values;
    // The radius of a sample holds for the piece that leads to it; 0 stands for not measured.
    if (sample.radius < 0) throw InputError(file.string() + ": " + where + ": the radius is negative");
    if (sample.radius > 0) values.area = area_of_radius(sample.radius);
    network.segment(network.point(parent.x, where), b, values, where);
  }
  return network.take();
}

void write_chordae_csv(const std::filesystem::path& file, const Chordae& chordae) {
  std::vector<char> is_end(chordae.points.size(), 0);
  for (const Insertion& i : chordae.insertions) is_end[static_cast<std::size_t>(i.point)] = 1;
  const auto role = [&](int p) {
    const auto k = static_cast<std::size_t>(p);
    return chordae.muscle_of_point[k] >= 0 ? "root" : is_end[k] ? "leaflet" : "branch";
  };
  std::string out = "x0_mm,y0_mm,z0_mm,x1_mm,y1_mm,z1_mm,area_mm2,rest_length_mm,kind,from,to\n";
  for (const ChordaSegment& s : chordae.segments) {
    const Vec3 &a = chordae.points[static_cast<std::size_t>(s.a)], &b = chordae.points[static_cast<std::size_t>(s.b)];
    out += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), s.area, s.rest_length,
                       chorda_kind_name(s.kind), role(s.a), role(s.b));
  }
  write_text_atomically(file, out);
}

}  // namespace mv
