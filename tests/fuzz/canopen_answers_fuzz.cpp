// libFuzzer's way into the master of the head's drives; with another compiler, a program that reads the
// inputs named to it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/answer_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  headway::fuzz::hear_answers({reinterpret_cast<const char*>(data), size});
  return 0;
}
