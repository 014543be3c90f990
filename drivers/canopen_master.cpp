#include "drivers/canopen_master.h"

namespace headway::drivers {

using hal::bus::Heartbeat;
using hal::bus::Nmt;
using hal::bus::Sync;

namespace {

constexpr std::uint32_t kOwnHeartbeat = 0x701;
constexpr std::optional<hal::CanFrame> kHeartbeat =
    Heartbeat{.state = Heartbeat::State::kOperational}.pack(kOwnHeartbeat);
constexpr std::optional<hal::CanFrame> kSync = Sync{}.pack();

}  // namespace

void CanopenMaster::tick(Time now) noexcept {
  if (heartbeat_.is_due(now) && send(kHeartbeat)) heartbeat_.done(now);
  has_just_synced_ = sync_.is_due(now) && send(kSync);
  if (!has_just_synced_) return;
  sync_.done(now);
  part_until_next_sync_ = to_seconds(sync_.until_due(now)) / to_seconds(Sync::kCycle);
}

bool CanopenMaster::order(Nmt::Command command, std::uint8_t node) noexcept {
  return send(Nmt{.command = command, .node = node}.pack());
}

bool CanopenMaster::send(const std::optional<hal::CanFrame>& frame) noexcept {
  return frame && bus_.send(*frame);
}

}  // namespace headway::drivers
