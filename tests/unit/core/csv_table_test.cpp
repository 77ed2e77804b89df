// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/csv_table.h"

#include <gtest/gtest.h>

#include <fstream>

#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using mv::CsvTable;
using mv_test::TemporaryDirectory;

namespace {

CsvTable table(const TemporaryDirectory& dir, const std::string& text) {
  std::ofstream(dir / "t.csv", std::ios::binary) << text;
  return CsvTable(dir / "t.csv", "a,b");
}

/// What reading all numbers of columns a and b complains about.
std::string complaint(const std::string& text) {
  const TemporaryDirectory dir;
  try {
    const CsvTable t = table(dir, text);
    for (std::size_t row = 0; row < t.rows(); ++row) t.number(row, t.column("a")), t.number(row, t.column("b"));
  } catch (const mv::InputError& e) {
    EXPECT_NE(std::string(e.what()).find("t.csv: "), std::string::npos) << e.what();
    EXPECT_LT(std::string(e.what()).size(), 500u);
    return e.what();
  }
  return "";
}

#define EXPECT_NAMES(message, part) EXPECT_NE((message).find(part), std::string::npos) << (message)

}  // namespace

TEST(CsvTable, line_ends_separators_quotes_and_marks_of_many_programs) {
  const TemporaryDirectory dir;
  for (const char* text : {"a,b\n1,2\n3,4\n", "a,b\r\n1,2\r\n3,4", "a,b\r1,2\r3,4\r", "\xEF\xBB\xBF" "a;b\n1;2\n\n3;4\n", "a\tb\n1\t2\n3\t4\n", "\"a\",\"b\"\n\"1\",\"2\"\n3 , 4 \n", "\n a , b \n+1,2e0\n,\n3,4,\n"}) {
    const CsvTable t = table(dir, text);
    ASSERT_EQ(t.rows(), 2u) << text;
    EXPECT_EQ(t.number(0, t.column("a")), 1) << text;
    EXPECT_EQ(t.number(1, t.column("b")), 4) << text;
    EXPECT_FALSE(t.find("c"));
  }
  const CsvTable quoted = table(dir, "a,b\n\"x, y\",\n");
  EXPECT_EQ(quoted.text(0, 0), "x, y");
  EXPECT_TRUE(quoted.is_empty(0, 1));
}

TEST(CsvTable, what_nobody_reads_may_be_missing_or_there_twice) {
  for (const char* text : {"a,b,note\n1,2\n3,4,late\n", "a,b,,\n1,2\n3,4,,,\n", "a,b,c,c\n1,2,3,4\n", "a,c,b,c\n1,2,3\n"}) EXPECT_EQ(complaint(text), "") << text;
  const TemporaryDirectory dir;
  const CsvTable t = table(dir, "a,b,note\n1,2\n3,4,late\n");
  EXPECT_TRUE(t.is_empty(0, t.column("note")));
  EXPECT_EQ(t.text(1, t.column("note")), "late");
  EXPECT_EQ(complaint("a,b\n1,2,,\n"), "");
  EXPECT_NAMES(complaint("a,b\n1,2,,3\n"), "line 2: 4 values, the header has 2 columns");
}

TEST(CsvTable, a_row_that_ends_before_a_column_that_is_read_may_have_lost_a_cell_further_left) {
  const TemporaryDirectory dir;
  const CsvTable t = table(dir, "a,b,c,note\n1,2,3\n1,3\n");
  EXPECT_NO_THROW(t.expect_in_every_row(t.column("b")));
  const auto message = [&](const char* name) {
    try {
      t.expect_in_every_row(t.column(name));
    } catch (const mv::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NAMES(message("c"), "line 3: 2 values, 'c' is column 3 of the header");
  EXPECT_NAMES(message("note"), "line 2: 3 values, 'note' is column 4 of the header");
}

TEST(CsvTable, lines_are_counted_as_an_editor_does) {
  const TemporaryDirectory dir;
  const CsvTable t = table(dir, "a,b\r\n\r\n1,2\r\n3,4\r\n");
  EXPECT_EQ(t.line(0), "line 3");
  EXPECT_EQ(t.where(1), t.file() + ": line 4");
}

TEST(CsvTable, faults_name_file_line_and_column) {
  EXPECT_NAMES(complaint(""), "is empty; expected the header a,b");
  EXPECT_NAMES(complaint("\n \n,\n"), "is empty");
  EXPECT_NAMES(complaint("a,c\n1,2\n"), "column 'b' is missing (the header is 'a,c')");
  EXPECT_NAMES(complaint("a,b,a\n1,2,3\n"), "column 'a' is there twice");
  EXPECT_NAMES(complaint("a,b\n1\n"), "line 2: b: '' is not a finite number");
  EXPECT_NAMES(complaint("a,b\n1,2\n1,5,2,5\n"), "line 3: 4 values, the header has 2 columns (a,b); are these decimal commas?");
  EXPECT_NAMES(complaint("a;b\n1,5;2,5\n"), "line 2: a: '1,5' is not a finite number; numbers need decimal points");
  EXPECT_NAMES(complaint("a,b\n1,two\n"), "line 2: b: 'two' is not a finite number");
  for (const char* cell : {"nan", "inf", "-inf", "1e999", "0x10", "1 2", "--1", "+-1", "+", "", "1.5mm"}) EXPECT_NAMES(complaint(std::string("a,b\n1,") + cell + "\n"), "is not a finite number");
  EXPECT_NAMES(complaint(std::string("a\0,\0b\0\n\0", 8)), "no text (UTF-16, or a binary file?)");
  EXPECT_NAMES(complaint("a,b\n1," + std::string(5000, '9') + "x\n"), "999...'");
  EXPECT_NAMES(complaint(std::string(5000, 'a') + "\n1\n"), "aaa...'");
}

TEST(CsvTable, what_is_no_file_is_an_io_error) {
  const TemporaryDirectory dir;
  EXPECT_THROW(CsvTable(dir / "none.csv", "a"), mv::IoError);
  try {
    CsvTable(dir.path(), "a,b");
    FAIL();
  } catch (const mv::IoError& e) {
    EXPECT_NAMES(std::string(e.what()), "is a directory; expected a CSV file");
  }
}
