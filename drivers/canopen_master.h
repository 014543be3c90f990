// What a CANopen master does for all its nodes: SYNC, its own heartbeat, network management orders, and
// watching the nodes' heartbeats.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/cadence.h"
#include "hal/bus_codec.h"
#include "hal/can_bus.h"
#include "hal/time.h"

namespace headway::drivers {

/// Real-time safe. A frame that finds no room is tried again at the next tick, the newest only: none is ever
/// sent late twice.
class CanopenMaster {
 public:
  explicit CanopenMaster(hal::CanBus& bus) noexcept : bus_(bus) {}

  /// Sends the heartbeat and SYNC when they are due.
  void tick(Time now) noexcept;
  /// SYNC went out at the last tick.
  bool has_just_synced() const noexcept { return has_just_synced_; }
  /// Of SYNC's cycle, what passes until the next one is due: less than all of it after one that was late.
  double part_until_next_sync() const noexcept { return part_until_next_sync_; }
  /// Sends a network management order to one node; false when there was no room.
  bool order(hal::bus::Nmt::Command command, std::uint8_t node) noexcept;
  /// Sends any frame; false when there was no room or nothing to send.
  bool send(const std::optional<hal::CanFrame>& frame) noexcept;

 private:
  hal::CanBus& bus_;
  Cadence heartbeat_{hal::bus::Heartbeat::kCycle};
  /// A drive has little less than a period's time for each cyclic target: a SYNC that is very late draws the
  /// next one no nearer.
  Cadence sync_{hal::bus::Sync::kCycle, hal::bus::Sync::kCycle / 8};
  bool has_just_synced_ = false;
  double part_until_next_sync_ = 1;
};

/// One node's heartbeat as its master sees it.
class HeartbeatWatch {
 public:
  using State = hal::bus::Heartbeat::State;

  explicit HeartbeatWatch(Duration timeout = hal::bus::Heartbeat::kTimeout) noexcept : timeout_(timeout) {}
  /// From now on the node is expected to be heard.
  void expect(Time now) noexcept { heard_ = now; }
  void hear(Time stamp) noexcept { heard_ = stamp; }
  /// Expected, and not heard for the time-out.
  bool is_missing(Time now) const noexcept { return heard_ && now - *heard_ > timeout_; }
  void forget() noexcept { heard_.reset(); }

 private:
  Duration timeout_;
  std::optional<Time> heard_;
};

}  // namespace headway::drivers
