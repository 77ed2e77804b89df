// SPDX-License-Identifier: BSD-3-Clause
#include "solver/time/checkpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace {

mv::Checkpoint sample() {
  mv::Checkpoint c;
  c.state.time = 0.125;
  c.state.step = 77;
  c.state.x = {1, 2, 3};
  c.state.v = {4, 5, 6};
  c.state.flow.pressure = {7, 8};
  c.state.mode_shape = {0.5, 0.25};
  c.state.stiffest_part = "tissue";
  c.state.ledger.work_pressure = 3.5;
  c.snapshot = c.state;
  c.snapshot.time = 0.1;
  c.has_snapshot = true;
  c.leak_samples = {{0.1, 1e-6}, {0.2, 2e-6}};
  c.case_hash = "abc";
  return c;
}

std::filesystem::path file() { return std::filesystem::temp_directory_path() / ("mv_checkpoint_" + std::to_string(::getpid())) / "state.bin"; }

TEST(Checkpoint, round_trip_keeps_every_bit) {
  mv::write_checkpoint(file(), sample());
  const auto c = mv::read_checkpoint(file());
  EXPECT_EQ(c.state.time, 0.125);
  EXPECT_EQ(c.state.step, 77);
  EXPECT_EQ(c.state.x, sample().state.x);
  EXPECT_EQ(c.state.stiffest_part, "tissue");
  EXPECT_EQ(c.state.ledger.work_pressure, 3.5);
  EXPECT_EQ(c.snapshot.time, 0.1);
  EXPECT_EQ(c.leak_samples, sample().leak_samples);
  EXPECT_EQ(c.case_hash, "abc");
  // The same bytes when written again.
  const std::string first = mv::read_file(file());
  mv::write_checkpoint(file(), c);
  EXPECT_EQ(mv::read_file(file()), first);
}

TEST(Checkpoint, damage_is_found) {
  mv::write_checkpoint(file(), sample());
  const std::string good = mv::read_file(file());
  std::string flipped = good;
  flipped[good.size() / 2] ^= 1;
  mv::write_text_atomically(file(), flipped);
  EXPECT_THROW(mv::read_checkpoint(file()), mv::InputError);
  mv::write_text_atomically(file(), good.substr(0, good.size() - 10));
  EXPECT_THROW(mv::read_checkpoint(file()), mv::InputError);
  mv::write_text_atomically(file(), "something else");
  EXPECT_THROW(mv::read_checkpoint(file()), mv::InputError);
  EXPECT_THROW(mv::read_checkpoint("/nonexistent/state.bin"), mv::IoError);
}

}  // namespace
