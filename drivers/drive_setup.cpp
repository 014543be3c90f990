#include "drivers/drive_setup.h"

#include <chrono>

namespace headway::drivers {

namespace cia402 = hal::cia402;
namespace object = hal::cia402::object;

namespace {

constexpr auto kHeartbeatMs = std::chrono::milliseconds(100);
static_assert(hal::bus::Heartbeat::kCycle == kHeartbeatMs);
/// Our node 1, 300 ms.
constexpr std::uint32_t kWatchUs = 0x0001012C;
static_assert(hal::bus::Heartbeat::kTimeout == std::chrono::milliseconds(kWatchUs & 0xFFFF));

/// Entry `n` (1, 2, ...) of the PDO mapping that begins with `count`.
constexpr cia402::Object mapped(const cia402::Object& count, std::uint8_t n) noexcept {
  return {count.index, n, 4};
}

}  // namespace

SetupTable setup_table(std::uint8_t node, const DriveNumbers& n) noexcept {
  const std::uint32_t rpdo1 = cia402::kRpdo1Base + node;
  const std::uint32_t tpdo1 = (cia402::kTpdo1Base + node) | cia402::kPdoNoRemote;
  const std::uint32_t tpdo2 = (cia402::kTpdo2Base + node) | cia402::kPdoNoRemote;
  return {{
      {object::kProducerHeartbeat, static_cast<std::uint32_t>(kHeartbeatMs.count())},
      {object::kConsumerHeartbeat, kWatchUs},
      {object::kAbortConnectionOption, 3},  // quick stop when our heartbeat stays away
      {object::kQuickStopOption, 6},        // on the quick-stop ramp, then hold
      {object::kFaultReactionOption, 2},    // the same ramp
      {object::kSiUnitPosition, cia402::kMilliDegree},
      {object::kPositionLimitLow, static_cast<std::uint32_t>(n.lower)},
      {object::kPositionLimitHigh, static_cast<std::uint32_t>(n.upper)},
      {object::kProfileVelocity, n.velocity},
      {object::kProfileAcceleration, n.acceleration},
      {object::kProfileDeceleration, n.acceleration},
      {object::kQuickStopDeceleration, n.quick_stop},
      {object::kFollowingErrorWindow, n.following_window},
      {object::kFollowingErrorTimeout, n.following_timeout_ms},

      {object::kRpdo1Id, rpdo1 | cia402::kPdoOff},
      {object::kRpdo1Type, cia402::kAtOnce},
      {object::kRpdo1Count, 0},
      {mapped(object::kRpdo1Count, 1), cia402::mapping_of(object::kControlword)},
      {mapped(object::kRpdo1Count, 2), cia402::mapping_of(object::kMode)},
      {mapped(object::kRpdo1Count, 3), cia402::mapping_of(object::kTarget)},
      {object::kRpdo1Count, 3},
      {object::kRpdo1Id, rpdo1},

      {object::kTpdo1Id, tpdo1 | cia402::kPdoOff},
      {object::kTpdo1Type, cia402::kOnEverySync},
      {object::kTpdo1Count, 0},
      {mapped(object::kTpdo1Count, 1), cia402::mapping_of(object::kStatusword)},
      {mapped(object::kTpdo1Count, 2), cia402::mapping_of(object::kModeDisplay)},
      {object::kTpdo1Count, 2},
      {object::kTpdo1Id, tpdo1},

      {object::kTpdo2Id, tpdo2 | cia402::kPdoOff},
      {object::kTpdo2Type, cia402::kOnEverySync},
      {object::kTpdo2Count, 0},
      {mapped(object::kTpdo2Count, 1), cia402::mapping_of(object::kPosition)},
      {mapped(object::kTpdo2Count, 2), cia402::mapping_of(object::kVelocity)},
      {object::kTpdo2Count, 2},
      {object::kTpdo2Id, tpdo2},
  }};
}

void DriveSetup::begin() noexcept {
  next_ = 0;
  reading_ = false;
  status_ = Status::kBusy;
  sdo_.cancel();
}

void DriveSetup::tick(Time now) noexcept {
  if (status_ != Status::kBusy) return;
  switch (sdo_.status()) {
    case SdoClient::Status::kIdle:
      sdo_.write(table_[next_].object, table_[next_].value);
      break;
    case SdoClient::Status::kBusy:
      break;
    case SdoClient::Status::kDone:
      reading_ ? compare() : read_back();
      break;
    case SdoClient::Status::kRefused:
      status_ = Status::kRefused;
      break;
    case SdoClient::Status::kTimedOut:
      status_ = Status::kTimedOut;
      break;
  }
  sdo_.tick(now);
}

void DriveSetup::read_back() noexcept {
  reading_ = true;
  sdo_.read(table_[next_].object);
}

void DriveSetup::compare() noexcept {
  if (sdo_.value() != table_[next_].value) {
    status_ = Status::kReadsDifferent;
    return;
  }
  reading_ = false;
  if (++next_ == table_.size()) {
    status_ = Status::kDone;
  } else {
    sdo_.write(table_[next_].object, table_[next_].value);
  }
}

}  // namespace headway::drivers
