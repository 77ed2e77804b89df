// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

namespace mv {

/// Runs the program and turns what it throws into the exit code of DESIGN section 2, with the message on the log: mv::Error its
/// own code, a failed file operation or want of memory 7, anything else 70. An Error with an empty message has already been printed.
int exit_status(const std::function<void()>& program);

}  // namespace mv
