// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/waveform.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "geometry/core/errors.h"

namespace {

constexpr double mmHg = 133.322387415;

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / ("mv_waveform_" + std::to_string(::getpid()) + "_" + name);
  std::ofstream(file) << text;
  return file;
}

TEST(Waveform, built_in_ones_rise_to_the_peak_and_hold) {
  for (const char* kind : {"systolic", "ramp", "smooth"}) {
    mv::Config config;
    config.set(std::string("pressure.waveform=") + kind);
    const auto w = mv::Waveform::from_config(config, ".");
    EXPECT_EQ(w.at(0), 0.0);
    EXPECT_NEAR(w.at(0.03), 60 * mmHg, 1e-6);
    EXPECT_NEAR(w.at(0.06), 120 * mmHg, 1e-6);
    EXPECT_NEAR(w.at(1.0), 120 * mmHg, 1e-6);
    EXPECT_NEAR(w.largest(), 120 * mmHg, 1e-6);
  }
}

TEST(Waveform, csv_difference_is_ventricle_minus_atrium_from_the_start_time) {
  const auto file = write("a.csv", "x,lv,la\n0.1,10,5\n0.2,110,10\n0.3,60,10\n");
  mv::Config config;
  config.set("pressure.waveform=csv");
  config.set("pressure.csv=" + file.string());
  config.set("pressure.csv_columns=[\"lv\", \"la\"]");
  config.set("pressure.csv_start=0.1 s");
  const auto w = mv::Waveform::from_config(config, ".");
  EXPECT_NEAR(w.at(0.0), 5 * mmHg, 1e-9);
  EXPECT_NEAR(w.at(0.05), 52.5 * mmHg, 1e-9);
  EXPECT_NEAR(w.at(0.1), 100 * mmHg, 1e-9);
  EXPECT_NEAR(w.at(9.0), 50 * mmHg, 1e-9);
  config.set("pressure.csv_columns=[\"lw\"]");
  try {
    mv::Waveform::from_config(config, ".");
    FAIL();
  } catch (const mv::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'lw'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("'lv'"), std::string::npos);
  }
}

TEST(Waveform, defective_tables_are_refused_by_file_line_and_column) {
  for (const char* text : {"", "t,p\n", "t,p\n0,1\n", "t,p\n0,1\n1,abc\n", "t,p\n0,1\n1,nan\n", "t,p\n0,1\n0,2\n", "t,p\n0,1\n1\n"}) {
    const auto file = write("b.csv", text);
    mv::Config config;
    config.set("pressure.waveform=csv");
    config.set("pressure.csv=" + file.string());
    EXPECT_THROW(mv::Waveform::from_config(config, "."), mv::InputError) << text;
  }
  mv::Config config;
  config.set("pressure.waveform=csv");
  EXPECT_THROW(mv::Waveform::from_config(config, "."), mv::ConfigError);
  config.set("pressure.csv=/nonexistent/file.csv");
  EXPECT_THROW(mv::Waveform::from_config(config, "."), mv::IoError);
}

}  // namespace
