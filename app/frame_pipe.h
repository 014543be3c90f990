// A camera's frames as bytes: raw grey pixels, row by row, one frame right after the other, into a named pipe
// that somebody else reads (the emulated USB camera of scripts/wires, or any viewer of raw video).
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "hal/frame.h"

namespace headway::app {

/// Never waits: a frame that comes while the reader still has one to read is left out, whole. Another reader
/// begins with a whole frame, unless it comes within a moment of the one before. Ignores SIGPIPE, in the
/// whole process.
class FramePipe {
 public:
  /// Makes the named pipe if need be; that one is gone with it again. Throws InputError where there is
  /// something else, or nothing can be made.
  explicit FramePipe(std::filesystem::path pipe);
  ~FramePipe();
  FramePipe(const FramePipe&) = delete;
  FramePipe& operator=(const FramePipe&) = delete;

  /// Takes the frame, if the one before has gone out, and writes what there is room for.
  void offer(const hal::GrayImage& frame);
  /// Goes on writing.
  void pump() noexcept;

  std::uint64_t written() const { return written_; }  ///< whole frames
  std::uint64_t left_out() const { return left_out_; }

 private:
  void close() noexcept;

  std::filesystem::path path_;
  bool made_ = false;
  int fd_ = -1;
  std::vector<std::uint8_t> frame_;
  std::size_t done_ = 0;  ///< bytes of it
  std::uint64_t written_ = 0, left_out_ = 0;
};

}  // namespace headway::app
