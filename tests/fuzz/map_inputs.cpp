// Writes a whole input for each reader of maps into a folder: what the fuzzer begins with.
#include <cstdio>
#include <fstream>

#include "tests/fuzz/map_bytes.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: map_inputs FOLDER\n");
    return 2;
  }
  int number = 0;
  for (const std::string& input : headway::fuzz::whole_inputs()) {
    std::ofstream(std::string(argv[1]) + "/whole_" + std::to_string(number++), std::ios::binary) << input;
  }
}
