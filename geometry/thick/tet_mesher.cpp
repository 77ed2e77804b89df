// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/thick/tet_mesher.h"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "geometry/core/program.h"

namespace mv {
namespace {

namespace fs = std::filesystem;

constexpr double same_place = 1e-6;  // mm, of a surface point before and after

struct WorkDirectory {
  fs::path path;
  explicit WorkDirectory(const fs::path& parent) {
    std::string name = (parent / "mv_fill_XXXXXX").string();
    if (!mkdtemp(name.data())) throw IoError(name + ": cannot be made");
    path = name;
  }
  ~WorkDirectory() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  WorkDirectory(const WorkDirectory&) = delete;
  WorkDirectory& operator=(const WorkDirectory&) = delete;
};

std::size_t at(long i) { return static_cast<std::size_t>(i); }

std::string last_lines(const fs::path& log) {
  std::string text = fs::exists(log) ? read_file(log) : "";
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  const auto begin = text.size() > 300 ? text.find('\n', text.size() - 300) : std::string::npos;
  if (begin != std::string::npos) text = text.substr(begin + 1);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

void run(const std::string& name, const std::string& package, const std::vector<std::string>& arguments, const fs::path& log, double seconds) {
  const fs::path program = find_program(name);
  if (program.empty()) throw IoError(fmt::format("{}: not installed; on Debian it is in the package {}", name, package));
  const int code = run_program(program, arguments, log, seconds);
  if (code == timed_out) throw InputError(fmt::format("{}: took longer than {:.0f} s", name, seconds));
  if (code != 0) throw InputError(fmt::format("{}: ended with code {}: {}", name, code, last_lines(log)));
}

/// Numbers of a text file in order, '#' begins a comment.
class Numbers {
 public:
  Numbers(const std::string& text, const std::string& name) : in_(text), name_(name) {}
  template <class T>
  T next() {
    T value{};
    while (!(in_ >> value)) {
      if (in_.eof()) throw InputError(name_ + ": ends early");
      in_.clear();
      std::string rest;
      std::getline(in_, rest);
      if (rest.find('#') == std::string::npos) throw InputError(name_ + ": '" + rest + "' is no number");
    }
    return value;
  }

 private:
  std::istringstream in_;
  std::string name_;
};

TetFill by_tetgen(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, double volume, double seconds, const fs::path& directory) {
  const WorkDirectory work(directory);
  std::string text = fmt::format("{} 3 0 0\n", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) text += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", i, points[i].x(), points[i].y(), points[i].z());
  text += fmt::format("{} 0\n", triangles.size());
  for (const auto& t : triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  text += "0\n0\n";
  write_text_atomically(work.path / "s.smesh", text);
  run("tetgen", "tetgen", {fmt::format("-pq1.2/15YQa{:.6g}", volume), (work.path / "s.smesh").string()}, work.path / "log", seconds);
  TetFill fill;
  if (!fs::exists(work.path / "s.1.node") || !fs::exists(work.path / "s.1.ele")) throw InputError("tetgen: wrote no mesh: " + last_lines(work.path / "log"));
  Numbers nodes(read_file(work.path / "s.1.node"), "tetgen's nodes");
  const long count = nodes.next<long>();
  for (int k = 0; k < 3; ++k) nodes.next<long>();
  for (long i = 0; i < count; ++i) {
    if (nodes.next<long>() != i) throw InputError("tetgen's nodes: not counted from 0");
    const double x = nodes.next<double>(), y = nodes.next<double>(), z = nodes.next<double>();
    fill.points.emplace_back(x, y, z);
  }
  Numbers elements(read_file(work.path / "s.1.ele"), "tetgen's elements");
  const long tets = elements.next<long>();
  if (elements.next<long>() != 4) throw InputError("tetgen's elements: not of four nodes");
  elements.next<long>();
  for (long e = 0; e < tets; ++e) {
    elements.next<long>();
    std::array<int, 4> tet{};
    for (int& n : tet) n = elements.next<int>();
    fill.tets.push_back(tet);
  }
  return fill;
}

TetFill by_gmsh(const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, double volume, double seconds, const fs::path& directory) {
  const WorkDirectory work(directory);
  std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", points.size());
  for (std::size_t i = 0; i < points.size(); ++i) text += fmt::format("{} {:.17g} {:.17g} {:.17g}\n", i + 1, points[i].x(), points[i].y(), points[i].z());
  text += fmt::format("$EndNodes\n$Elements\n{}\n", triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) text += fmt::format("{} 2 2 1 1 {} {} {}\n", t + 1, triangles[t][0] + 1, triangles[t][1] + 1, triangles[t][2] + 1);
  text += "$EndElements\n";
  write_text_atomically(work.path / "s.msh", text);
  const double edge = std::cbrt(volume * 6 * std::sqrt(2.0));  // of a regular tetrahedron
  write_text_atomically(work.path / "s.geo", fmt::format("Merge \"s.msh\";\nSurface Loop(1) = {{1}};\nVolume(1) = {{1}};\nMesh.Algorithm3D = 10;\nMesh.Optimize = 1;\nMesh.OptimizeThreshold = 0.4;\n"
                                                         "Mesh.MeshSizeExtendFromBoundary = 1;\nMesh.MeshSizeMax = {:.6g};\nMesh.SaveAll = 1;\n", edge));
  run("gmsh", "gmsh", {(work.path / "s.geo").string(), "-3", "-nt", "1", "-format", "msh2", "-o", (work.path / "out.msh").string()}, work.path / "log", seconds);
  const std::string out = fs::exists(work.path / "out.msh") ? read_file(work.path / "out.msh") : "";
  const auto section = [&](const std::string& name) {
    const auto begin = out.find(name + "\n");
    if (begin == std::string::npos) throw InputError("gmsh: wrote no mesh: " + last_lines(work.path / "log"));
    return out.substr(begin + name.size() + 1, out.find("$End", begin) - begin - name.size() - 1);
  };
  Numbers nodes(section("$Nodes"), "gmsh's nodes");
  const long count = nodes.next<long>();
  std::vector<int> index;  // by gmsh's number
  TetFill fill;
  for (long i = 0; i < count; ++i) {
    const long number = nodes.next<long>();
    if (number < 1 || number > 100 * count + 100) throw InputError("gmsh's nodes: a number out of range");
    if (at(number) >= index.size()) index.resize(at(number) + 1, -1);
    const double x = nodes.next<double>(), y = nodes.next<double>(), z = nodes.next<double>();
    index[at(number)] = static_cast<int>(i);
    fill.points.emplace_back(x, y, z);
  }
  Numbers elements(section("$Elements"), "gmsh's elements");
  const long number_of_elements = elements.next<long>();
  for (long e = 0; e < number_of_elements; ++e) {
    elements.next<long>();
    const int kind = elements.next<int>(), tags = elements.next<int>();
    for (int k = 0; k < tags; ++k) elements.next<int>();
    const int corners = kind == 15 ? 1 : kind == 1 ? 2 : kind == 2 ? 3 : kind == 4 ? 4 : 0;
    if (corners == 0) throw InputError(fmt::format("gmsh's elements: of kind {}, expected tetrahedra", kind));
    std::array<int, 4> tet{};
    for (int k = 0; k < corners; ++k) {
      const long number = elements.next<long>();
      if (number < 1 || at(number) >= index.size() || index[at(number)] < 0) throw InputError("gmsh's elements: a node is missing");
      tet[at(k)] = index[at(number)];
    }
    if (corners == 4) fill.tets.push_back(tet);
  }
  return fill;
}

}  // namespace

std::string_view to_string(TetMesher mesher) { return mesher == TetMesher::tetgen ? "TetGen" : "gmsh"; }

TetFill fill_surface(TetMesher mesher, const std::vector<Vec3>& points, const std::vector<std::array<int, 3>>& triangles, double volume, double seconds, const fs::path& directory) {
  TetFill fill = mesher == TetMesher::tetgen ? by_tetgen(points, triangles, volume, seconds, directory) : by_gmsh(points, triangles, volume, seconds, directory);
  const std::string name(to_string(mesher));
  if (fill.tets.empty()) throw InputError(name + ": made no tetrahedra");
  if (fill.points.size() < points.size()) throw InputError(name + ": points of the surface are missing");
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!((fill.points[i] - points[i]).norm() < same_place)) throw InputError(fmt::format("{}: point {} of the surface was moved or renumbered", name, i));
    fill.points[i] = points[i];
  }
  for (auto& tet : fill.tets) {
    for (const int n : tet)
      if (n < 0 || at(n) >= fill.points.size()) throw InputError(name + ": a tetrahedron refers to a node that is missing");
    const Vec3 a = fill.points[at(tet[0])];
    if ((fill.points[at(tet[1])] - a).cross(fill.points[at(tet[2])] - a).dot(fill.points[at(tet[3])] - a) < 0) std::swap(tet[2], tet[3]);
  }
  // Every facet of the surface, and no other, is met by one tetrahedron.
  std::vector<std::array<int, 3>> wanted, faces, outer;
  const auto sorted = [](std::array<int, 3> t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  for (const auto& t : triangles) wanted.push_back(sorted(t));
  for (const auto& t : fill.tets)
    for (const auto& f : {std::array{t[0], t[1], t[2]}, std::array{t[0], t[1], t[3]}, std::array{t[0], t[2], t[3]}, std::array{t[1], t[2], t[3]}}) faces.push_back(sorted(f));
  std::sort(wanted.begin(), wanted.end());
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i;
    while (j < faces.size() && faces[j] == faces[i]) ++j;
    if (j - i == 1) outer.push_back(faces[i]);
    i = j;
  }
  if (outer != wanted) throw InputError(fmt::format("{}: its mesh's boundary has {} triangles, the surface {}, or they differ", name, outer.size(), wanted.size()));
  return fill;
}

}  // namespace mv
