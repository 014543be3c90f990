#include "drivers/can_socket_calls.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include "hal/wall_clock.h"

namespace headway::drivers {

namespace {

class KernelCalls final : public CanSocketCalls {
 public:
  int socket() noexcept override {
    return ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  }
  int ioctl(int fd, unsigned long request, ifreq& about) noexcept override {
    return ::ioctl(fd, request, &about);
  }
  int setsockopt(int fd, int level, int option, const void* value, socklen_t size) noexcept override {
    return ::setsockopt(fd, level, option, value, size);
  }
  int bind(int fd, const sockaddr_can& address) noexcept override {
    return ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  int recvmmsg(int fd, std::span<mmsghdr> into) noexcept override {
    return ::recvmmsg(fd, into.data(), static_cast<unsigned>(into.size()), MSG_DONTWAIT, nullptr);
  }
  ssize_t write(int fd, const can_frame& frame) noexcept override {
    return ::write(fd, &frame, sizeof frame);
  }
  void close(int fd) noexcept override { ::close(fd); }
  Duration wall_clock() noexcept override { return hal::wall_clock(); }
};

}  // namespace

CanSocketCalls& kernel_can_socket_calls() noexcept {
  static KernelCalls calls;
  return calls;
}

}  // namespace headway::drivers
