// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/case_directory.h"

#include <gtest/gtest.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {
std::size_t entries(const std::filesystem::path& directory) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory), {}));
}
}  // namespace

TEST(CaseDirectory, the_case_is_self_contained_and_reads_back_to_the_same_values) {
  const TemporaryDirectory dir;
  std::filesystem::create_directory(dir / "source");
  mv::write_text_atomically(dir / "source/ring.csv", "x_mm,y_mm,z_mm\n");
  mv::write_text_atomically(dir / "source/a.toml", "[generic]\nannulus = \"ring.csv\"\n[mesh]\nspacing = \"0.7 mm\"\n");
  const mv::Config config = mv::Config::from_file(dir / "source/a.toml");
  std::map<std::string, std::string> inputs;
  const mv::Config resolved = mv::set_up_case(config, dir / "source/a.toml", dir / "case", inputs);
  EXPECT_EQ(inputs, (std::map<std::string, std::string>{{"inputs/generic.annulus.csv", mv::sha256("x_mm,y_mm,z_mm\n")}}));
  std::filesystem::remove_all(dir / "source");

  std::filesystem::rename(dir / "case", dir / "moved");
  const mv::Config again = mv::read_case_config(dir / "moved");
  EXPECT_EQ(again.to_toml(), resolved.to_toml());
  EXPECT_DOUBLE_EQ(again.number_in("mesh.spacing", "mm"), 0.7);
  EXPECT_EQ(mv::read_file(again.path("generic.annulus")), "x_mm,y_mm,z_mm\n");
  const std::string text = mv::read_file(dir / "moved/case.toml");
  for (const char* part : {"format_version = 1", "[provenance]", "ring.csv", "config_sha256"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
}

TEST(CaseDirectory, messages_name_the_users_files_not_the_copies) {
  const TemporaryDirectory dir;
  std::filesystem::create_directory(dir / "slices");
  mv::write_text_atomically(dir / "slices/s1.png", "1");
  mv::write_text_atomically(dir / "my ring.csv", "1");
  for (int i = 1; i <= 11; ++i) mv::write_text_atomically(dir / ("muscle" + std::to_string(i) + ".obj"), "1");
  std::string list;
  for (int i = 1; i <= 11; ++i) list += (i > 1 ? ", " : "") + std::string("\"muscle") + std::to_string(i) + ".obj\"";
  mv::write_text_atomically(dir / "a.toml", "[generic]\nannulus = \"my ring.csv\"\n[curves]\nslices = \"slices\"\n[surface]\npapillary = [" + list + "]\n");
  std::map<std::string, std::string> inputs;
  mv::set_up_case(mv::Config::from_file(dir / "a.toml"), dir / "a.toml", dir / "case", inputs);
  const std::string at = (dir / "case/inputs/").string();
  EXPECT_EQ(mv::with_sources(at + "generic.annulus.csv: line 3. Look at " + at + "surface.papillary.1.obj, " + at + "surface.papillary.11.obj", dir / "case"),
            "my ring.csv: line 3. Look at muscle1.obj, muscle11.obj");
  EXPECT_EQ(mv::with_sources(at + "curves.slices/s1.png", dir / "case"), "slices/s1.png");
  EXPECT_EQ(mv::with_sources("nothing named", dir / "case"), "nothing named");
}

TEST(CaseDirectory, set_up_again_from_its_own_case_toml_changes_no_value) {
  const TemporaryDirectory dir;
  mv::write_text_atomically(dir / "ring.csv", "1");
  mv::write_text_atomically(dir / "a.toml", "[generic]\nannulus = \"ring.csv\"\n");
  std::map<std::string, std::string> inputs, inputs_again;
  const auto first = mv::set_up_case(mv::Config::from_file(dir / "a.toml"), dir / "a.toml", dir / "case", inputs);
  const auto second = mv::set_up_case(mv::read_case_config(dir / "case"), dir / "case/case.toml", dir / "case", inputs_again);
  EXPECT_EQ(first.to_toml(), second.to_toml());
  EXPECT_EQ(inputs, inputs_again);
}

TEST(CaseDirectory, a_missing_input_is_named_with_its_key_before_anything_is_written) {
  const TemporaryDirectory dir;
  mv::write_text_atomically(dir / "a.toml", "[generic]\nannulus = \"none.csv\"\n");
  std::map<std::string, std::string> inputs;
  try {
    mv::set_up_case(mv::Config::from_file(dir / "a.toml"), dir / "a.toml", dir / "case", inputs);
    FAIL();
  } catch (const mv::IoError& e) {
    EXPECT_NE(std::string(e.what()).find("generic.annulus"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("none.csv"), std::string::npos) << e.what();
  }
  EXPECT_FALSE(std::filesystem::exists(dir / "case"));
}

TEST(CaseDirectory, no_case_is_an_io_error_that_says_how_to_make_one) {
  const TemporaryDirectory dir;
  try {
    mv::read_case_config(dir.path());
    FAIL();
  } catch (const mv::IoError& e) {
    EXPECT_NE(std::string(e.what()).find("mvprep run"), std::string::npos);
  }
}

TEST(StageDirectory, published_files_enter_the_case_and_the_rest_disappears) {
  const TemporaryDirectory dir;
  {
    mv::StageDirectory work(dir.path(), "mesh");
    mv::write_text_atomically(work.path() / "a", "1");
    mv::write_text_atomically(work.path() / "scratch", "2");
    EXPECT_EQ(work.publish({"a"}), (std::map<std::string, std::string>{{"a", mv::sha256("1")}}));
  }
  EXPECT_EQ(entries(dir.path()), 1u);
  EXPECT_EQ(mv::read_file(dir / "a"), "1");
}

TEST(StageDirectory, without_all_files_nothing_is_published) {
  const TemporaryDirectory dir;
  mv::write_text_atomically(dir / "a", "old");
  {
    mv::StageDirectory work(dir.path(), "mesh");
    mv::write_text_atomically(work.path() / "a", "new");
    EXPECT_THROW(work.publish({"a", "b"}), std::logic_error);
  }
  EXPECT_EQ(mv::read_file(dir / "a"), "old");
  EXPECT_EQ(entries(dir.path()), 1u);
}

TEST(StageDirectory, leftovers_of_a_killed_run_are_removed) {
  const TemporaryDirectory dir;
  std::filesystem::create_directory(dir / ".stage-mesh-12345");
  mv::write_text_atomically(dir / ".stage-mesh-12345/leaflets.vtu", "half");
  mv::write_text_atomically(dir / "keep", "1");
  mv::remove_leftovers(dir.path());
  EXPECT_EQ(entries(dir.path()), 1u);
}
