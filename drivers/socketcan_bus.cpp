#include "drivers/socketcan_bus.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <sys/ioctl.h>

#include "hal/error.h"

namespace headway::drivers {

using hal::CanBusState;

namespace {

/// Error frames may flood a bus; no cycle reads for ever.
constexpr int kMostReads = 16;

can_filter filter_for(std::uint32_t identifier) noexcept {
  return {identifier, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
}

/// What the kernel tells beside a frame.
struct Beside {
  std::optional<Duration> stamp;            ///< on the wall clock
  std::optional<std::uint32_t> overflowed;  ///< frames that the socket has lost so far
};

Beside beside(msghdr& message) noexcept {
  Beside told;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_TIMESTAMPING && c->cmsg_len >= CMSG_LEN(sizeof(scm_timestamping))) {
      scm_timestamping stamps;
      std::memcpy(&stamps, CMSG_DATA(c), sizeof stamps);
      const timespec& software = stamps.ts[0];
      if (software.tv_sec != 0)
        told.stamp = std::chrono::seconds(software.tv_sec) + Duration(software.tv_nsec);
    } else if (c->cmsg_type == SO_RXQ_OVFL && c->cmsg_len >= CMSG_LEN(sizeof(std::uint32_t))) {
      std::uint32_t count = 0;
      std::memcpy(&count, CMSG_DATA(c), sizeof count);
      told.overflowed = count;
    }
  }
  return told;
}

}  // namespace

void SocketCanConfig::validate() const {
  if (interface.empty() || interface.size() >= IFNAMSIZ ||
      interface.find_first_of("/: \t\n") != std::string::npos)
    throw InputError(
        fmt::format("socketcan: '{}' is no name of an interface, expected 1 to {} letters such as can0",
                    interface, IFNAMSIZ - 1));
  for (const std::uint32_t id : identifiers)
    if (id > CAN_SFF_MASK)
      throw InputError(fmt::format("socketcan:{}: identifier {:#x} does not fit 11 bits", interface, id));
  if (identifiers.size() > CAN_RAW_FILTER_MAX)
    throw InputError(
        fmt::format("socketcan:{}: {} identifiers to receive, expected at most {}; none means all", interface,
                    identifiers.size(), CAN_RAW_FILTER_MAX));
}

SocketCanBus::SocketCanBus(const SocketCanConfig& config, const hal::Clock& clock, CanSocketCalls& calls)
    : config_(config), clock_(clock), calls_(calls), retry_(config.retry) {
  config_.validate();
  std::transform(config_.identifiers.begin(), config_.identifiers.end(), std::back_inserter(filters_),
                 filter_for);
  if (const auto fault = open()) explain(*fault);
}

SocketCanBus::~SocketCanBus() {
  if (fd_ >= 0) calls_.close(fd_);
}

// --- opening ---

std::optional<SocketCanBus::Fault> SocketCanBus::open() noexcept {
  const int fd = calls_.socket();
  if (fd < 0) return Fault{Step::kSocket, errno};
  const std::optional<Fault> fault = set_up(fd);
  if (fault) {
    calls_.close(fd);
  } else {
    fd_ = fd;
    overflowed_ = 0;
    emptied_ = clock_.now();
  }
  return fault;
}

std::optional<SocketCanBus::Fault> SocketCanBus::set_up(int fd) noexcept {
  ifreq about{};
  config_.interface.copy(about.ifr_name, IFNAMSIZ - 1);
  if (calls_.ioctl(fd, SIOCGIFINDEX, about) < 0) return Fault{Step::kFind, errno};
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = about.ifr_ifindex;
  if (calls_.ioctl(fd, SIOCGIFFLAGS, about) < 0) return Fault{Step::kFind, errno};
  if ((about.ifr_flags & IFF_UP) == 0) return Fault{Step::kUp, ENETDOWN};
  // Before it is bound: afterwards frames come.
  if (!set_options(fd)) return Fault{Step::kOptions, errno};
  if (calls_.bind(fd, address) < 0) return Fault{Step::kBind, errno};
  // Its error frame came before, and the kernel throws away what is sent meanwhile without a word.
  seems_off_ = (about.ifr_flags & IFF_RUNNING) == 0;
  if (seems_off_) {
    controller_ = CanBusState::kBusOff;
    ++stats_.bus_off;
  }
  return std::nullopt;
}

