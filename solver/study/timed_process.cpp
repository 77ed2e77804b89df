// SPDX-License-Identifier: BSD-3-Clause
#include "solver/study/timed_process.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <cstring>

#include "geometry/core/errors.h"
#include "geometry/core/program.h"

namespace mv {

std::filesystem::path own_program() {
  std::error_code code;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", code);
  if (code) throw IoError("/proc/self/exe: cannot be read: " + code.message());
  return self;
}

ProcessOutcome run_timed(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = start_program(program, arguments, log);
  int status = 0;
  rusage used{};
  while (wait4(child, &status, 0, &used) < 0)
    if (errno != EINTR) throw IoError(fmt::format("{}: was lost: {}", program.string(), std::strerror(errno)));
  auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  ProcessOutcome out;
  out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  out.processor_seconds = seconds(used.ru_utime) + seconds(used.ru_stime);
  out.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace mv
