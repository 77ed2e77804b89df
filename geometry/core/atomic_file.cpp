// SPDX-License-Identifier: BSD-3-Clause
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "geometry/core/case_files.h"
#include "geometry/core/errors.h"

namespace mv {
namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& file, int reason) {
  std::string remedy;
  if (reason == ENOSPC || reason == EDQUOT) remedy = "; free some space or choose another output directory";
  if (reason == EACCES || reason == EPERM || reason == EROFS) remedy = "; check the permissions of the directory";
  throw IoError(what + " " + file.string() + ": " + std::strerror(reason) + remedy);
}

/// Closes on leaving and removes the file unless it was kept.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path) : path_(std::move(path)) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  }
  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (is_ours_) ::unlink(path_.c_str());
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }

  bool write(const char* data, std::size_t size) {
    is_ours_ = true;
    while (size > 0) {
      const ssize_t n = ::write(descriptor_, data, size);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return false;
      data += n;
      size -= static_cast<std::size_t>(n);
    }
    return true;
  }

  /// Some file systems report a full disk only here.
  bool close() {
    const int synced = ::fsync(descriptor_);
    const int reason = errno;
    const int closed = ::close(descriptor_);
    descriptor_ = -1;
    if (synced != 0 && reason != EINVAL && reason != EROFS) {
      errno = reason;
      return false;
    }
    return closed == 0;
  }

  bool rename_to(const std::filesystem::path& file) {
    if (::rename(path_.c_str(), file.c_str()) != 0) return false;
    is_ours_ = false;
    return true;
  }

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool is_ours_ = false;
};

}  // namespace

void write_text_atomically(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path temporary = file;
  temporary += ".tmp" + std::to_string(::getpid());
  TemporaryFile out(temporary);
  if (!out.is_open()) fail("cannot create", file, errno);
  if (!out.write(text.data(), text.size())) fail("cannot write", file, errno);
  if (!out.close()) fail("cannot write", file, errno);
  if (!out.rename_to(file)) fail("cannot replace", file, errno);
}

std::string read_file(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open", file, errno);
  std::string bytes;
  struct stat info {};
  if (::fstat(descriptor, &info) == 0 && info.st_size > 0) bytes.reserve(static_cast<std::size_t>(info.st_size));
  char buffer[1 << 16];
  for (;;) {
    const ssize_t n = ::read(descriptor, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int reason = errno;
      ::close(descriptor);
      fail("cannot read", file, reason);
    }
    if (n == 0) break;
    bytes.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(descriptor);
  return bytes;
}

}  // namespace mv
