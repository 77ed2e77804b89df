// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace mv {

/// Thrown between two stages after Ctrl-C; ends the program with exit code 130.
struct Interrupted {};

/// First Ctrl-C: ends after the present stage, so that the case stays consistent. Second: at once (files are replaced whole in
/// any case).
void catch_interrupts();
bool is_interrupted();

}  // namespace mv
