#include "strak/exchange/signal_guard_occ.h"

#include <unistd.h>

#include <array>
#include <csetjmp>
#include <csignal>
#include <ctime>
#include <vector>

namespace strak::cad {
namespace {

// The last one is the clock's.
constexpr std::array kSignals{SIGSEGV, SIGBUS, SIGFPE, SIGVTALRM};
constexpr std::size_t kStackSize = 1 << 16;  // for the handler, because a recursion without end leaves none

thread_local sigjmp_buf* wayOut = nullptr;
std::array<struct sigaction, kSignals.size()> previous;

void leave(int signal) {
  if (wayOut != nullptr) siglongjmp(*wayOut, signal);
  // Not ours: with the previous handler back in place the instruction fails again and goes there.
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    if (kSignals[i] == signal) sigaction(signal, &previous[i], nullptr);
  }
}

// Handler and stack in place while it lives.
class Handlers {
 public:
  Handlers() : memory_(kStackSize) {
    stack_t stack{};
    stack.ss_sp = memory_.data();
    stack.ss_size = memory_.size();
    sigaltstack(&stack, &oldStack_);
    struct sigaction action {};
    action.sa_handler = leave;
    action.sa_flags = SA_ONSTACK;
    sigemptyset(&action.sa_mask);
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &previous[i]);
  }
  ~Handlers() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &previous[i], nullptr);
    sigaltstack(&oldStack_, nullptr);
  }
  Handlers(const Handlers&) = delete;
  Handlers& operator=(const Handlers&) = delete;

 private:
  std::vector<char> memory_;
  stack_t oldStack_{};
};

// Sends SIGVTALRM to this thread once it has worked for so many processor seconds; none for 0.
class Clock {
 public:
  explicit Clock(double seconds) {
    if (!(seconds > 0)) return;
    sigevent event{};
    event.sigev_notify = SIGEV_THREAD_ID;
    event.sigev_signo = SIGVTALRM;
    event._sigev_un._tid = gettid();
    running_ = timer_create(CLOCK_THREAD_CPUTIME_ID, &event, &timer_) == 0;
    if (!running_) return;
    itimerspec at{};
    at.it_value.tv_sec = static_cast<time_t>(seconds) + 1;
    timer_settime(timer_, 0, &at, nullptr);
  }
  ~Clock() {
    if (running_) timer_delete(timer_);
  }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

 private:
  timer_t timer_{};
  bool running_ = false;
};

}  // namespace

bool survives(const std::function<void()>& work, double seconds) {
  const Handlers handlers;
  const Clock clock(seconds);
  sigjmp_buf buffer;
  // Nothing between here and `work` changes a local variable, so none is undefined after the jump.
  if (sigsetjmp(buffer, 1) != 0) {
    wayOut = nullptr;
    return false;
  }
  wayOut = &buffer;
  try {
    work();
  } catch (...) {
    wayOut = nullptr;
    throw;
  }
  wayOut = nullptr;
  return true;
}

}  // namespace strak::cad

#ifdef __SANITIZE_ADDRESS__
// For the leak checker: the kernel keeps some memory for good, and what a crash interrupted is lost.
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
extern "C" const char* __lsan_default_suppressions() { return "leak:libTK\nleak:strak::cad::survives\n"; }
#endif
