// The system calls that a SocketCAN bus makes, so that a test can play the kernel.
#pragma once

#include <span>

#include <linux/can.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/types.h>

#include "hal/time.h"

namespace headway::drivers {

/// Each as the kernel's call of that name: a negative answer, and errno, where it fails. None blocks.
class CanSocketCalls {
 public:
  virtual ~CanSocketCalls() = default;
  /// A raw CAN socket that does not block.
  virtual int socket() noexcept = 0;
  virtual int ioctl(int fd, unsigned long request, ifreq& about) noexcept = 0;
  virtual int setsockopt(int fd, int level, int option, const void* value, socklen_t size) noexcept = 0;
  virtual int bind(int fd, const sockaddr_can& address) noexcept = 0;
  virtual int recvmmsg(int fd, std::span<mmsghdr> into) noexcept = 0;
  virtual ssize_t write(int fd, const can_frame& frame) noexcept = 0;
  virtual void close(int fd) noexcept = 0;
  /// hal::wall_clock(), on which the kernel stamps frames.
  virtual Duration wall_clock() noexcept = 0;
};

/// The real ones.
CanSocketCalls& kernel_can_socket_calls() noexcept;

}  // namespace headway::drivers
