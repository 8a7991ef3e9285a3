#pragma once
//
// How much processor time this thread has used: what the summaries report.

#include <ctime>

namespace strak {

// Processor seconds of the calling thread since it began.
inline double threadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace strak
