// SPDX-License-Identifier: GPL-3.0-or-later
// `mvprep generic` on annulus and papillary files damaged as files get damaged: each ends with its exit code, the file and the reason, or in a source with a warning.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <random>
#include <regex>
#include <sstream>

#include "geometry/core/case_files.h"
#include "unit/core/sample_case.h"

using mv::Vec3;
using mv_test::TemporaryDirectory;

namespace {

using Points = std::vector<Vec3>;

Points annulus() {
  Points points;
  for (int i = 0; i < 150; ++i) {
    const double a = 2 * M_PI * i / 150;
    points.emplace_back(320 + 19 * std::cos(a), 430 + 15 * std::sin(a), 190 + 2 * std::cos(2 * a));
  }
  return points;
}

const Points papillary = {{308, 422, 160}, {332, 422, 160}};

std::string csv(const Points& points, double scale = 1) {
  std::ostringstream out;
  out << "x_mm,y_mm,z_mm\n";
  for (const Vec3& p : points) out << scale * p.x() << ',' << scale * p.y() << ',' << scale * p.z() << '\n';
  return out.str();
}

struct Outcome {
  int code = -1;  // 124: did not end
  std::string err;
};

Outcome generic(const std::string& annulus_text, const std::string& papillary_text, bool is_directory = false) {
  const TemporaryDirectory dir;
  if (is_directory)
    std::filesystem::create_directory(dir / "ring.csv");
  else
    std::ofstream(dir / "ring.csv", std::ios::binary) << annulus_text;
  std::ofstream(dir / "tips.csv", std::ios::binary) << papillary_text;
  std::ofstream(dir / "c.toml") << "[generic]\nannulus = \"ring.csv\"\npapillary = \"tips.csv\"\nproportional = true\n[mesh]\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n";
  const std::string command = "timeout 60 " + std::string(MV_BIN_DIR) + "/mvprep generic -c '" + (dir / "c.toml").string() + "' -o '" + (dir / "case").string() + "' > '" + (dir / "stdout").string() + "' 2> '" +
                              (dir / "stderr").string() + "'";
  const int status = std::system(command.c_str());
  Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(dir / "stderr")};
  if (outcome.code != 0) {
    EXPECT_FALSE(std::filesystem::exists(dir / "case/mid_surface.vtp"));
  }
  return outcome;
}

void expect(const Outcome& outcome, int code, const std::string& file, const std::string& part) {
  EXPECT_EQ(outcome.code, code) << part << "\n" << outcome.err;
  EXPECT_NE(outcome.err.find(part), std::string::npos) << part << "\n" << outcome.err;
  EXPECT_NE(outcome.err.find(file), std::string::npos) << file << "\n" << outcome.err;
  EXPECT_LT(outcome.err.size(), 1500u) << outcome.err;
}

std::string replaced(const std::string& text, const std::string& what, const std::string& by) { return std::regex_replace(text, std::regex(what), by); }

}  // namespace

TEST(AnnulusFiles, sound_files_of_many_programs_give_the_same_source) {
  const std::string good = csv(annulus()), tips = csv(papillary);
  for (const std::string& text : {good, replaced(good, "\n", "\r\n"), replaced(good, "\n", "\r"), replaced(good, ",", ";"), "\xEF\xBB\xBF" + good}) {
    const Outcome outcome = generic(text, tips);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err.find("warning"), std::string::npos) << outcome.err;
  }
}

TEST(AnnulusFiles, damaged_files_are_named_with_the_reason) {
  const Points good = annulus();
  const std::string text = csv(good), tips = csv(papillary);
  const auto ring = [&](const Points& points) { return generic(csv(points), tips); };
  expect(generic(csv(good, 1000), tips), 4, "ring.csv", "is no place in a body");
  expect(generic(csv(good, 30), tips), 4, "ring.csv", "micrometres instead of millimetres");
  expect(generic(csv(good, 1e-3), tips), 4, "ring.csv", "metres instead of millimetres");
  Points changed = good;
  changed.insert(changed.end(), good.begin(), good.end());
  expect(ring(changed), 4, "ring.csv", "goes round 2 times");
  changed = good;
  std::shuffle(changed.begin(), changed.end(), std::mt19937(1));
  expect(ring(changed), 4, "ring.csv", "not in order");
  changed = good;
  std::reverse(changed.begin() + 75, changed.end());
  expect(ring(changed), 4, "ring.csv", "crosses itself near");
  expect(ring({good.begin(), good.begin() + 80}), 4, "ring.csv", "a part of the annulus is missing");
  expect(ring({good.begin(), good.begin() + 2}), 4, "ring.csv", "2 points, at least 8");
  expect(ring(Points(40, good[0])), 4, "ring.csv", "only 1 distinct points");
  changed.clear();
  for (int i = 0; i < 40; ++i) changed.emplace_back(i, 2 * i, 0);
  expect(ring(changed), 4, "ring.csv", "on a line");
  changed = good;
  changed[7].x() = 5000;
  expect(ring(changed), 0, "ring.csv", "warning source: ");  // left out as a spike
  EXPECT_NE(ring(changed).err.find("1 points where the annulus turns back"), std::string::npos);
  expect(generic(replaced(text, "(\\d+)\\.(\\d+)", "$1,$2"), tips), 4, "ring.csv", "decimal commas?");
  expect(generic(replaced(replaced(text, ",", ";"), "\\.", ","), tips), 4, "ring.csv", "numbers need decimal points");
  expect(generic(text + "nan,1,2\n", tips), 4, "ring.csv", "'nan' is not a finite number");
  expect(generic(replaced(text, "x_mm", "x"), tips), 4, "ring.csv", "column 'x_mm' is missing");
  expect(generic(text + "1,2\n", tips), 4, "ring.csv", "z_mm: '' is not a finite number");
  expect(generic("", tips), 4, "ring.csv", "is empty");
  expect(generic("", tips, true), 7, "ring.csv", "is a directory; expected a file");
}

