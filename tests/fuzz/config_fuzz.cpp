// libFuzzer's way into the readers of the files that people write; with another compiler, a program that
// reads the inputs named to it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/config_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  headway::fuzz::is_config({reinterpret_cast<const char*>(data), size});
  return 0;
}
