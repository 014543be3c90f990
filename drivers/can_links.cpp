#include "drivers/can_links.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

#include <fmt/format.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::drivers {

namespace {

using Bytes = std::span<const std::byte>;

template <class Value>
std::optional<Value> front_of(Bytes bytes) {
  Value value{};
  if (bytes.size() < sizeof value) return std::nullopt;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

constexpr std::size_t aligned(std::size_t length) { return (length + 3) & ~std::size_t{3}; }

/// Takes a part with its header off the front; nothing where it is cut short.
std::optional<Bytes> take_part(Bytes& from, std::size_t length, std::size_t header) {
  if (length < header || length > from.size()) return std::nullopt;
  const Bytes body = from.first(length).subspan(header);
  from = from.subspan(std::min(aligned(length), from.size()));
  return body;
}

/// Calls visit(type, body) for each attribute.
template <class Visit>
void visit_attributes(Bytes all, Visit visit) {
  while (const auto header = front_of<rtattr>(all)) {
    const std::optional<Bytes> body = take_part(all, header->rta_len, sizeof *header);
    if (!body) return;
    visit(header->rta_type & NLA_TYPE_MASK, *body);
  }
}

std::string text_in(Bytes bytes) {
  const auto* begin = reinterpret_cast<const char*>(bytes.data());
  return {begin, std::find(begin, begin + bytes.size(), '\0')};
}

hal::CanBusState state_of(std::uint32_t kernels) {
  switch (kernels) {
    case CAN_STATE_ERROR_ACTIVE:
      return hal::CanBusState::kErrorActive;
    case CAN_STATE_ERROR_WARNING:
      return hal::CanBusState::kErrorWarning;
    case CAN_STATE_ERROR_PASSIVE:
      return hal::CanBusState::kErrorPassive;
    default:
      return hal::CanBusState::kBusOff;
  }
}

void read_controller(Bytes data, CanLink& link) {
  visit_attributes(data, [&link](int type, Bytes body) {
    if (const auto timing = front_of<can_bittiming>(body); type == IFLA_CAN_BITTIMING && timing) {
      link.bitrate = timing->bitrate;
      link.sample_point = timing->sample_point / 1000.0;
    }
    const auto number = front_of<std::uint32_t>(body);
    if (type == IFLA_CAN_STATE && number) link.controller = state_of(*number);
    if (type == IFLA_CAN_RESTART_MS && number) link.restart = std::chrono::milliseconds(*number);
  });
}

CanLink link_of(const ifinfomsg& info, Bytes attributes) {
  CanLink link;
  link.is_up = (info.ifi_flags & IFF_UP) != 0;
  visit_attributes(attributes, [&link](int type, Bytes body) {
    if (type == IFLA_IFNAME) link.name = text_in(body);
    if (type != IFLA_LINKINFO) return;
    visit_attributes(body, [&link](int part, Bytes data) {
      if (part == IFLA_INFO_KIND) link.kind = text_in(data);
      if (part == IFLA_INFO_DATA) read_controller(data, link);
    });
  });
  return link;
}

/// Calls visit(type, body) for each message.
template <class Visit>
void visit_messages(Bytes all, Visit visit) {
  while (const auto header = front_of<nlmsghdr>(all)) {
    const std::optional<Bytes> body = take_part(all, header->nlmsg_len, sizeof *header);
    if (!body) return;
    visit(header->nlmsg_type, *body);
  }
}

class RouteSocket {
 public:
  RouteSocket() : descriptor_(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {
    if (descriptor_ < 0) fail(errno);
    // Without an answer it would wait for ever; that this could be refused is not known.
    const timeval patience{.tv_sec = 1, .tv_usec = 0};
    setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~RouteSocket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  RouteSocket(const RouteSocket&) = delete;
  RouteSocket& operator=(const RouteSocket&) = delete;

  void ask_for_links() const {
    struct {
      nlmsghdr header;
      ifinfomsg info;
    } request{};
    request.header.nlmsg_len = sizeof request;
    request.header.nlmsg_type = RTM_GETLINK;
    request.header.nlmsg_flags = NLM_F_REQUEST | NLM_F_DUMP;
    if (::send(descriptor_, &request, sizeof request, 0) < 0) fail(errno);
  }
  Bytes receive(std::span<std::byte> into) const {
    ssize_t got = 0;
    do {
      got = ::recv(descriptor_, into.data(), into.size(), MSG_TRUNC);
    } while (got < 0 && errno == EINTR);
    if (got <= 0) fail(errno);
    if (static_cast<std::size_t>(got) > into.size()) fail(EMSGSIZE);
    return into.first(static_cast<std::size_t>(got));
  }
  [[noreturn]] static void fail(int error) {
    throw Error(
        fmt::format("the kernel's list of network interfaces (netlink): {}, expected an answer; look "
                    "at what confines this program",
                    std::strerror(error)));
  }

 private:
  int descriptor_;
};

}  // namespace

std::vector<CanLink> can_links_in(Bytes answer) {
  std::vector<CanLink> links;
  visit_messages(answer, [&links](int type, Bytes body) {
    const auto info = front_of<ifinfomsg>(body);
    if (type != RTM_NEWLINK || !info || info->ifi_type != ARPHRD_CAN) return;
    links.push_back(link_of(*info, body.subspan(sizeof *info)));
  });
  return links;
}

std::vector<CanLink> list_can_links() {
  const RouteSocket kernel;
  kernel.ask_for_links();
  std::vector<std::byte> buffer(1 << 16);
  std::vector<CanLink> all;
  for (bool is_done = false; !is_done;) {
    const Bytes answer = kernel.receive(buffer);
    std::ranges::move(can_links_in(answer), std::back_inserter(all));
    visit_messages(answer, [&](int type, Bytes body) {
      is_done |= type == NLMSG_DONE;
      if (type == NLMSG_ERROR)
        RouteSocket::fail(-front_of<nlmsgerr>(body).value_or(nlmsgerr{-EPROTO, {}}).error);
    });
  }
  return all;
}

}  // namespace headway::drivers
