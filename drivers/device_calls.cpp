#include "drivers/device_calls.h"

#include <cerrno>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace headway::drivers {

namespace {

template <class Call>
int repeated(Call call) noexcept {
  int result = 0;
  do {
    result = call();
  } while (result < 0 && errno == EINTR);
  return result < 0 ? -errno : result;
}

class KernelCalls final : public DeviceCalls {
 public:
  int open(const char* path) noexcept override {
    return repeated([&] { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); });
  }
  // Linux has released the descriptor even when close() was interrupted: it must not be closed again.
  int close(int descriptor) noexcept override { return ::close(descriptor) < 0 ? -errno : 0; }
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override {
    return repeated([&] { return ::ioctl(descriptor, request, argument); });
  }
  Mapped mmap(int descriptor, std::size_t length, std::int64_t offset) noexcept override {
    void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
    return memory == MAP_FAILED ? Mapped{nullptr, errno} : Mapped{memory, 0};
  }
  int munmap(void* memory, std::size_t length) noexcept override {
    return ::munmap(memory, length) < 0 ? -errno : 0;
  }
  int poll(int descriptor) noexcept override {
    pollfd one{.fd = descriptor, .events = POLLIN, .revents = 0};
    const int result = repeated([&] { return ::poll(&one, 1, 0); });
    return result < 0 ? result : one.revents;
  }
};

}  // namespace

DeviceCalls& kernel_calls() noexcept {
  static KernelCalls calls;
  return calls;
}

}  // namespace headway::drivers
