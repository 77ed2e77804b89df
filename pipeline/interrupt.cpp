// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <mutex>
#include <set>
#include <thread>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "geometry/core/program.h"

namespace mv {
namespace {

using namespace std::chrono_literals;

constexpr auto longest_write = 10s;
constexpr int removals = 1000;

// Never destroyed: the watching thread outlives main.
std::recursive_timed_mutex& writing = *new std::recursive_timed_mutex;
std::mutex& list = *new std::mutex;
std::set<std::filesystem::path>& unfinished = *new std::set<std::filesystem::path>;

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

pthread_t watcher;

/// Threads that libraries start before main do not block the signals; one that the system delivers there goes on to the watching thread.
void forward(int signal) {
  const int error = errno;
  if (!pthread_equal(pthread_self(), watcher)) pthread_kill(watcher, signal);
  errno = error;
}

[[noreturn]] void end_program() {
  writing.try_lock_for(longest_write);  // and never given back
  list.lock();  // so that no new one begins, and a stage that fails for want of its program waits
  end_running_programs();
  // The stage goes on and may write into a directory while it is being removed.
  for (const auto& directory : unfinished)
    for (int attempt = 0; attempt < removals; ++attempt) {
      std::error_code ignored;
      std::filesystem::remove_all(directory, ignored);
      if (!std::filesystem::exists(directory, ignored)) break;
      std::this_thread::sleep_for(1ms);
    }
  spdlog::error("interrupted; finished stages are kept, run the same command to go on");
  _exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void catch_interrupts() {
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);  // inherited by every later thread
  std::thread watching([set] {
    int signal = 0;
    while (sigwait(&set, &signal) != 0) continue;
    end_program();
  });
  watcher = watching.native_handle();
  watching.detach();
  struct sigaction action {};
  action.sa_handler = forward;
  action.sa_mask = set;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

Uninterrupted::Uninterrupted() { writing.lock(); }
Uninterrupted::~Uninterrupted() { writing.unlock(); }

UnfinishedDirectory::UnfinishedDirectory(const std::filesystem::path& path) : path_(path) {
  const std::lock_guard lock(list);
  make_directory(path_);
  unfinished.insert(path_);
}

UnfinishedDirectory::~UnfinishedDirectory() {
  const std::lock_guard lock(list);
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
  unfinished.erase(path_);
}

void make_directory(const std::filesystem::path& directory) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure || !std::filesystem::is_directory(directory))
    throw IoError("cannot create the directory " + directory.string() + ": " + (failure ? failure.message() : "a file is in the way"));
}

}  // namespace mv
