// The CAN interfaces of this machine as the kernel tells of them (rtnetlink(7), linux/can/netlink.h), for
// tools.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/can_bus.h"
#include "hal/time.h"

namespace headway::drivers {

struct CanLink {
  std::string name;  ///< "can0"
  std::string kind;  ///< "can", "vcan", ...; empty: not told
  bool is_up = false;
  std::optional<hal::CanBusState>
      controller;             ///< a stopped one is off the bus; none: a bus without controller
  std::uint32_t bitrate = 0;  ///< [bit/s]; 0: none is set
  double sample_point = 0;    ///< fraction of the bit; 0: none is set
  Duration restart{};         ///< after it went off the bus; zero: never by itself
};

/// Those in the kernel's answer to RTM_GETLINK. What is cut short or no CAN interface is left out.
std::vector<CanLink> can_links_in(std::span<const std::byte> answer);

/// Asks the kernel, and waits for its answer for a second at most. Throws Error when none comes.
std::vector<CanLink> list_can_links();

}  // namespace headway::drivers
