// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/deck_settings.h"

#include <gtest/gtest.h>

#include "geometry/core/errors.h"
#include "unit/deck/small_deck.h"

namespace {

mv::Config taken(const std::string& properties) {
  const mv::deck_test::Folder folder;
  folder.write("ring.inp", mv::deck_test::RingDeck{}.text());
  return mv::deck_settings(mv::Config::from_file(folder.write(
                               "ring.toml", "[source]\nkind = \"deck\"\n[deck]\nfile = \"ring.inp\"\nuser_law = \"isotropic_exponential\"\nuser_properties = " + properties + "\n")))
      .config;
}

}  // namespace

TEST(DeckSettings, the_first_constants_of_a_law_may_be_named_alone) {
  const mv::Config first = taken("[\"iso_c0\"]"), all = taken("[\"iso_c0\", \"-\", \"iso_c1\", \"iso_c2\"]");
  EXPECT_TRUE(first.was_given("leaflet.septal.iso_c0"));
  EXPECT_FALSE(first.was_given("leaflet.septal.iso_c1"));
  EXPECT_TRUE(all.was_given("leaflet.septal.iso_c1"));
  EXPECT_THROW(taken("[\"iso_c0\", \"-\", \"iso_c1\", \"iso_c2\", \"-\"]"), mv::ConfigError);
}