/// An interface that was set up a moment ago does not run yet, and no frame tells that it does.
void SocketCanBus::look_whether_it_runs() noexcept {
  ifreq about{};
  config_.interface.copy(about.ifr_name, IFNAMSIZ - 1);
  if (calls_.ioctl(fd_, SIOCGIFFLAGS, about) < 0 || (about.ifr_flags & IFF_RUNNING) == 0) return;
  seems_off_ = false;
  controller_ = CanBusState::kErrorActive;
}

bool SocketCanBus::set_options(int fd) noexcept {
  const auto set = [&](int level, int option, const auto& value) {
    return calls_.setsockopt(fd, level, option, &value, sizeof value) == 0;
  };
  const can_err_mask_t errors = CAN_ERR_CRTL | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;
  const int stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE;
  const int on = 1;
  const bool filtered = filters_.empty() ||
                        calls_.setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filters_.data(),
                                          static_cast<socklen_t>(filters_.size() * sizeof(can_filter))) == 0;
  return filtered && set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors) &&
         set(SOL_SOCKET, SO_TIMESTAMPING, stamps) && set(SOL_SOCKET, SO_RXQ_OVFL, on);
}

void SocketCanBus::explain(const Fault& fault) const {
  const std::string& name = config_.interface;
  const char* reason = std::strerror(fault.error);
  switch (fault.step) {
    case Step::kFind:
      throw InputError(
          fmt::format("socketcan:{}: there is no such interface ({}); 'ip link' lists those that are there",
                      name, reason));
    case Step::kUp:
      throw InputError(fmt::format(
          "socketcan:{0}: the interface is down, expected up; 'ip link set {0} up type can bitrate 500000' "
          "brings it up",
          name));
    case Step::kBind:
      throw InputError(fmt::format(
          "socketcan:{}: is no CAN interface ({}); 'ip -details link' tells what it is", name, reason));
    case Step::kSocket:
      throw Error(fmt::format(
          "socketcan:{}: no CAN socket ({}), expected a kernel with CAN; 'modprobe can-raw' loads it", name,
          reason));
    case Step::kOptions:
      break;
  }
  throw Error(fmt::format(
      "socketcan:{}: the kernel refuses filters, stamps or error frames ({}), expected Linux 5.10 or newer",
      name, reason));
}

bool SocketCanBus::reopen() noexcept {
  const Time now = clock_.now();
  if (!retry_.is_due(now)) return false;
  if (!open()) return true;
  retry_.failed(now);
  return false;
}

void SocketCanBus::leave() noexcept {
  calls_.close(fd_);
  fd_ = -1;
  ++stats_.gone;
  retry_.begin(clock_.now());
  // What is known of a controller ends with it.
  controller_ = CanBusState::kErrorActive;
  stats_.transmit_errors = stats_.receive_errors = 0;
  full_since_.reset();
  stalled_ = false;
}

// --- receiving ---

std::size_t SocketCanBus::receive(std::span<hal::CanFrame> into) noexcept {
  if (fd_ < 0 && !reopen()) return 0;
  if (seems_off_) look_whether_it_runs();
  std::size_t count = 0;
  for (int reads = 0; reads < kMostReads && count < into.size(); ++reads) {
    const Time before = clock_.now();
    const std::size_t asked = std::min(kBatch, into.size() - count);
    const int got = read(asked);
    if (got < 0 && errno != EAGAIN && errno != EINTR) {
      leave();
      break;
    }
    const Time now = clock_.now();
    const Duration wall_now = calls_.wall_clock();
    for (std::size_t slot = 0; static_cast<int>(slot) < got; ++slot) {
      if (take(slot, now, wall_now, into[count])) ++count;
    }
    if (got < static_cast<int>(asked)) {
      emptied_ = before;
      break;
    }
  }
  return count;
}

/// As recvmmsg.
int SocketCanBus::read(std::size_t most) noexcept {
  for (std::size_t i = 0; i < most; ++i) {
    vectors_[i] = {&frames_[i], sizeof(can_frame)};
    headers_[i] = {};
    headers_[i].msg_hdr.msg_iov = &vectors_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_control = controls_[i].bytes.data();
    headers_[i].msg_hdr.msg_controllen = kControlSize;
  }
  return calls_.recvmmsg(fd_, std::span(headers_).first(most));
}

