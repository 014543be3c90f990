// Writes small recordings into a folder: what the fuzzer begins with.
#include <cstdio>
#include <fstream>

#include "tests/fuzz/recording_bytes.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: recording_inputs FOLDER\n");
    return 2;
  }
  int number = 0;
  for (const std::string& input : headway::fuzz::whole_recordings()) {
    std::ofstream(std::string(argv[1]) + "/recording_" + std::to_string(number++), std::ios::binary) << input;
  }
}
