#include "apps/cli/interrupt.h"

#include <csignal>

namespace strak::cli {

namespace {

volatile std::sig_atomic_t interruptSeen = 0;

void onInterrupt(int signal) {
  interruptSeen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void catchInterrupt() { std::signal(SIGINT, onInterrupt); }

bool interrupted() { return interruptSeen != 0; }

}  // namespace strak::cli
