#include "tests/hil/command_pipe.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include "hal/error.h"

namespace headway::hil {

CommandPipe::CommandPipe(const std::string& path) {
  if (::mkfifo(path.c_str(), 0600) != 0) {
    throw Error(
        fmt::format("{}: {}; expected a path where a named pipe can be made", path, std::strerror(errno)));
  }
  // Open for writing too, it never reads an end of file when a writer goes.
  pipe_ = FileDescriptor(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!pipe_)
    throw Error(fmt::format("{}: {}; expected to open the pipe just made", path, std::strerror(errno)));
}

std::optional<Command> CommandPipe::next() {
  std::array<char, 4096> chunk{};
  for (ssize_t count; (count = ::read(pipe_.number(), chunk.data(), chunk.size())) > 0;) {
    text_.append(chunk.data(), static_cast<std::size_t>(count));
  }
  const auto end = text_.find('\n');
  if (end == std::string::npos) return std::nullopt;
  std::istringstream line(text_.substr(0, end));
  text_.erase(0, end + 1);
  return Command{std::istream_iterator<std::string>(line), {}};
}

}  // namespace headway::hil
