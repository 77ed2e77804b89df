// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace mv {

/// Process exit codes shared by mvprep and mvsolve.
enum class ExitCode : int {
  done = 0,
  usage = 2,
  config = 3,
  input = 4,
  geometry_gate = 5,
  not_trustworthy = 6,
  io = 7,
  bug = 70,
  interrupted = 130
};

/// Base of every error that a user can cause or remedy; `what()` names file, key, value, what was expected and what to do.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// Wrong command line.
struct UsageError : Error {
  explicit UsageError(const std::string& m) : Error(ExitCode::usage, m) {}
};
/// Wrong configuration: unknown key, wrong unit, value out of range.
struct ConfigError : Error {
  explicit ConfigError(const std::string& m) : Error(ExitCode::config, m) {}
};
/// Input data (case, mesh, image, CSV) that is damaged, incomplete or inconsistent.
struct InputError : Error {
  explicit InputError(const std::string& m) : Error(ExitCode::input, m) {}
};
/// A geometry or mesh gate did not pass.
struct GateError : Error {
  explicit GateError(const std::string& m) : Error(ExitCode::geometry_gate, m) {}
};
/// The solution diverged or a trust gate failed.
struct TrustError : Error {
  explicit TrustError(const std::string& m) : Error(ExitCode::not_trustworthy, m) {}
};
/// Reading or writing failed (missing file, disk full, permissions).
struct IoError : Error {
  explicit IoError(const std::string& m) : Error(ExitCode::io, m) {}
};

}  // namespace mv
