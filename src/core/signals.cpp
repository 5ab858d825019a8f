#include "core/signals.h"

#include <csignal>

namespace ld {
namespace {

volatile std::sig_atomic_t received_signal = 0;

extern "C" void note_signal(int number) {
  received_signal = number;
  // The second signal finds the default action: whoever presses Ctrl-C twice means it.
  std::signal(number, SIG_DFL);
}

}  // namespace

void install_stop_handler() {
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
}

bool stop_requested() {
  return received_signal != 0;
}

int stop_exit_code() {
  return received_signal == 0 ? 0 : 128 + received_signal;
}

}  // namespace ld
