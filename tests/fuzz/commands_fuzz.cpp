// libFuzzer's way into the answers to the operator; with another compiler, a program that reads the
// inputs named to it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/command_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  headway::fuzz::answer_lines({reinterpret_cast<const char*>(data), size});
  return 0;
}
