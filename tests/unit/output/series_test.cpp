// SPDX-License-Identifier: BSD-3-Clause
#include "solver/output/series.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace fs = std::filesystem;
using namespace mv;

namespace {

class Series : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() / ("mv_series_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(Series, numbers_read_back_exactly) {
  const std::vector<double> values{0.1, 1.0 / 3, 6.02214076e23, -2.2250738585072014e-308, 5e-324, 133.322387415, 0};
  CsvWriter csv(folder_ / "a.csv", {"time_s", "b", "c", "d", "e", "f", "g"});
  csv.append(values);
  const SeriesTable table = read_csv(folder_ / "a.csv");
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(table.numbers(table.columns[i])[0], values[i]);
}

TEST_F(Series, what_a_scene_leaves_out_is_an_empty_cell) {
  SeriesWriter series(folder_);
  SeriesRow row;
  row.time_s = 0.001;
  row.limiter = "contact";
  series.append(row);
  const SeriesTable table = read_csv(folder_ / "series.csv");
  EXPECT_EQ(table.columns, series_columns());
  EXPECT_EQ(table.texts("limiter")[0], "contact");
  EXPECT_EQ(table.texts("flow_ml_s")[0], "");
  EXPECT_TRUE(std::isnan(table.numbers("flow_ml_s")[0]));
  EXPECT_EQ(table.columns.size(), 32u);
}

TEST_F(Series, resuming_cuts_rows_after_the_checkpoint_and_continues) {
  const fs::path file = folder_ / "a.csv";
  {
    CsvWriter csv(file, {"time_s", "x"});
    for (int i = 0; i < 10; ++i) csv.append(std::vector<double>{0.1 * i, 1.0 * i});
  }
  std::string uninterrupted = read_file(file);
  std::ofstream(file, std::ios::app) << "1.0,half";  // a line that an interrupted write left
  {
    CsvWriter csv(file, {"time_s", "x"}, 0.1 * 4);
    EXPECT_EQ(read_csv(file).rows.size(), 5u);
    for (int i = 5; i < 10; ++i) csv.append(std::vector<double>{0.1 * i, 1.0 * i});
  }
  EXPECT_EQ(read_file(file), uninterrupted);
}

TEST_F(Series, resuming_without_a_file_starts_one_and_refuses_other_columns) {
  { CsvWriter csv(folder_ / "a.csv", {"time_s", "x"}, 0.5); }
  EXPECT_EQ(read_file(folder_ / "a.csv"), "time_s,x\n");
  EXPECT_THROW(CsvWriter(folder_ / "a.csv", {"time_s", "y"}, 0.5), InputError);
}

TEST_F(Series, a_full_disk_leaves_whole_rows_only) {
  const fs::path file = folder_ / "a.csv";
  CsvWriter csv(file, {"time_s", "x"});
  csv.append(std::vector<double>{0, 1});
  const std::string before = read_file(file);
  rlimit old{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = old;
  tight.rlim_cur = before.size() + 5;  // part of the next row fits
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &tight), 0);
  EXPECT_THROW(csv.append(std::vector<double>{1.0 / 3, 2.0 / 3}), IoError);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(read_file(file), before);
  csv.append(std::vector<double>{0.5, 2});
  EXPECT_EQ(read_csv(file).rows.size(), 2u);
}

TEST_F(Series, a_folder_that_is_missing_is_an_io_error) {
  EXPECT_THROW(SeriesWriter(folder_ / "absent"), IoError);
  EXPECT_THROW(read_csv(folder_ / "absent.csv"), IoError);
}

TEST_F(Series, ragged_rows_are_refused) {
  std::ofstream(folder_ / "a.csv") << "time_s,x\n1,2,3\n";
  EXPECT_THROW(read_csv(folder_ / "a.csv"), InputError);
  CsvWriter csv(folder_ / "b.csv", {"time_s", "x"});
  EXPECT_THROW(csv.append(std::vector<double>{1}), std::logic_error);
}

TEST_F(Series, chordae_columns_name_kind_leaflet_and_muscle) {
  Chordae chordae;
  chordae.points.resize(3);
  chordae.segments.push_back({0, 1, ChordaKind::primary, 0, anterior, 1, 1});
  chordae.segments.push_back({0, 2, ChordaKind::secondary, 1, posterior, 1, 1});
  EXPECT_EQ(chordae_columns(chordae),
            (std::vector<std::string>{"time_s", "primary_00_anterior_m0_N", "secondary_01_posterior_m1_N"}));
  ChordaeSeriesWriter writer(folder_, chordae);
  writer.append(0.25, std::vector<double>{0.5, 1.5});
  EXPECT_EQ(read_file(folder_ / "chordae.csv"), "time_s,primary_00_anterior_m0_N,secondary_01_posterior_m1_N\n0.25,0.5,1.5\n");
}

}  // namespace
