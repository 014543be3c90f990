// A named pipe through which a test tells an emulated device what to do: one command a line, words between
// blanks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/hil/file_descriptor.h"

namespace headway::hil {

using Command = std::vector<std::string>;

class CommandPipe {
 public:
  /// Makes the pipe. Throws Error where it cannot, or where the path is taken.
  explicit CommandPipe(const std::string& path);

  int descriptor() const { return pipe_.number(); }  ///< for poll()
  /// The next command; nullopt: none that is complete. Never waits.
  std::optional<Command> next();

 private:
  FileDescriptor pipe_;
  std::string text_;  ///< read, and not yet taken
};

}  // namespace headway::hil
