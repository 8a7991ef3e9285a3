#pragma once
//
// Survives Open CASCADE following a reference that leads nowhere. Only for the *_occ.cpp files.
//
// It checks little of what it reads: a damaged file can make it look through null pointers or recurse without end, at
// once or when the shape is checked or written. While the guard runs, such a signal in this thread ends the work
// instead of the program. What the work built by then is lost (no destructor runs), so nothing of it may be touched
// afterwards.

#include <functional>

namespace strak::cad {

// Runs `work`; false if it died of a signal (SIGSEGV, SIGBUS, SIGFPE), or took more than `seconds` of this thread's
// processor time (0: no limit): some damage makes the kernel go in circles. Exceptions pass through. Signals of other
// threads go where they went before. One guard at a time: the caller holds readerMutex().
bool survives(const std::function<void()>& work, double seconds = 0);

}  // namespace strak::cad
