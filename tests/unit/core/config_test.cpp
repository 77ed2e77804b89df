// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>

#include "geometry/core/errors.h"

namespace {

using mv::Config;

std::string refusal(const std::string& toml) {
  try {
    Config::from_string(toml, "demo.toml");
  } catch (const mv::ConfigError& e) {
    EXPECT_EQ(e.code(), mv::ExitCode::config);
    return e.what();
  }
  return "accepted";
}

std::string set_refusal(const std::string& assignment) {
  Config config;
  try {
    config.set(assignment);
  } catch (const mv::ConfigError& e) {
    return e.what();
  }
  return "accepted";
}

void expect_holds(const std::string& text, const std::vector<const char*>& parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << "missing \"" << part << "\" in: " << text;
}

}  // namespace

TEST(ConfigSchema, keys_are_unique_documented_and_have_valid_defaults) {
  std::set<std::string> names;
  for (const mv::ConfigKey& key : mv::config_schema()) {
    EXPECT_TRUE(names.insert(key.name).second) << key.name;
    EXPECT_GT(key.doc.size(), 5u) << key.name;
    EXPECT_NE(key.name.find('.'), std::string::npos) << key.name;
    EXPECT_EQ(key.type == "choice", !key.choices.empty()) << key.name;
    EXPECT_EQ(key.dimension != mv::Dimension::none, !key.unit.empty()) << key.name;
  }
  EXPECT_GT(names.size(), 60u);
}

TEST(Config, defaults_are_the_design_values_in_si) {
  const Config c;
  EXPECT_DOUBLE_EQ(c.number("generic.axis_major"), 0.038);
  EXPECT_DOUBLE_EQ(c.number_in("generic.axis_major", "mm"), 38);
  EXPECT_EQ(c.integer("mesh.layers"), 2);
  EXPECT_TRUE(c.flag("fluid.enabled"));
  EXPECT_EQ(c.text("fibers.model"), "arc");
  EXPECT_DOUBLE_EQ(c.number("pressure.peak"), 120 * 133.322387415);
  EXPECT_DOUBLE_EQ(c.number("fluid.viscosity"), 2e-3);
  ASSERT_EQ(c.numbers("generic.papillary_tips_anterolateral").size(), 3u);
  EXPECT_DOUBLE_EQ(c.numbers("generic.papillary_tips_anterolateral")[2], -0.032);
  EXPECT_DOUBLE_EQ(c.numbers("leaflet.anterior.ogden_mu")[0], -481836.3);
  EXPECT_TRUE(c.is_auto("chordae.influence_radius"));
  EXPECT_TRUE(c.is_auto("generic.anterior_direction"));
  EXPECT_FALSE(c.is_auto("mesh.spacing"));
  EXPECT_FALSE(c.was_given("mesh.spacing"));
  EXPECT_THROW(c.number("chordae.influence_radius"), std::logic_error);
  EXPECT_THROW(c.number("no.such_key"), std::logic_error);
  EXPECT_THROW(c.flag("mesh.layers"), std::logic_error);
}

TEST(Config, file_values_replace_defaults) {
  const Config c = Config::from_string(
      "[mesh]\nspacing = \"0.25 mm\"\norder = 2\n[leaflet]\nbulk = \"1 MPa\"\n[leaflet.posterior]\nlaw = \"hgo\"\n[chordae]\n"
      "removed = [1, 3]\nslack = 1\ninfluence_radius = \"2 mm\"\n[generic]\nanterior_direction = [0, 1.0, 0]\n[time]\nstep_fixed "
      "= \"\"\n",
      "x");
  EXPECT_DOUBLE_EQ(c.number("mesh.spacing"), 2.5e-4);
  EXPECT_EQ(c.integer("mesh.order"), 2);
  EXPECT_DOUBLE_EQ(c.number("leaflet.bulk"), 1e6);
  EXPECT_EQ(c.text("leaflet.posterior.law"), "hgo");
  EXPECT_EQ(c.numbers("chordae.removed"), (std::vector<double>{1, 3}));
  EXPECT_DOUBLE_EQ(c.number("chordae.influence_radius"), 2e-3);
  EXPECT_EQ(c.numbers("generic.anterior_direction"), (std::vector<double>{0, 1, 0}));
  EXPECT_TRUE(c.is_auto("time.step_fixed"));
  EXPECT_TRUE(c.was_given("mesh.spacing"));
  EXPECT_FALSE(c.was_given("mesh.layers"));
}