TEST(AnnulusFiles, papillary_points_that_do_not_belong_to_the_annulus_are_named) {
  const std::string text = csv(annulus());
  expect(generic(text, csv({{-308, -422, 160}, {-332, -422, 160}})), 4, "tips.csv", "another space");
  expect(generic(text, csv(papillary, 1e-3)), 4, "tips.csv", "another unit");
  expect(generic(text, csv({papillary[0], papillary[0]})), 4, "tips.csv", "2 papillary points, at one place");
  expect(generic(text, csv({papillary[0]})), 4, "tips.csv", "1 papillary points, at one place");
  expect(generic(text, "x_mm,y_mm,z_mm\n"), 4, "tips.csv", "no points");
}

namespace {

/// `mvprep run` of the generic valve with a motion file for the annulus or the papillary tips.
Outcome moved(const std::string& key, const std::string& text) {
  const TemporaryDirectory dir;
  std::ofstream(dir / "motion.csv") << text;
  std::ofstream(dir / "c.toml") << "[mesh]\nspacing = \"1.5 mm\"\n[tube]\nspacing = \"4 mm\"\n[" << key << "]\nmotion = \"motion.csv\"\n";
  const std::string command = "timeout 60 " + std::string(MV_BIN_DIR) + "/mvprep run -c '" + (dir / "c.toml").string() + "' -o '" + (dir / "case").string() + "' > '" + (dir / "stdout").string() + "' 2> '" +
                              (dir / "stderr").string() + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, mv::read_file(dir / "stderr")};
}

std::string motion(const Points& points, const std::function<Vec3(const Vec3&)>& to, double end = 0.1) {
  std::ostringstream out;
  out << "point,time_s,x_mm,y_mm,z_mm\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 &a = points[i], b = to(a);
    out << i << ",0," << a.x() << ',' << a.y() << ',' << a.z() << '\n' << i << ',' << end << ',' << b.x() << ',' << b.y() << ',' << b.z() << '\n';
  }
  return out.str();
}

}  // namespace

TEST(MotionFiles, what_cannot_be_of_this_valve_is_refused_where_the_tube_is_made) {
  Points ring;  // of the generic valve
  for (int i = 0; i < 90; ++i) ring.emplace_back(19 * std::cos(2 * M_PI * i / 90), 15 * std::sin(2 * M_PI * i / 90), 0);
  const auto smaller = [](const Vec3& p) { return Vec3(0.9 * p); };
  EXPECT_EQ(moved("annulus", motion(ring, smaller)).code, 0);
  Points changed = ring;
  for (Vec3& p : changed) p.x() += 200;
  expect(moved("annulus", motion(changed, smaller)), 4, "motion.csv", "is the file of this valve");
  changed = ring;
  for (Vec3& p : changed) p *= 1e-3;
  expect(moved("annulus", motion(changed, smaller)), 4, "motion.csv", "metres instead of millimetres");
  changed = ring;
  std::shuffle(changed.begin(), changed.end(), std::mt19937(3));
  expect(moved("annulus", motion(changed, smaller)), 4, "motion.csv", "not in order");
  expect(moved("annulus", motion({ring.begin(), ring.begin() + 3}, smaller)), 4, "motion.csv", "is the file of this valve");
  expect(moved("annulus", motion(ring, smaller, 1e-5)), 4, "motion.csv", "are the times in seconds");
  expect(moved("annulus", motion(ring, smaller, 100)), 0, "motion.csv", "are the times in seconds?");
  expect(moved("annulus", motion(ring, [](const Vec3& p) { return Vec3(2 * p); })), 0, "motion.csv", "100 % longer than at rest");
  expect(moved("annulus", motion(ring, [](const Vec3& p) { return Vec3(p + Vec3(0, 0, 70)); })), 4, "motion.csv", "a point moves by 70 mm");
  expect(moved("papillary", motion({ring[0]}, smaller)), 4, "motion.csv", "holds 1 points");
  expect(moved("papillary", motion({ring[0], ring[50]}, smaller)), 4, "motion.csv", "mm from papillary tip 0");
}
