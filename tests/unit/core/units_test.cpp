// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numbers>

#include "geometry/core/config.h"
#include "geometry/core/errors.h"

namespace {
using mv::Dimension;
double si(const char* text, Dimension d) { return mv::parse_quantity(text, d, "test"); }
}  // namespace

TEST(Units, every_unit_has_its_factor) {
  EXPECT_DOUBLE_EQ(si("1.5 mm", Dimension::length), 1.5e-3);
  EXPECT_DOUBLE_EQ(si("1.5 cm", Dimension::length), 1.5e-2);
  EXPECT_DOUBLE_EQ(si("1.5 m", Dimension::length), 1.5);
  EXPECT_DOUBLE_EQ(si("1.5 um", Dimension::length), 1.5e-6);
  EXPECT_DOUBLE_EQ(si("2 mm2", Dimension::area), 2e-6);
  EXPECT_DOUBLE_EQ(si("2 cm2", Dimension::area), 2e-4);
  EXPECT_DOUBLE_EQ(si("2 m2", Dimension::area), 2);
  EXPECT_DOUBLE_EQ(si("3 ml", Dimension::volume), 3e-6);
  EXPECT_DOUBLE_EQ(si("3 mm3", Dimension::volume), 3e-9);
  EXPECT_DOUBLE_EQ(si("2 s", Dimension::time), 2);
  EXPECT_DOUBLE_EQ(si("2 ms", Dimension::time), 2e-3);
  EXPECT_DOUBLE_EQ(si("2 us", Dimension::time), 2e-6);
  EXPECT_DOUBLE_EQ(si("7 Pa", Dimension::pressure), 7);
  EXPECT_DOUBLE_EQ(si("7 kPa", Dimension::pressure), 7e3);
  EXPECT_DOUBLE_EQ(si("7 MPa", Dimension::pressure), 7e6);
  EXPECT_DOUBLE_EQ(si("760 mmHg", Dimension::pressure), 760 * 133.322387415);
  EXPECT_NEAR(si("760 mmHg", Dimension::pressure), 101325, 0.02);  // one atmosphere
  EXPECT_DOUBLE_EQ(si("1060 kg/m3", Dimension::density), 1060);
  EXPECT_DOUBLE_EQ(si("1.06 g/cm3", Dimension::density), 1060);
  EXPECT_DOUBLE_EQ(si("2 mPa s", Dimension::viscosity), 2e-3);
  EXPECT_DOUBLE_EQ(si("2 Pa s", Dimension::viscosity), 2);
  EXPECT_DOUBLE_EQ(si("-4 N", Dimension::force), -4);
  EXPECT_DOUBLE_EQ(si("3 m/s", Dimension::velocity), 3);
  EXPECT_DOUBLE_EQ(si("90 deg", Dimension::angle), std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(si("1 rad", Dimension::angle), 1);
  EXPECT_DOUBLE_EQ(si("1 N/m", Dimension::stiffness), 1);
  EXPECT_DOUBLE_EQ(si("5 ml/s", Dimension::flow), 5e-6);
}

TEST(Units, spacing_and_exponents_are_free) {
  EXPECT_DOUBLE_EQ(si("  1e3mm ", Dimension::length), 1);
  EXPECT_DOUBLE_EQ(si("+2 mm", Dimension::length), 2e-3);
  EXPECT_DOUBLE_EQ(si("2.5e-1  mPa s", Dimension::viscosity), 2.5e-4);
}

TEST(Units, wrong_quantities_are_refused_with_what_is_expected) {
  for (const char* text :
       {"", "mm", "1.0", "1.0 kg", "1.0 Pa", "1.0 mm mm", "nan mm", "inf mm", "1,5 mm", "0x10 mm", "1.0 MM", "+-1 mm"}) {
    try {
      si(text, Dimension::length);
      ADD_FAILURE() << "accepted: " << text;
    } catch (const mv::ConfigError& e) {
      EXPECT_NE(std::string(e.what()).find("mm, cm, m, um"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(mv::unit_factor("furlong"), mv::ConfigError);
}

TEST(Units, a_unit_of_another_dimension_is_named) {
  try {
    si("1 mmHg", Dimension::length);
    FAIL();
  } catch (const mv::ConfigError& e) {
    EXPECT_NE(std::string(e.what()).find("unit of pressure"), std::string::npos) << e.what();
  }
}
