// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/exit_status.h"

#include <exception>
#include <filesystem>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"

namespace mv {
namespace {

constexpr std::size_t longest_message = 4000;  // characters: files may hold names of any length
constexpr std::size_t longest_path = 200;  // characters of it in a message

int fail(ExitCode code, const std::string& message) {
  if (!message.empty()) spdlog::error("{}", message.size() <= longest_message ? message : message.substr(0, longest_message) + " ...");
  return static_cast<int>(code);
}

}  // namespace

int exit_status(const std::function<void()>& program) {
  try {
    program();
    return static_cast<int>(ExitCode::done);
  } catch (const Error& e) {
    return fail(e.code(), e.what());
  } catch (const std::filesystem::filesystem_error& e) {
    return fail(ExitCode::io, (e.path1().empty() ? std::string() : e.path1().string().substr(0, longest_path) + ": ") + e.code().message());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::io, "out of memory; a coarser mesh.spacing or tube.spacing needs less");
  } catch (const std::exception& e) {
    return fail(ExitCode::bug, std::string("this is a bug, please report it: ") + e.what());
  } catch (...) {
    return fail(ExitCode::bug, "this is a bug, please report it: unknown exception");
  }
}

}  // namespace mv
