// libFuzzer's way into the codec, decoder and walker of the robot's bus; with another compiler, a program
// that reads the inputs named to it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/frame_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  headway::fuzz::hear_frames({reinterpret_cast<const char*>(data), size});
  return 0;
}
