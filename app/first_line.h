// The first line of a file, as the kernel's files in proc and sys hold one value each.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace headway::app {

/// Empty when the file cannot be read.
inline std::string first_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

}  // namespace headway::app
