// The root of every exception this program throws on purpose. They are for start-up and tools only; cycles
// report status values instead.
#pragma once

#include <stdexcept>
#include <string>

namespace headway {

/// Something the user can mend: the message says what is wrong, where, what was expected, and what to do.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

/// Bad input (a file, an argument, an image). The program ends with exit code 2.
class InputError : public Error {
 public:
  using Error::Error;
};

}  // namespace headway