TEST(Config, unknown_key_is_refused_with_line_and_nearest_key) {
  expect_holds(refusal("[mesh]\norder = 1\nspacin = \"1 mm\"\n"),
               {"demo.toml:3", "'mesh.spacin'", "1 mm", "did you mean 'mesh.spacing'"});
  expect_holds(refusal("[fluids]\nviscosity = \"1 mPa s\"\n"), {"demo.toml:2", "did you mean 'fluid.viscosity'"});
  expect_holds(refusal("[mesg]\n"), {"demo.toml:1", "did you mean 'mesh'"});
  expect_holds(refusal("spacing = 3\n"), {"demo.toml:1", "'spacing'", "did you mean"});
}

TEST(Config, every_kind_of_wrong_value_names_file_line_key_value_and_expectation) {
  const std::vector<std::pair<const char*, std::vector<const char*>>> cases = {
      {"[mesh]\nspacing = 1.0\n", {"demo.toml:2", "mesh.spacing", "1.0", "no unit", "length", "mm, cm, m, um"}},
      {"[mesh]\nspacing = 1\n", {"demo.toml:2", "no unit"}},
      {"[mesh]\nspacing = \"1\"\n", {"demo.toml:2", "unit is missing"}},
      {"[mesh]\nspacing = \"1 kg\"\n", {"demo.toml:2", "unknown unit 'kg'"}},
      {"[mesh]\nspacing = \"1 Pa\"\n", {"demo.toml:2", "unit of pressure"}},
      {"[mesh]\nspacing = \"100 mm\"\n", {"demo.toml:2", "out of range", "0.05 mm to 10 mm"}},
      {"[mesh]\nspacing = \"-1 mm\"\n", {"out of range"}},
      {"[mesh]\nspacing = [\"1 mm\"]\n", {"demo.toml:2", "expected a length"}},
      {"[mesh]\nspacing = true\n", {"demo.toml:2", "expected a length"}},
      {"[mesh]\nlayers = 2.0\n", {"demo.toml:2", "mesh.layers", "whole number from 1 to 8"}},
      {"[mesh]\nlayers = 99\n", {"out of range", "from 1 to 8"}},
      {"[mesh]\nlayers = \"2\"\n", {"whole number"}},
      {"[contact]\nfriction = nan\n", {"contact.friction", "not finite"}},
      {"[contact]\nfriction = -0.1\n", {"out of range"}},
      {"[contact]\nfriction = \"0.2\"\n", {"expected a number"}},
      {"[contact]\nenabled = 1\n", {"true or false"}},
      {"[fibers]\nmodel = \"ark\"\n", {"demo.toml:2", "nearest is \"arc\"", "\"arc\", \"parallel\", \"outline\""}},
      {"[fibers]\nmodel = 3\n", {"one of"}},
      {"[case]\nname = 3\n", {"a text"}},
      {"[chordae]\nremoved = [1.5]\n", {"whole numbers"}},
      {"[chordae]\nremoved = 3\n", {"list of whole numbers"}},
      {"[generic]\npapillary_tips_anterolateral = [\"1 mm\", \"2 mm\"]\n", {"2 values", "3 values"}},
      {"[generic]\npapillary_tips_anterolateral = [1, 2, 3]\n", {"no unit"}},
      {"[pressure]\ncsv_columns = [1]\n", {"texts"}},
      {"[mesh.spacing]\nx = 1\n", {"demo.toml:1", "mesh.spacing"}},
      {"[[mesh]]\nspacing = \"1 mm\"\n", {"demo.toml:1", "section"}},
      {"mesh = 3\n", {"demo.toml:1", "section"}},
      {"[mesh]\nspacing = 2020-01-01\n", {"demo.toml:2", "expected a length"}},
      {"[mesh\n", {"demo.toml:1", "not valid TOML"}},
      {"[mesh]\nspacing = \n", {"demo.toml:2", "not valid TOML"}},
      {"[mesh]\nlayers = 1\nlayers = 2\n", {"demo.toml:3", "not valid TOML"}},
      {"format_version = 99\n", {"demo.toml:1", "format_version"}},
  };
  for (const auto& [toml, parts] : cases) {
    SCOPED_TRACE(toml);
    expect_holds(refusal(toml), parts);
  }
}

