// The system calls that a camera driver makes, as a table: the kernel's, or a scripted device's in tests.
#pragma once

#include <cstddef>
#include <cstdint>

namespace headway::drivers {

/// Each does what the call of its name does, and returns what that returns, or -errno. A call that a signal
/// interrupted is made again.
class DeviceCalls {
 public:
  struct Mapped {
    void* memory = nullptr;
    int error = 0;  ///< errno; 0 when mapped
  };

  virtual ~DeviceCalls() = default;
  /// For reading and writing, never blocking, not handed on to child processes.
  virtual int open(const char* path) noexcept = 0;
  virtual int close(int descriptor) noexcept = 0;
  virtual int ioctl(int descriptor, unsigned long request, void* argument) noexcept = 0;
  /// Shared, for reading and writing.
  virtual Mapped mmap(int descriptor, std::size_t length, std::int64_t offset) noexcept = 0;
  virtual int munmap(void* memory, std::size_t length) noexcept = 0;
  /// What is the matter with the descriptor at this moment (POLLIN, POLLERR, POLLHUP); 0: nothing. Never
  /// waits.
  virtual int poll(int descriptor) noexcept = 0;
};

/// The kernel's own.
DeviceCalls& kernel_calls() noexcept;

}  // namespace headway::drivers
