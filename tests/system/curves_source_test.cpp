// SPDX-License-Identifier: GPL-3.0-or-later
// `mvprep curves` as a user meets it: each broken input with its exit code and message, and PNG, CSV and markups that work.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <iomanip>
#include <zlib.h>

#include "geometry/core/case_files.h"
#include "support/cone_valve.h"
#include "unit/core/sample_case.h"

using mv_test::ConeValve;
using mv_test::TemporaryDirectory;

namespace {

struct Outcome {
  int code = -1;
  std::string out, err;
};

Outcome mvprep(const std::string& arguments, const TemporaryDirectory& dir) {
  const std::string out = dir / "stdout", err = dir / "stderr";
  const int status = std::system((std::string(MV_BIN_DIR) + "/mvprep " + arguments + " >" + out + " 2>" + err).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(out), mv::read_file(err)};
}

/// Configuration with the lines of [curves]; coarse, so that the source alone is quick.
Outcome run(const TemporaryDirectory& dir, const std::string& curves, const std::string& more = "") {
  std::ofstream(dir / "c.toml") << "[source]\nkind = \"curves\"\n[mesh]\nspacing = \"1.5 mm\"\n[labels]\npreset = \"visible_human\"\n" << more << "[curves]\n" << curves;
  return mvprep("curves -c " + (dir / "c.toml").string() + " -o " + (dir / "case").string(), dir);
}

/// Grey PNG of 8 bits without compression.
void write_png(const std::filesystem::path& file, int width, int height, const std::vector<std::uint8_t>& pixels) {
  std::string png = "\x89PNG\r\n\x1a\n";
  const auto number = [](std::uint32_t x) { return std::string{static_cast<char>(x >> 24), static_cast<char>(x >> 16), static_cast<char>(x >> 8), static_cast<char>(x)}; };
  const auto chunk = [&](const std::string& type, const std::string& data) {
    const std::string body = type + data;
    png += number(static_cast<std::uint32_t>(data.size())) + body + number(static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
  };
  chunk("IHDR", number(static_cast<std::uint32_t>(width)) + number(static_cast<std::uint32_t>(height)) + std::string("\x08\x00\x00\x00\x00", 5));
  std::string rows;
  for (int j = 0; j < height; ++j) rows += '\0' + std::string(reinterpret_cast<const char*>(pixels.data()) + j * width, static_cast<std::size_t>(width));
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(size);
  chunk("IDAT", packed);
  chunk("IEND", "");
  std::ofstream(file, std::ios::binary) << png;
}

/// The cone's slices as PNG with the labels of the preset visible_human; `table`: slices.csv beside them.
void write_stack(const TemporaryDirectory& dir, bool table, const std::function<void(std::size_t, mv::Slice&)>& change = {}) {
  std::filesystem::create_directories(dir / "png");
  std::ofstream csv;
  if (table) {
    csv.open(dir / "png/slices.csv");
    csv << "file,x_mm,y_mm,z_mm,row_x,row_y,row_z,column_x,column_y,column_z,spacing_x_mm,spacing_y_mm\n";
  }
  auto slices = ConeValve{}.slices(3, 0.8);
  const std::uint8_t value[] = {0, 1, 2, 9, 3, 4, 9, 5, 6};
  for (std::size_t k = 0; k < slices.size(); ++k) {
    mv::Slice& s = slices[k];
    if (change) change(k, s);
    std::vector<std::uint8_t> pixels;
    for (const auto part : s.parts) pixels.push_back(value[part]);
    const std::string name = "s" + std::to_string(k + 1) + ".png";
    write_png(dir / ("png/" + name), s.width, s.height, pixels);
    if (table)
      csv << name << "," << s.origin.x() << "," << s.origin.y() << "," << s.origin.z() << ",0,1,0,0,0,-1," << s.step_x.norm() << "," << s.step_y.norm() << "\n";
  }
}

std::string csv_of(const mv::CurveSet& set) {
  std::ostringstream text;
  text << "leaflet,curve,x_mm,y_mm,z_mm\n" << std::setprecision(8);
  int id = 0;
  for (const auto& c : set.curves) {
    ++id;
    if (c.end != mv::CurveEnd::free_edge) continue;
    for (const auto& p : c.points) text << (c.region == mv::anterior ? "anterior" : "posterior") << "," << id << "," << p.x() << "," << p.y() << "," << p.z() << "\n";
  }
  text << "papillary_anterolateral,0,-8,-2,-28\npapillary_posteromedial,0,8,-2,-28\n";
  return text.str();
}

Outcome run_csv(const std::function<void(mv::CurveSet&)>& change, const std::string& more = "") {
  const TemporaryDirectory dir;
  mv::CurveSet set = ConeValve{}.curves(3);
  change(set);
  std::ofstream(dir / "c.csv") << csv_of(set) << more;
  return run(dir, "files = [\"c.csv\"]\n");
}

void expect(const Outcome& outcome, int code, const std::string& part) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_NE(outcome.err.find(part), std::string::npos) << "expected '" << part << "' in:\n" << outcome.err;
}

}  // namespace

