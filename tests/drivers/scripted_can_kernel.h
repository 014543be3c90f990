// The CAN half of a kernel that a test holds in its hands: interfaces that come and go, queues that fill,
// error frames, a wall clock that jumps. It behaves as Linux's net/can/raw.c does.
#pragma once

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <sys/ioctl.h>

#include "drivers/can_socket_calls.h"
#include "hal/clock.h"

namespace headway::drivers::testing {

/// Uses no heap once built, so that a test can count what a bus allocates.
class ScriptedCanKernel : public CanSocketCalls {
 public:
  static constexpr std::size_t kSockets = 4, kQueue = 256;

  struct Sent {
    int index;
    can_frame frame;
  };

  explicit ScriptedCanKernel(hal::ManualClock& clock) : clock_(clock) { sent.reserve(1 << 16); }

  // --- what happens to it ---

  /// The interface is there, under this index.
  void plug(int index) {
    index_ = index;
    up = true;
  }
  /// Every socket on it is told once, and is on none from then on.
  void unplug() {
    index_ = 0;
    tell(ENODEV);
    for (Socket& s : sockets_) s.index = 0;
  }
  void take_down() {
    up = false;
    tell(ENETDOWN);
  }
  /// A frame on the bus, stamped now on the wall clock.
  void arrive(const can_frame& frame) {
    for (Socket& s : sockets_) {
      if (!s.open || s.index == 0 || s.index != index_ || !s.wants(frame)) continue;
      if (s.waiting == kQueue)
        ++s.dropped;
      else
        s.queue[(s.first + s.waiting++) % kQueue] = {frame, wall_clock(), s.dropped};
    }
  }
  void arrive(canid_t id, std::initializer_list<std::uint8_t> data = {}) {
    can_frame frame{};
    frame.can_id = id;
    frame.can_dlc = static_cast<__u8>(data.size());
    std::copy(data.begin(), data.end(), frame.data);
    arrive(frame);
  }
  /// As if the open sockets had lost so many frames before.
  void set_dropped(std::uint32_t count) {
    for (Socket& s : sockets_) s.dropped = count;
  }

  std::string interface = "can0";
  bool up = true, is_can = true;
  bool runs = true;            ///< has a carrier: its controller is on the bus
  std::size_t room = 1 << 16;  ///< frames that the queue for sending takes
  Duration wall_ahead{};       ///< of the monotonic clock
  int refused_option = -1;     ///< setsockopt fails for it
  bool has_can = true;         ///< the kernel knows CAN at all
  std::vector<Sent> sent;      ///< while there is room for them
  std::size_t tries = 0;       ///< sockets asked for
  Time last_try{};
  std::size_t open_descriptors() const {
    return static_cast<std::size_t>(
        std::count_if(sockets_.begin(), sockets_.end(), [](const Socket& s) { return s.open; }));
  }
  bool misused = false;  ///< a call named a descriptor that is not open

  // --- its calls ---

  int socket() noexcept override {
    ++tries;
    last_try = clock_.now();
    if (!has_can) return fail(EAFNOSUPPORT);
    for (std::size_t i = 0; i < kSockets; ++i) {
      if (sockets_[i].open) continue;
      sockets_[i] = Socket{};
      sockets_[i].open = true;
      return static_cast<int>(i) + kFirst;
    }
    return fail(EMFILE);
  }
  int ioctl(int fd, unsigned long request, ifreq& about) noexcept override {
    if (!socket_of(fd)) return fail(EBADF);
    if (index_ == 0 || interface != about.ifr_name) return fail(ENODEV);
    if (request == SIOCGIFINDEX)
      about.ifr_ifindex = index_;
    else if (request == SIOCGIFFLAGS)
      about.ifr_flags = static_cast<short>((up ? IFF_UP : 0) | (up && runs ? IFF_RUNNING : 0));
    else
      return fail(EINVAL);
    return 0;
  }
  int setsockopt(int fd, int level, int option, const void* value, socklen_t size) noexcept override {
    Socket* s = socket_of(fd);
    if (!s) return fail(EBADF);
    if (option == refused_option) return fail(ENOPROTOOPT);
    if (level == SOL_CAN_RAW && option == CAN_RAW_FILTER) {
      s->filters = size / sizeof(can_filter);
      if (s->filters > s->filter.size()) return fail(EINVAL);
      std::memcpy(s->filter.data(), value, size);
    } else if (level == SOL_CAN_RAW && option == CAN_RAW_ERR_FILTER) {
      std::memcpy(&s->errors, value, sizeof s->errors);
    } else if (level == SOL_SOCKET && option == SO_TIMESTAMPING) {
      s->stamps = true;
    } else if (level == SOL_SOCKET && option == SO_RXQ_OVFL) {
      s->tells_dropped = true;
    } else {
      return fail(ENOPROTOOPT);
    }
    return 0;
  }
  int bind(int fd, const sockaddr_can& address) noexcept override {
    Socket* s = socket_of(fd);
    if (!s) return fail(EBADF);
    if (address.can_family != AF_CAN) return fail(EINVAL);
    if (!is_can || address.can_ifindex != index_) return fail(ENODEV);
    s->index = index_;
    return 0;
  }
  int recvmmsg(int fd, std::span<mmsghdr> into) noexcept override {
    Socket* s = socket_of(fd);
    if (!s) return fail(EBADF);
    if (s->error != 0) return fail(std::exchange(s->error, 0));
    int got = 0;
    for (mmsghdr& header : into) {
      if (s->waiting == 0) break;
      deliver(*s, header);
      ++got;
    }
    return got == 0 ? fail(EAGAIN) : got;
  }
  ssize_t write(int fd, const can_frame& frame) noexcept override {
    const Socket* s = socket_of(fd);
    if (!s) return fail(EBADF);
    if (index_ == 0 || s->index != index_) return fail(ENXIO);
    if (!up) return fail(ENETDOWN);
    if (sent.size() == std::min(room, sent.capacity())) return fail(ENOBUFS);
    sent.push_back({index_, frame});
    return sizeof frame;
  }
  void close(int fd) noexcept override {
    if (Socket* s = socket_of(fd)) s->open = false;
    errno = EIO;  // as any call may leave it
  }
  Duration wall_clock() noexcept override { return clock_.now().time_since_epoch() + wall_ahead; }

