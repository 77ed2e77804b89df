// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/interrupt.h"

#include <signal.h>
#include <unistd.h>

#include "geometry/core/errors.h"

namespace mv {
namespace {

volatile sig_atomic_t interrupts = 0;

void on_interrupt(int) {
  interrupts = interrupts + 1;
  if (interrupts > 1) _exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
  signal(SIGXFSZ, SIG_IGN);
}

bool is_interrupted() { return interrupts > 0; }

}  // namespace mv
