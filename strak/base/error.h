#pragma once
//
// The errors of this library. Every message is one sentence that says what is wrong, where, and what to do.

#include <stdexcept>
#include <string>

namespace strak {

// Base of all errors that strak throws.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The input (a value, a file, an option) cannot be used as it is. The program ends with exit code 2.
class InvalidInput : public Error {
 public:
  using Error::Error;
};

// The input is fine but the work could not be done: no disk space, a library failed. The program ends with exit code 1.
class Failure : public Error {
 public:
  using Error::Error;
};

}  // namespace strak
