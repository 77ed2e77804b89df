// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/summary.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace fs = std::filesystem;
using namespace mv;

namespace {

TEST(SummaryTest, dots_nest_and_order_is_kept) {
  Summary s;
  s.set("seal.sealed", true);
  s.set("flow.leak_rate_ml_s", 0.25);
  s.set("seal.threshold_mm", 0.6);
  s.set("papillary.force_N", Json{1.5, 2.5});
  EXPECT_EQ(s.json().dump(),
            R"({"seal":{"sealed":true,"threshold_mm":0.6},"flow":{"leak_rate_ml_s":0.25},"papillary":{"force_N":[1.5,2.5]}})");
  EXPECT_EQ(json_at(s.json(), "seal.threshold_mm").get<double>(), 0.6);
  EXPECT_TRUE(json_at(s.json(), "seal.absent").is_null());
  EXPECT_TRUE(json_at(s.json(), "seal.sealed.deeper").is_null());
  EXPECT_THROW(s.set("seal.sealed.deeper", 1), std::logic_error);
}

TEST(SummaryTest, file_reads_back_and_what_is_not_finite_is_null) {
  const fs::path file = fs::temp_directory_path() / ("mv_summary_test_" + std::to_string(::getpid()) + ".json");
  Summary s;
  s.set("a.b", 1.0 / 3);
  s.set("a.c", std::numeric_limits<double>::infinity());
  s.write(file);
  const Json back = read_json(file);
  EXPECT_EQ(back["a"]["b"].get<double>(), 1.0 / 3);
  EXPECT_TRUE(back["a"]["c"].is_null());
  std::ofstream(file) << "{\"a\": ";
  EXPECT_THROW(read_json(file), InputError);
  fs::remove(file);
  EXPECT_THROW(read_json(file), IoError);
  EXPECT_THROW(s.write(fs::temp_directory_path() / "mv_absent_folder" / "summary.json"), IoError);
}

}  // namespace