 private:
  static constexpr int kFirst = 100;  ///< number of the first descriptor

  struct Waiting {
    can_frame frame;
    Duration stamp;
    std::uint32_t dropped;
  };
  struct Socket {
    bool open = false, stamps = false, tells_dropped = false;
    int index = 0, error = 0;
    std::array<can_filter, 8> filter{};
    std::size_t filters = 1;  // one that lets all pass
    can_err_mask_t errors = 0;
    std::array<Waiting, kQueue> queue{};
    std::size_t first = 0, waiting = 0;
    std::uint32_t dropped = 0;

    bool wants(const can_frame& frame) const {
      if ((frame.can_id & CAN_ERR_FLAG) != 0) return (frame.can_id & errors) != 0;
      return std::any_of(
          filter.begin(), filter.begin() + static_cast<std::ptrdiff_t>(filters),
          [&](const can_filter& f) { return (frame.can_id & f.can_mask) == (f.can_id & f.can_mask); });
    }
  };

  static int fail(int number) noexcept {
    errno = number;
    return -1;
  }
  Socket* socket_of(int fd) noexcept {
    const std::size_t i = static_cast<std::size_t>(fd - kFirst);
    const bool known = fd >= kFirst && i < kSockets && sockets_[i].open;
    misused = misused || !known;
    return known ? &sockets_[i] : nullptr;
  }
  void tell(int error) {
    for (Socket& s : sockets_)
      if (s.open && s.index != 0) s.error = error;
  }
  static void deliver(Socket& s, mmsghdr& header) noexcept {
    const Waiting& w = s.queue[s.first];
    s.first = (s.first + 1) % kQueue;
    --s.waiting;
    msghdr& m = header.msg_hdr;
    const std::size_t bytes = std::min(m.msg_iov->iov_len, sizeof w.frame);
    std::memcpy(m.msg_iov->iov_base, &w.frame, bytes);
    header.msg_len = static_cast<unsigned>(bytes);
    std::size_t used = 0;
    if (s.stamps) {
      scm_timestamping stamps{};
      stamps.ts[0] = {w.stamp.count() / 1'000'000'000, w.stamp.count() % 1'000'000'000};
      used += put(m, used, SO_TIMESTAMPING, stamps);
    }
    if (s.tells_dropped && w.dropped != 0) used += put(m, used, SO_RXQ_OVFL, w.dropped);
    m.msg_controllen = used;
  }
  template <class Value>
  static std::size_t put(msghdr& m, std::size_t at, int type, const Value& value) noexcept {
    if (at + CMSG_SPACE(sizeof value) > m.msg_controllen) {
      m.msg_flags |= MSG_CTRUNC;
      return 0;
    }
    cmsghdr header{};
    header.cmsg_len = CMSG_LEN(sizeof value);
    header.cmsg_level = SOL_SOCKET;
    header.cmsg_type = type;
    std::byte* to = static_cast<std::byte*>(m.msg_control) + at;
    std::memcpy(to, &header, sizeof header);
    std::memcpy(to + CMSG_LEN(0), &value, sizeof value);
    return CMSG_SPACE(sizeof value);
  }

  hal::ManualClock& clock_;
  int index_ = 3;
  std::array<Socket, kSockets> sockets_{};
};

}  // namespace headway::drivers::testing
