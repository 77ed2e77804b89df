// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/core/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include "geometry/core/errors.h"

extern char** environ;

namespace mv {
namespace {

std::mutex list;
std::set<pid_t> running;
bool may_start = true;

/// A child that end_running_programs knows from its start until it has been waited for.
class Listed {
 public:
  Listed(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log) {
    const std::lock_guard lock(list);
    if (!may_start) throw Error(ExitCode::interrupted, program.string() + ": not started, the run was interrupted");
    child_ = start_program(program, arguments, log);
    running.insert(child_);
  }
  ~Listed() {
    const std::lock_guard lock(list);
    running.erase(child_);
  }
  Listed(const Listed&) = delete;
  Listed& operator=(const Listed&) = delete;
  pid_t child() const { return child_; }

 private:
  pid_t child_ = 0;
};

}  // namespace

void end_running_programs() {
  const std::lock_guard lock(list);
  may_start = false;
  for (const pid_t child : running) kill(child, SIGTERM);
}

std::filesystem::path find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder.empty() ? "." : folder) / name;
    if (access(file.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(file)) return file;
  }
  return {};
}

pid_t start_program(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const std::string name = program.string();
  std::vector<char*> argv{const_cast<char*>(name.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);  // signals that we block are for us alone
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int failed = posix_spawn(&child, name.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed) throw IoError(name + ": cannot be started: " + std::strerror(failed));
  return child;
}

int run_program(const std::filesystem::path& program, const std::vector<std::string>& arguments, const std::filesystem::path& log, double seconds) {
  const Listed listed(program, arguments, log);
  const pid_t child = listed.child();
  const std::string name = program.string();
  const auto start = std::chrono::steady_clock::now();
  bool is_killed = false;
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, seconds > 0 && !is_killed ? WNOHANG : 0);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) throw IoError(name + ": was lost: " + std::strerror(errno));
    if (ended != 0) continue;
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) {
      kill(child, SIGKILL);
      is_killed = true;
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  if (is_killed) return timed_out;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace mv