/// True when it was a data frame for the reader.
bool SocketCanBus::take(std::size_t slot, Time now, Duration wall_now, hal::CanFrame& into) noexcept {
  const can_frame& frame = frames_[slot];
  const Beside told = beside(headers_[slot].msg_hdr);
  if (told.overflowed) {
    stats_.lost += *told.overflowed - overflowed_;  // its 32 bits wrap
    overflowed_ = *told.overflowed;
  }
  if (headers_[slot].msg_len == CAN_MTU && (frame.can_id & CAN_ERR_FLAG) != 0) {
    hear_error(frame);
    return false;
  }
  if (headers_[slot].msg_len != CAN_MTU || (frame.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) != 0) {
    ++stats_.unusable;
    return false;
  }
  // Whoever hears others is on the bus.
  if (controller_ == CanBusState::kBusOff) controller_ = CanBusState::kErrorActive;
  seems_off_ = false;
  ++stats_.received;
  into.id = frame.can_id & CAN_SFF_MASK;
  into.dlc = std::min<std::uint8_t>(frame.can_dlc, CAN_MAX_DLEN);
  into.data = {};
  std::copy_n(frame.data, into.dlc, into.data.begin());
  // It came after all before it had been read, even if somebody set the wall clock meanwhile.
  const Duration age = wall_now - told.stamp.value_or(wall_now);
  into.stamp = std::clamp(now - clock_.at_monotonic(Time(age)).time_since_epoch(), emptied_, now);
  return true;
}

/// Linux's include/uapi/linux/can/error.h says what the bits mean.
void SocketCanBus::hear_error(const can_frame& frame) noexcept {
  if ((frame.can_id & (CAN_ERR_RESTARTED | CAN_ERR_BUSOFF)) != 0) seems_off_ = false;  // now it is known
  if ((frame.can_id & CAN_ERR_RESTARTED) != 0) {
    controller_ = CanBusState::kErrorActive;
    stats_.transmit_errors = stats_.receive_errors = 0;
  }
  if ((frame.can_id & CAN_ERR_BUSOFF) != 0) {
    if (controller_ != CanBusState::kBusOff) ++stats_.bus_off;
    controller_ = CanBusState::kBusOff;
  } else if ((frame.can_id & CAN_ERR_CRTL) != 0) {
    const unsigned told = frame.data[1];
    if ((told & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++stats_.lost;
    if ((told & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0)
      controller_ = CanBusState::kErrorPassive;
    else if ((told & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0)
      controller_ = CanBusState::kErrorWarning;
    else if ((told & CAN_ERR_CRTL_ACTIVE) != 0)
      controller_ = CanBusState::kErrorActive;
  }
  if ((frame.can_id & CAN_ERR_CNT) != 0) {
    stats_.transmit_errors = frame.data[6];
    stats_.receive_errors = frame.data[7];
  }
}

// --- sending ---

bool SocketCanBus::send(const hal::CanFrame& frame) noexcept {
  const bool fits = frame.id <= CAN_SFF_MASK && frame.dlc <= CAN_MAX_DLEN;
  if (!fits || fd_ < 0 || controller_ == CanBusState::kBusOff) return refuse();
  can_frame raw{};
  raw.can_id = frame.id;
  raw.can_dlc = frame.dlc;
  std::copy_n(frame.data.begin(), frame.dlc, raw.data);
  if (calls_.write(fd_, raw) == static_cast<ssize_t>(sizeof raw)) {
    ++stats_.sent;
    full_since_.reset();
    stalled_ = false;
    return true;
  }
  if (errno == ENOBUFS || errno == EAGAIN)
    note_full();
  else if (errno != EINTR)
    leave();
  return refuse();
}

void SocketCanBus::note_full() noexcept {
  const Time now = clock_.now();
  if (!full_since_) full_since_ = now;
  if (stalled_ || now - *full_since_ < config_.stall) return;
  stalled_ = true;
  ++stats_.bus_off;
}

bool SocketCanBus::refuse() noexcept {
  ++stats_.refused;
  return false;
}

// --- what is known of it ---

CanBusState SocketCanBus::state() const noexcept {
  if (fd_ < 0) return CanBusState::kGone;
  return stalled_ ? CanBusState::kBusOff : controller_;
}

hal::CanBusStats SocketCanBus::stats() const noexcept {
  hal::CanBusStats told = stats_;
  told.state = state();
  return told;
}

}  // namespace headway::drivers
