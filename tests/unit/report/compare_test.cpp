// SPDX-License-Identifier: BSD-3-Clause
#include "solver/report/compare.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "support/synthetic_results.h"

namespace {

using namespace mv;

class Compare : public ::testing::Test {
 protected:
  std::filesystem::path root = std::filesystem::path(::testing::TempDir()) / ("compare_test_" + std::to_string(::getpid()));
  void SetUp() override {
    std::filesystem::remove_all(root);
    test::SyntheticOptions leaking;
    leaking.is_sealed = false;
    test::write_synthetic_results(root / "sealed", {});
    test::write_synthetic_results(root / "leaking", leaking);
  }
  void TearDown() override { std::filesystem::remove_all(root); }
};

TEST_F(Compare, puts_scalars_in_a_table_and_valves_in_a_picture) {
  const std::string table = compare_results({{root / "sealed", root / "leaking"}, root / "out", {}, {}});
  std::cout << table;
  EXPECT_NE(table.find("| quantity | sealed | leaking |"), std::string::npos);
  EXPECT_NE(table.find("| seal.sealed | true | false |"), std::string::npos);
  EXPECT_EQ(read_file(root / "out/compare.csv").substr(0, 24), "quantity,sealed,leaking\n");
  EXPECT_GT(std::filesystem::file_size(root / "out/compare.png"), 10000u);
}

TEST_F(Compare, takes_labels_and_quantities_and_refuses_unknown_ones) {
  const std::string table = compare_results({{root / "sealed", root / "leaking"}, root / "out", {"a", "b"}, {"seal.hole_area_mm2"}});
  EXPECT_NE(table.find("| quantity | a | b |"), std::string::npos);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
  EXPECT_THROW(compare_results({{root / "sealed"}, root / "out", {"a", "b"}, {}}), UsageError);
  EXPECT_THROW(compare_results({{root / "sealed"}, root / "out", {}, {"seal.sealled"}}), UsageError);
  EXPECT_THROW(compare_results({{root / "nowhere"}, root / "out", {}, {}}), IoError);
}

}  // namespace
