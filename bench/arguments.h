// Arguments of a benchmark's own, beside Google Benchmark's.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string>
#include <system_error>

#include "hal/error.h"

namespace headway::bench {

/// Takes `--NAME N` away from the arguments that go on.
inline int take(int& argc, char** argv, const char* name, int value) {
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::strcmp(argv[i], name) != 0) continue;
    const char* text = argv[i + 1];
    const char* end = text + std::strlen(text);
    if (const auto [last, fault] = std::from_chars(text, end, value);
        fault != std::errc{} || last != end || value < 1)
      throw InputError(std::string(name) + ": '" + text + "', expected a whole number from 1 on");
    std::copy(argv + i + 2, argv + argc, argv + i);
    argc -= 2;
    break;
  }
  return value;
}

}  // namespace headway::bench
