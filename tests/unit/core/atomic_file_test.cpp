// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"
#include "unit/core/sample_case.h"

using namespace mv_test;

namespace {

std::size_t file_count(const std::filesystem::path& directory) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory), {}));
}

/// Runs `body` in a child in which no file may grow beyond `limit` bytes: a full disk by other means, without any rights.
int run_with_file_limit(rlim_t limit, const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit bound{limit, limit};
    setrlimit(RLIMIT_FSIZE, &bound);
    _exit(body());
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

TEST(AtomicFile, writes_and_replaces_the_whole_text) {
  const TemporaryDirectory dir;
  const std::string text("with\0zero", 9);
  mv::write_text_atomically(dir / "a", text);
  EXPECT_EQ(mv::read_file(dir / "a"), text);
  mv::write_text_atomically(dir / "a", "shorter");
  EXPECT_EQ(mv::read_file(dir / "a"), "shorter");
  EXPECT_EQ(file_count(dir.path()), 1u);
}

TEST(AtomicFile, a_failed_write_leaves_the_old_file_and_nothing_else) {
  const TemporaryDirectory dir;
  mv::write_text_atomically(dir / "a", "old");
  const int result = run_with_file_limit(4096, [&] {
    try {
      mv::write_text_atomically(dir / "a", std::string(100000, 'x'));
    } catch (const mv::IoError& e) {
      return e.code() == mv::ExitCode::io && std::string(e.what()).find("a: ") != std::string::npos ? 7 : 1;
    }
    return 0;
  });
  EXPECT_EQ(result, 7);
  EXPECT_EQ(mv::read_file(dir / "a"), "old");
  EXPECT_EQ(file_count(dir.path()), 1u);
}

TEST(AtomicFile, a_failed_case_file_leaves_nothing_behind) {
  const TemporaryDirectory dir;
  const int result = run_with_file_limit(512, [&] {
    try {
      mv::write_leaflets(dir / "leaflets.vtu", sample_leaflets(1));
    } catch (const mv::IoError&) {
      return 7;
    }
    return 0;
  });
  EXPECT_EQ(result, 7);
  EXPECT_EQ(file_count(dir.path()), 0u);
}

// A real full disk where the test may mount one; the limit above covers the rest.
TEST(AtomicFile, a_full_disk_is_named_and_leaves_nothing_behind) {
  const TemporaryDirectory dir;
  const std::string mount = "mount -t tmpfs -o size=64k tmpfs " + dir.path().string() + " 2>/dev/null";
  if (geteuid() != 0 || std::system(mount.c_str()) != 0) GTEST_SKIP() << "no right to mount a small tmpfs here";
  std::string message;
  try {
    mv::write_text_atomically(dir / "a", std::string(1 << 20, 'x'));
  } catch (const mv::IoError& e) {
    message = e.what();
  }
  const std::size_t left = file_count(dir.path());
  ASSERT_EQ(std::system(("umount " + dir.path().string()).c_str()), 0);
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
  EXPECT_EQ(left, 0u);
}

TEST(AtomicFile, missing_directories_and_files_are_io_errors) {
  const TemporaryDirectory dir;
  EXPECT_THROW(mv::write_text_atomically(dir / "no/such/a", "x"), mv::IoError);
  EXPECT_THROW(mv::read_file(dir / "none"), mv::IoError);
  EXPECT_THROW(mv::read_file(dir.path()), mv::IoError);
  std::filesystem::create_directory(dir / "directory");
  EXPECT_THROW(mv::write_text_atomically(dir / "directory", "x"), mv::IoError);
  EXPECT_EQ(file_count(dir.path()), 1u) << "the temporary file stayed behind";
}
