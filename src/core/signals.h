// SIGINT and SIGTERM ask for a stop; the work loop saves and leaves at its next safe point.
#pragma once

namespace ld {

/// From now on the two signals only set a flag; a second one ends the process at once.
void install_stop_handler();

bool stop_requested();

/// 128 + the signal's number (130 or 143), 0 when none came.
int stop_exit_code();

}  // namespace ld
