// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/interrupt.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "geometry/core/errors.h"

namespace {

constexpr int interrupted = static_cast<int>(mv::ExitCode::interrupted);

/// A process with a thread that is older than catch_interrupts; the signal goes to that thread or to the process.
[[noreturn]] void run_until(int signal, bool is_for_thread, const std::filesystem::path& directory) {
  std::thread old([] {
    while (true) pause();
  });
  mv::catch_interrupts();
  const mv::UnfinishedDirectory unfinished(directory);
  if (is_for_thread) pthread_kill(old.native_handle(), signal);
  else kill(getpid(), signal);
  std::this_thread::sleep_for(std::chrono::seconds(20));
  std::_Exit(0);
}

}  // namespace

TEST(Interrupt, removes_unfinished_files_whichever_thread_receives_it) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // with the threads that libraries start
  const auto directory = std::filesystem::temp_directory_path() / "mv_interrupt_test";
  for (const int signal : {SIGINT, SIGTERM})
    for (const bool is_for_thread : {true, false}) {
      EXPECT_EXIT(run_until(signal, is_for_thread, directory), testing::ExitedWithCode(interrupted), "");
      EXPECT_FALSE(std::filesystem::exists(directory));
    }
}
