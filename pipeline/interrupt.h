// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace mv {

/// From here on Ctrl-C and SIGTERM end the program with exit code 130, whatever it computes: programs it runs are told to end, its unfinished directories are removed.
/// To be called before main starts a thread.
void catch_interrupts();

/// While one lives an interrupt waits (for 10 s at most): around writes that belong together.
class Uninterrupted {
 public:
  Uninterrupted();
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;
};

/// A directory for unfinished files: removed with the object, or by an interrupt.
class UnfinishedDirectory {
 public:
  /// Makes it. Throws IoError.
  explicit UnfinishedDirectory(const std::filesystem::path& path);
  ~UnfinishedDirectory();
  UnfinishedDirectory(const UnfinishedDirectory&) = delete;
  UnfinishedDirectory& operator=(const UnfinishedDirectory&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Like create_directories. Throws IoError that names a file in the way.
void make_directory(const std::filesystem::path& directory);

}  // namespace mv