TEST(Config, set_takes_values_with_and_without_quotes) {
  Config c;
  c.set("mesh.spacing=0.75 mm");
  EXPECT_DOUBLE_EQ(c.number("mesh.spacing"), 7.5e-4);
  c.set("mesh.spacing=\"0.5 cm\"");
  EXPECT_DOUBLE_EQ(c.number("mesh.spacing"), 5e-3);
  c.set("mesh.layers = 3");
  EXPECT_EQ(c.integer("mesh.layers"), 3);
  c.set("fluid.enabled=false");
  EXPECT_FALSE(c.flag("fluid.enabled"));
  c.set("fibers.model=parallel");
  EXPECT_EQ(c.text("fibers.model"), "parallel");
  c.set("contact.friction=1e-1");
  EXPECT_DOUBLE_EQ(c.number("contact.friction"), 0.1);
  c.set("generic.papillary_tips_anterolateral=[1 mm, \"2 mm\", 3 cm]");
  EXPECT_DOUBLE_EQ(c.numbers("generic.papillary_tips_anterolateral")[2], 0.03);
  c.set("pressure.csv_columns=[lv, \"la\"]");
  EXPECT_EQ(c.texts("pressure.csv_columns"), (std::vector<std::string>{"lv", "la"}));
  c.set("chordae.removed=[]");
  EXPECT_TRUE(c.numbers("chordae.removed").empty());
  c.set("case.name=a=b");
  EXPECT_EQ(c.text("case.name"), "a=b");
  c.set("time.step_fixed=10 us");
  EXPECT_DOUBLE_EQ(c.number("time.step_fixed"), 1e-5);
  c.set("time.step_fixed=auto");
  EXPECT_TRUE(c.is_auto("time.step_fixed"));
  EXPECT_TRUE(c.was_given("mesh.layers"));
}

TEST(Config, set_refuses_what_a_file_may_not_say) {
  expect_holds(set_refusal("mesh.spacin=1 mm"), {"--set", "did you mean 'mesh.spacing'"});
  expect_holds(set_refusal("mesh.spacing=1"), {"--set", "no unit"});
  expect_holds(set_refusal("mesh.layers=2.5"), {"whole number"});
  expect_holds(set_refusal("fluid.enabled=yes"), {"true or false"});
  expect_holds(set_refusal("contact.friction=0.2x"), {"number"});
  expect_holds(set_refusal("mesh.spacing"), {"key=value"});
  expect_holds(set_refusal("=1"), {"key=value"});
}

