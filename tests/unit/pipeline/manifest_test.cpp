// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/manifest.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "pipeline/stage_table.h"
#include "unit/core/sample_case.h"

using mv_test::TemporaryDirectory;

namespace {

/// A manifest in which every stage has run on the given configuration and its files are in the directory.
mv::Manifest finished_manifest(const mv::Config& config, const TemporaryDirectory& dir) {
  mv::Manifest manifest;
  for (const mv::Stage& stage : mv::stage_table()) {
    mv::StageRecord record;
    record.key = mv::stage_key(stage, config, manifest);
    for (const std::string& file : stage.outputs) {
      mv::write_text_atomically(dir / file, "content of " + file + " by " + stage.name);
      record.outputs[file] = mv::sha256_of_file(dir / file);
    }
    manifest.stages[stage.name] = record;
  }
  return manifest;
}

std::vector<std::string> stale(const mv::Config& config, const mv::Manifest& manifest, const TemporaryDirectory& dir) {
  std::vector<std::string> names;
  for (const mv::Stage& stage : mv::stage_table()) {
    if (!mv::is_up_to_date(stage, config, manifest, dir.path())) names.push_back(stage.name);
  }
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST(StageTable, needs_come_before_and_names_are_unique) {
  Names seen;
  for (const mv::Stage& stage : mv::stage_table()) {
    for (const std::string& need : stage.needs)
      EXPECT_NE(std::find(seen.begin(), seen.end(), need), seen.end()) << stage.name << " needs " << need;
    EXPECT_EQ(std::find(seen.begin(), seen.end(), stage.name), seen.end());
    seen.push_back(stage.name);
  }
  EXPECT_EQ(seen, (Names{"source", "annulus", "mesh", "chordae", "fibers", "tube", "gates"}));
  EXPECT_EQ(mv::stages_after("chordae"), (Names{"fibers", "gates"})) << "fibres can follow the chordae";
  EXPECT_EQ(mv::stages_after("mesh"), (Names{"chordae", "fibers", "tube", "gates"}));
  EXPECT_TRUE(mv::stages_after("gates").empty());
  try {
    mv::find_stage("fibres");
    FAIL();
  } catch (const mv::UsageError& e) {
    EXPECT_NE(std::string(e.what()).find("'fibers'"), std::string::npos);
  }
}

TEST(StageTable, every_geometry_key_decides_some_stage) {
  for (const mv::ConfigKey& key : mv::config_schema()) {
    const std::string section = key.name.substr(0, key.name.find('.'));
    if (section != "source" && section != "generic" && section != "mesh" && section != "chordae" && section != "fibers" && section != "tube" &&
        section != "gates")
      continue;
    bool is_covered = false;
    for (const mv::Stage& stage : mv::stage_table()) {
      const std::string values = "\n" + mv::Config().fingerprint(stage.config_keys);
      is_covered = is_covered || values.find("\n" + key.name + " = ") != std::string::npos;
    }
    EXPECT_TRUE(is_covered) << key.name;
  }
}

TEST(Manifest, comes_back_as_written_and_is_deterministic) {
  const TemporaryDirectory dir;
  const mv::Config config;
  mv::Manifest manifest = finished_manifest(config, dir);
  manifest.inputs["inputs/generic.annulus.csv"] = "abc";
  mv::write_manifest(dir.path(), manifest, config);
  const std::string first = mv::read_file(dir / "manifest.json");
  const mv::Manifest again = mv::read_manifest(dir.path());
  EXPECT_EQ(again.inputs, manifest.inputs);
  ASSERT_EQ(again.stages.size(), manifest.stages.size());
  for (const auto& [name, record] : manifest.stages) {
    EXPECT_EQ(again.stages.at(name).key, record.key);
    EXPECT_EQ(again.stages.at(name).outputs, record.outputs);
  }
  mv::write_manifest(dir.path(), again, config);
  EXPECT_EQ(mv::read_file(dir / "manifest.json"), first);
}

TEST(Manifest, a_damaged_one_is_refused_and_a_missing_one_is_empty) {
  const TemporaryDirectory dir;
  EXPECT_TRUE(mv::read_manifest(dir.path()).stages.empty());
  for (const char* text :
       {"{", "[]", "{\"manifest_version\": 1}", "{\"manifest_version\": 1, \"inputs\": {}, \"stages\": {\"mesh\": 3}}"}) {
    mv::write_text_atomically(dir / "manifest.json", text);
    EXPECT_THROW(mv::read_manifest(dir.path()), mv::InputError) << text;
  }
  mv::write_text_atomically(dir / "manifest.json", "{\"manifest_version\": 0}");
  EXPECT_TRUE(mv::read_manifest(dir.path()).stages.empty());
}

TEST(Manifest, finished_stages_are_up_to_date_until_their_keys_change) {
  const TemporaryDirectory dir;
  mv::Config config;
  const mv::Manifest manifest = finished_manifest(config, dir);
  EXPECT_EQ(stale(config, manifest, dir), Names{});
  config.set("fluid.viscosity=4 mPa s");
  config.set("time.end=1 s");
  EXPECT_EQ(stale(config, manifest, dir), Names{}) << "keys of the solver are no business of mvprep";
  config.set("chordae.slack=1.1");
  EXPECT_EQ(stale(config, manifest, dir), Names{"chordae"});
  config.set("chordae.slack=1");
  config.set("fibers.model=parallel");
  EXPECT_EQ(stale(config, manifest, dir), (Names{"fibers", "gates"}));
  config.set("fibers.model=arc");
  config.set("mesh.spacing=0.6 mm");
  EXPECT_EQ(stale(config, manifest, dir), (Names{"source", "mesh"}));
}

TEST(Manifest, another_result_upstream_makes_a_stage_stale) {
  const TemporaryDirectory dir;
  const mv::Config config;
  mv::Manifest manifest = finished_manifest(config, dir);
  manifest.stages["annulus"].outputs["annulus.vtp"] = "another hash";
  EXPECT_EQ(stale(config, manifest, dir), (Names{"annulus", "chordae", "fibers", "tube", "gates"}));
}

TEST(Manifest, missing_and_edited_files_make_their_stages_stale) {
  const TemporaryDirectory dir;
  const mv::Config config;
  const mv::Manifest manifest = finished_manifest(config, dir);
  std::filesystem::remove(dir / "tube.vtu");
  EXPECT_EQ(stale(config, manifest, dir), Names{"tube"});
  mv::write_text_atomically(dir / "leaflets.vtu", "edited");
  EXPECT_EQ(stale(config, manifest, dir), (Names{"mesh", "fibers", "tube"}));
  EXPECT_EQ(mv::changed_outputs(mv::find_stage("mesh"), manifest, dir.path()), Names{"leaflets.vtu"});
  EXPECT_TRUE(mv::changed_outputs(mv::find_stage("chordae"), manifest, dir.path()).empty());
}

TEST(Manifest, the_content_of_a_named_file_counts_and_its_place_in_the_text_does_too) {
  const TemporaryDirectory dir;
  mv::write_text_atomically(dir / "a.csv", "1");
  mv::Config config;
  config.set_base_directory(dir.path());
  config.set("generic.annulus=a.csv");
  const mv::Stage& stage = mv::find_stage("source");
  const std::string key = mv::stage_key(stage, config, {});
  EXPECT_EQ(mv::stage_key(stage, config, {}), key);
  mv::write_text_atomically(dir / "a.csv", "2");
  EXPECT_NE(mv::stage_key(stage, config, {}), key);
}

TEST(Manifest, a_stage_has_no_key_before_what_it_needs_has_run) {
  EXPECT_EQ(mv::stage_key(mv::find_stage("mesh"), mv::Config(), {}), "");
  EXPECT_NE(mv::stage_key(mv::find_stage("source"), mv::Config(), {}), "");
}
