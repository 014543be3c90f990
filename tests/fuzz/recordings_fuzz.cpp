// libFuzzer's way into the reader of recordings; with another compiler, a program that reads the inputs named
// to it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/recording_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  headway::fuzz::is_recording({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