TEST(CurvesSource, csv_of_a_cone_becomes_a_source) {
  const Outcome outcome = run_csv([](mv::CurveSet&) {});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("source"), std::string::npos);
}

TEST(CurvesSource, a_reversed_curve_ends_in_a_case_with_a_warning) {
  const Outcome outcome = run_csv([](mv::CurveSet& s) { std::reverse(s.curves[5].points.begin(), s.curves[5].points.end()); });
  expect(outcome, 0, "turned");
}

TEST(CurvesSource, a_folder_of_png_becomes_a_source_and_its_copy_gives_the_same) {
  const TemporaryDirectory dir;
  write_stack(dir, true);
  const Outcome outcome = run(dir, "slices = \"png\"\n");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Outcome again = mvprep("curves -c " + (dir / "case/case.toml").string() + " -o " + (dir / "again").string(), dir);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(mv::read_file(dir / "case/mid_surface.vtp"), mv::read_file(dir / "again/mid_surface.vtp"));
}

TEST(CurvesSource, nothing_named_and_missing_files) {
  const TemporaryDirectory dir;
  expect(run(dir, ""), 3, "curves.slices");
  expect(run(dir, "files = [\"none.csv\"]\n"), 7, "none.csv");
  expect(run(dir, "slices = \"nowhere\"\n"), 7, "nowhere");
  std::filesystem::create_directory(dir / "empty");
  expect(run(dir, "slices = \"empty\"\n"), 7, "empty");
}

TEST(CurvesSource, broken_curve_files) {
  expect(run_csv([](mv::CurveSet& s) { std::erase_if(s.curves, [](const auto& c) { return c.region == mv::posterior; }); }), 4, "one leaflet only");
  expect(run_csv([](mv::CurveSet& s) { std::swap(s.curves[4].points[6], s.curves[4].points[18]); }), 4, "crosses itself");
  expect(run_csv([](mv::CurveSet& s) {
           std::erase_if(s.curves, [n = 0](const auto&) mutable { return ++n > 2; });
         }), 4, "");
  expect(run_csv([](mv::CurveSet&) {}, "anterior,99,1,2,three\n"), 4, "'three' is not a finite number");
  expect(run_csv([](mv::CurveSet&) {}, "anterior,99,1,2,nan\n"), 4, "'nan' is not a finite number");
  expect(run_csv([](mv::CurveSet& s) {
           for (auto& c : s.curves)
             for (auto& p : c.points) p *= 1e-3;
         }), 4, "millimetres");
  expect(run_csv([](mv::CurveSet& s) {
           for (std::size_t i = 0; i + 1 < s.curves.size(); i += 4) std::swap(s.curves[i].region, s.curves[i + 1].region);
         }), 4, "interleave");
  std::string far;
  for (int i = 0; i < 12; ++i) far += "annulus,0," + std::to_string(15 * std::cos(i * M_PI / 6)) + "," + std::to_string(60 + 15 * std::sin(i * M_PI / 6)) + ",0\n";
  expect(run_csv([](mv::CurveSet&) {}, far), 4, "c.csv: the drawn annulus lies");
}

TEST(CurvesSource, papillary_points_of_another_space_are_refused_by_their_file) {
  const TemporaryDirectory dir;
  std::ofstream(dir / "c.csv") << csv_of(ConeValve{}.curves(3));
  const auto with_tips = [&](const std::string& rows) {
    std::ofstream(dir / "tips.csv") << "x_mm,y_mm,z_mm\n" << rows;
    return run(dir, "files = [\"c.csv\"]\n[patient]\npapillary = \"tips.csv\"\n");
  };
  EXPECT_EQ(with_tips("-8,-2,-28\n8,-2,-28\n").code, 0);
  expect(with_tips("-308,-2,-28\n-292,-2,-28\n"), 4, "tips.csv: the papillary point");
  expect(with_tips("-8,-2,-120\n8,-2,-120\n"), 0, "tips.csv: the papillary point");
  expect(with_tips("-8,-2,-28\n"), 0, "one papillary point only");
}

