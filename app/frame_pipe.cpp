#include "app/frame_pipe.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::app {

FramePipe::FramePipe(std::filesystem::path pipe) : path_(std::move(pipe)) {
  struct stat there {};
  if (::stat(path_.c_str(), &there) == 0) {
    if (!S_ISFIFO(there.st_mode))
      throw InputError(fmt::format("{}: is no named pipe, expected one, or nothing", path_.string()));
  } else if (::mkfifo(path_.c_str(), 0600) != 0) {
    throw InputError(
        fmt::format("{}: a named pipe cannot be made: {}", path_.string(), std::strerror(errno)));
  } else {
    made_ = true;
  }
  std::signal(SIGPIPE, SIG_IGN);  // a reader that leaves is no fault
}

FramePipe::~FramePipe() {
  close();
  std::error_code ignored;
  if (made_ && std::filesystem::is_fifo(path_, ignored)) std::filesystem::remove(path_, ignored);
}

void FramePipe::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void FramePipe::offer(const hal::GrayImage& frame) {
  pump();
  if (done_ < frame_.size()) {
    ++left_out_;
    return;
  }
  if (fd_ < 0) fd_ = ::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) {  // nobody reads
    ++left_out_;
    return;
  }
  frame_ = frame.pixels;
  done_ = 0;
  pump();
}

void FramePipe::pump() noexcept {
  while (fd_ >= 0 && done_ < frame_.size()) {
    const ssize_t count = ::write(fd_, frame_.data() + done_, frame_.size() - done_);
    if (count > 0) {
      done_ += static_cast<std::size_t>(count);
      if (done_ == frame_.size()) ++written_;
    } else if (count < 0 && errno == EINTR) {
      continue;
    } else if (count < 0 && errno == EAGAIN) {
      return;
    } else {  // its reader has left
      ++left_out_;
      close();
      done_ = frame_.size();
    }
  }
}

}  // namespace headway::app
