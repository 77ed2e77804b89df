// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/exit_status.h"

#include <exception>

#include "geometry/core/errors.h"
#include "geometry/core/log.h"
#include "pipeline/interrupt.h"

namespace mv {
namespace {

int fail(ExitCode code, const std::string& message) {
  if (!message.empty()) spdlog::error("{}", message);
  return static_cast<int>(code);
}

}  // namespace

int exit_status(const std::function<void()>& program) {
  try {
    program();
    return static_cast<int>(ExitCode::done);
  } catch (const Error& e) {
    return fail(e.code(), e.what());
  } catch (const Interrupted&) {
    return fail(ExitCode::interrupted, "interrupted; finished stages are kept, run the same command to go on");
  } catch (const std::exception& e) {
    return fail(ExitCode::bug, std::string("this is a bug, please report it: ") + e.what());
  } catch (...) {
    return fail(ExitCode::bug, "this is a bug, please report it: unknown exception");
  }
}

}  // namespace mv