TEST(CurvesSource, broken_markups) {
  const TemporaryDirectory dir;
  const auto write = [&](const std::string& text) { std::ofstream(dir / "anterior.mrk.json") << text; };
  write(R"({"markups":[{"type":"ROI","coordinateSystem":"LPS","controlPoints":[]}]})");
  expect(run(dir, "files = [\"anterior.mrk.json\"]\n"), 4, "type \"ROI\"");
  write(R"({"markups":[{"type":"Curve","coordinateSystem":"IJK","controlPoints":[]}]})");
  expect(run(dir, "files = [\"anterior.mrk.json\"]\n"), 4, "coordinateSystem \"IJK\"");
  write("{\"markups\":");
  expect(run(dir, "files = [\"anterior.mrk.json\"]\n"), 4, "not valid JSON");
}

TEST(CurvesSource, broken_slices) {
  {
    const TemporaryDirectory dir;
    write_stack(dir, false);
    expect(run(dir, "slices = \"png\"\n"), 3, "curves.pixel_spacing");
    expect(run(dir, "slices = \"png\"\npixel_spacing = [\"0.8 mm\", \"0.8 mm\"]\n"), 3, "curves.slice_spacing");
    expect(run(dir, "slices = \"png/s5.png\"\n"), 3, "one picture");
  }
  {
    const TemporaryDirectory dir;
    write_stack(dir, true, [](std::size_t k, mv::Slice& s) {
      if (k == 4) s.height -= 3;
    });
    expect(run(dir, "slices = \"png\"\n"), 4, "s5.png");
  }
  {
    const TemporaryDirectory dir;
    write_stack(dir, true, [](std::size_t, mv::Slice& s) { std::fill(s.parts.begin(), s.parts.end(), std::uint8_t{0}); });
    expect(run(dir, "slices = \"png\"\n"), 4, "no pixel of a leaflet");
  }
  {
    const TemporaryDirectory dir;
    write_stack(dir, true, [](std::size_t k, mv::Slice& s) {
      if (k != 6) std::fill(s.parts.begin(), s.parts.end(), std::uint8_t{0});
    });
    expect(run(dir, "slices = \"png\"\n"), 4, "only 1 of");
  }
  {
    const TemporaryDirectory dir;
    std::vector<std::uint8_t> copied;
    write_stack(dir, true, [&](std::size_t k, mv::Slice& s) {
      if (k == 2) copied = s.parts;
      if (k > 2) s.parts = copied;
    });
    expect(run(dir, "slices = \"png\"\n"), 4, "hold the same leaflets to the last pixel");
  }
  {
    const TemporaryDirectory dir;
    std::vector<std::uint8_t> copied;
    write_stack(dir, true, [&](std::size_t k, mv::Slice& s) {
      if (k == 4) copied = s.parts;
      if (k > 4 && k < 8) s.parts = copied;
    });
    expect(run(dir, "slices = \"png\"\n"), 0, "slices 5 to 8 hold the same leaflets to the last pixel: was the stack resampled?");
  }
  {
    const TemporaryDirectory dir;
    write_stack(dir, true);
    std::ofstream(dir / "png/s3.png") << "no picture";
    expect(run(dir, "slices = \"png\"\n"), 4, "s3.png");
    std::filesystem::remove(dir / "png/s3.png");
    expect(run(dir, "slices = \"png\"\n"), 4, "s3.png");
  }
  {
    const TemporaryDirectory dir;
    write_stack(dir, true);
    std::string table = mv::read_file(dir / "png/slices.csv");
    const auto at = table.find("s4.png");
    std::ofstream(dir / "png/slices.csv") << table.substr(0, at) + "s3.png" + table.substr(at + 6);
    expect(run(dir, "slices = \"png\"\n"), 4, "named twice");
  }
}

TEST(CurvesSource, visible_human_slices_become_a_case_with_every_gate_passed) {
  const TemporaryDirectory dir;
  const Outcome outcome = mvprep("run -c " + std::string(MV_SOURCE_DIR) + "/configs/patients/visible_human_curves.toml -o " + (dir / "case").string() +
                                     " --set mesh.spacing=\"0.9 mm\" --set mesh.layers=2 --set tube.spacing=\"2 mm\"", dir);  // flat layers need longer edges
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Outcome self = mvprep("compare " + (dir / "case").string() + " " + (dir / "case").string() + " --csv " + (dir / "table.csv").string(), dir);
  ASSERT_EQ(self.code, 0) << self.err;
  const std::string table = mv::read_file(dir / "table.csv");
  EXPECT_NE(table.find(",0.0000,0.0000,0.0000,"), std::string::npos) << table;
}

TEST(CurvesSource, compare_names_what_is_no_case) {
  const TemporaryDirectory dir;
  expect(mvprep("compare " + (dir / "a").string() + " " + (dir / "b").string(), dir), 7, "no mid_surface.vtp");
  EXPECT_EQ(mvprep("compare " + (dir / "a").string(), dir).code, 2);
}
