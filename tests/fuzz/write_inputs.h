// What the programs that write a fuzzer's first inputs have in common.
#pragma once

#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace headway::fuzz {

/// Writes each input into the folder that the command names, as `name`_0, `name`_1, ...; returns the
/// program's exit code.
inline int write_inputs(int argc, char** argv, const std::string& name,
                        const std::vector<std::string>& inputs) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  int number = 0;
  for (const std::string& input : inputs) {
    const std::string file = std::string(argv[1]) + "/" + name + "_" + std::to_string(number++);
    if (!(std::ofstream(file, std::ios::binary) << input)) {
      std::fprintf(stderr, "%s: cannot be written\n", file.c_str());
      return 1;
    }
  }
  return 0;
}

}  // namespace headway::fuzz
