// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/input_files.h"

#include <gtest/gtest.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

TEST(InputFiles, double_extensions_are_kept) {
  const TemporaryDirectory dir;
  for (const auto& [file, name] :
       std::vector<std::pair<std::string, std::string>>{{"a.b.nii.gz", "inputs/labels.file.nii.gz"},
                                                        {"curve.mrk.json", "inputs/labels.file.mrk.json"},
                                                        {"a.b.csv", "inputs/labels.file.csv"},
                                                        {"plain", "inputs/labels.file"}}) {
    mv::write_text_atomically(dir / file, "content");
    const mv::Input input = mv::read_input("labels.file", dir / file);
    EXPECT_EQ(input.name, name);
    ASSERT_EQ(input.files.size(), 1u);
    EXPECT_EQ(input.files[0].name, name);
    EXPECT_EQ(input.files[0].text, "content");
  }
}

TEST(InputFiles, a_folder_is_taken_file_by_file_in_alphabetical_order) {
  const TemporaryDirectory dir;
  std::filesystem::create_directories(dir / "slices/deeper");
  for (const char* file : {"slices/b.png", "slices/a.png", "slices/.hidden", "slices/deeper/c.png"})
    mv::write_text_atomically(dir / file, file);
  const mv::Input input = mv::read_input("curves.folder", dir / "slices");
  EXPECT_EQ(input.name, "inputs/curves.folder");
  ASSERT_EQ(input.files.size(), 2u);
  EXPECT_EQ(input.files[0].name, "inputs/curves.folder/a.png");
  EXPECT_EQ(input.files[1].name, "inputs/curves.folder/b.png");
}

TEST(InputFiles, the_hash_of_a_folder_follows_names_and_contents_of_its_files) {
  const TemporaryDirectory dir;
  std::filesystem::create_directories(dir / "a");
  std::filesystem::create_directories(dir / "b");
  mv::write_text_atomically(dir / "a/1.png", "x");
  mv::write_text_atomically(dir / "b/1.png", "x");
  EXPECT_EQ(mv::sha256_of_input(dir / "a"), mv::sha256_of_input(dir / "b"));
  std::filesystem::rename(dir / "b/1.png", dir / "b/2.png");
  EXPECT_NE(mv::sha256_of_input(dir / "a"), mv::sha256_of_input(dir / "b"));
  mv::write_text_atomically(dir / "a/1.png", "y");
  std::filesystem::rename(dir / "b/2.png", dir / "b/1.png");
  EXPECT_NE(mv::sha256_of_input(dir / "a"), mv::sha256_of_input(dir / "b"));
  EXPECT_EQ(mv::sha256_of_input(dir / "a/1.png"), mv::sha256("y"));
}

TEST(InputFiles, missing_and_empty_ones_are_refused) {
  const TemporaryDirectory dir;
  std::filesystem::create_directories(dir / "empty");
  EXPECT_THROW(mv::read_input("k", dir / "none"), mv::IoError);
  EXPECT_THROW(mv::read_input("k", dir / "empty"), mv::IoError);
  EXPECT_THROW(mv::sha256_of_input(dir / "empty"), mv::IoError);
}