TEST(Config, written_back_and_read_again_is_identical_to_the_last_bit) {
  Config c;
  c.set("mesh.spacing=0.1234567890123 mm");
  c.set("pressure.peak=119.7 mmHg");
  c.set("gates.min_dihedral=0.2 rad");
  c.set("time.end=0.1 s");
  c.set("case.name=a \"quoted\" \\ name\twith tab");
  c.set("leaflet.anterior.ogden_mu=[0.1 Pa, 1e-7 kPa, -3 MPa]");
  for (const bool commented : {false, true}) {
    const Config again = Config::from_string(c.to_toml(commented), "again");
    EXPECT_EQ(again.to_toml(commented), c.to_toml(commented));
    for (const mv::ConfigKey& key : mv::config_schema()) {
      if (key.type == "number" && !c.is_auto(key.name)) {
        EXPECT_EQ(again.number(key.name), c.number(key.name)) << key.name;
      }
      if (key.type == "numbers") {
        EXPECT_EQ(again.numbers(key.name), c.numbers(key.name)) << key.name;
      }
      if (key.type == "string") {
        EXPECT_EQ(again.text(key.name), c.text(key.name)) << key.name;
      }
      EXPECT_TRUE(again.was_given(key.name)) << key.name << " is not written back";
    }
  }
}

TEST(Config, random_quantities_survive_writing_in_their_unit) {
  std::mt19937_64 random(12345);
  std::uniform_real_distribution<double> kilopascal(-30, 60);
  for (int i = 0; i < 500; ++i) {
    char text[64];
    std::snprintf(text, sizeof text, "pressure.peak=%.17g kPa", kilopascal(random));
    Config c;
    c.set(text);
    EXPECT_EQ(Config::from_string(c.to_toml(), "x").number("pressure.peak"), c.number("pressure.peak")) << text;
  }
}

TEST(Config, case_additions_are_accepted) {
  const Config c = Config::from_string(
      "format_version = 1\n[provenance]\nanything = [1, {x = 2}]\n[provenance.sha256]\na = \"b\"\n[mesh]\nlayers = 3\n", "x");
  EXPECT_EQ(c.integer("mesh.layers"), 3);
}

TEST(Config, fingerprint_changes_with_its_keys_only) {
  Config a, b;
  const std::vector<std::string> prefixes = {"mesh", "tube.spacing"};
  EXPECT_EQ(a.fingerprint(prefixes), b.fingerprint(prefixes));
  b.set("fluid.viscosity=3 mPa s");
  b.set("tube.margin_cells=5");
  EXPECT_EQ(a.fingerprint(prefixes), b.fingerprint(prefixes));
  b.set("tube.spacing=2 mm");
  EXPECT_NE(a.fingerprint(prefixes), b.fingerprint(prefixes));
  Config d;
  d.set("mesh.order=2");
  EXPECT_NE(a.fingerprint(prefixes), d.fingerprint(prefixes));
  d.set("mesh.order=1");
  EXPECT_EQ(a.fingerprint(prefixes), d.fingerprint(prefixes)) << "writing a default out is no change";
  Config e;
  e.set("mesh.spacing=0.05 cm");
  EXPECT_EQ(a.fingerprint(prefixes), e.fingerprint(prefixes)) << "another unit is no change";
}

TEST(Config, relative_paths_start_at_the_file) {
  const auto directory = std::filesystem::temp_directory_path() / ("mv_config_test_" + std::to_string(::getpid()));
  std::filesystem::create_directories(directory);
  std::ofstream(directory / "a.toml") << "[generic]\nannulus = \"data/x.csv\"\npapillary = \"/abs/p.csv\"\n";
  const Config c = Config::from_file(directory / "a.toml");
  EXPECT_EQ(c.path("generic.annulus"), directory / "data/x.csv");
  EXPECT_EQ(c.path("generic.papillary"), std::filesystem::path("/abs/p.csv"));
  EXPECT_TRUE(c.path("pressure.csv").empty());
  EXPECT_THROW(Config::from_file(directory / "none.toml"), mv::IoError);
  std::filesystem::remove_all(directory);
}

TEST(NearestName, has_the_smallest_edit_distance) {
  EXPECT_EQ(mv::nearest_name("kitten", {"sitting", "mitten", "kit"}), "mitten");
  EXPECT_EQ(mv::nearest_name("", {"abc", "a"}), "a");
  EXPECT_EQ(mv::nearest_name("ca", {"abc", "cab"}), "cab");
}
