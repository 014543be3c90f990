// What this process holds of the machine, so that a test sees what was not given back.
#pragma once

#include <filesystem>
#include <iterator>
#include <ostream>

namespace headway {

struct Held {
  std::ptrdiff_t descriptors = 0, threads = 0;
  bool operator==(const Held&) const = default;
};

/// By the kernel's own count, proc(5).
inline Held held_now() {
  const auto entries = [](const char* folder) {
    return std::distance(std::filesystem::directory_iterator(folder), {});
  };
  return {.descriptors = entries("/proc/self/fd"), .threads = entries("/proc/self/task")};
}

inline std::ostream& operator<<(std::ostream& out, const Held& held) {
  return out << held.descriptors << " descriptors, " << held.threads << " threads";
}

}  // namespace headway
