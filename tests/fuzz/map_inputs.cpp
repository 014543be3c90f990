// Writes a whole input for each reader of maps into a folder: what the fuzzer begins with.
#include "tests/fuzz/map_bytes.h"
#include "tests/fuzz/write_inputs.h"

int main(int argc, char** argv) {
  return headway::fuzz::write_inputs(argc, argv, "whole", headway::fuzz::whole_inputs());
}
