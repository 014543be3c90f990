// Frames that another process films at this moment: raw bytes from a named pipe, one frame right after the
// other (`headway node` writes such).
#pragma once

#include <string>

#include "tests/hil/bytes.h"
#include "tests/hil/file_descriptor.h"

namespace headway::hil {

class LiveFrames {
 public:
  /// Opens the pipe, which need not have a writer yet. Throws InputError where there is none.
  LiveFrames(const std::string& pipe, std::size_t frame_size);

  /// Reads what is there, without waiting.
  void read();
  /// A whole frame has come that take() has not given out.
  bool fresh() const { return fresh_; }
  /// The newest whole frame.
  ByteSpan take();

 private:
  FileDescriptor pipe_;
  std::size_t frame_size_, filled_ = 0;
  Bytes coming_, whole_;
  bool fresh_ = false;
};

}  // namespace headway::hil
