#pragma once
//
// Ctrl-C that keeps what has been reached.

namespace strak::cli {

// From now on the first SIGINT only makes interrupted() true; the second ends the program at once.
void catchInterrupt();

// Whether SIGINT has come since catchInterrupt().
bool interrupted();

}  // namespace strak::cli
