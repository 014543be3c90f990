// Writes a whole file for each reader of what people write into a folder: what the fuzzer begins with.
#include "tests/fuzz/config_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "config", headway::fuzz::whole_configs());
}
