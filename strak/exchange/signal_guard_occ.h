#pragma once
//
// Survives Open CASCADE following a reference that leads nowhere. Only for the *_occ.cpp files.
//
// Its readers check little: a damaged file can make them read through null pointers or recurse without end. While the
// guard runs, such a signal in this thread ends the work instead of the program. What the work held by then is lost (no
// destructor runs), which is why its document must be given up as well; so the guard is for reading files, nothing
// else.

#include <functional>

namespace strak::cad {

// Runs `work`; false if it died of a signal (SIGSEGV, SIGBUS, SIGFPE). Exceptions pass through. Signals of other
// threads go where they went before. One guard at a time: the caller holds readerMutex().
bool survives(const std::function<void()>& work);

}  // namespace strak::cad
