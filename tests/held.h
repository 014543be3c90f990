// What this process holds of the machine, so that a test sees what was not given back.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>

namespace headway {

struct Held {
  std::ptrdiff_t descriptors = 0, threads = 0;
  std::ptrdiff_t camera_buffers = 0;  ///< mapped, also of a camera that is there no more
  bool operator==(const Held&) const = default;
};

/// By the kernel's own count, proc(5).
inline Held held_now() {
  const auto entries = [](const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
  };
  std::ptrdiff_t camera_buffers = 0;
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    camera_buffers += line.find("/dev/video") != std::string::npos;
  return {.descriptors = entries("/proc/self/fd"),
          .threads = entries("/proc/self/task"),
          .camera_buffers = camera_buffers};
}

inline std::ostream& operator<<(std::ostream& out, const Held& held) {
  return out << held.descriptors << " descriptors, " << held.threads << " threads, " << held.camera_buffers
             << " mapped buffers of cameras";
}

}  // namespace headway
