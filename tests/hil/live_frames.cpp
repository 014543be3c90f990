#include "tests/hil/live_frames.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::hil {

LiveFrames::LiveFrames(const std::string& pipe, std::size_t frame_size)
    // Open for writing as well, so that it does not end with each writer.
    : pipe_(::open(pipe.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)),
      frame_size_(frame_size),
      coming_(frame_size) {
  if (pipe_.number() < 0)
    throw InputError(fmt::format("{}: {}; expected a named pipe", pipe, std::strerror(errno)));
}

void LiveFrames::read() {
  for (;;) {
    const ssize_t count = ::read(pipe_.number(), coming_.data() + filled_, frame_size_ - filled_);
    if (count <= 0) return;
    filled_ += static_cast<std::size_t>(count);
    if (filled_ < frame_size_) continue;
    whole_ = coming_;
    filled_ = 0;
    fresh_ = true;
  }
}

ByteSpan LiveFrames::take() {
  fresh_ = false;
  return whole_;
}

}  // namespace headway::hil
