#include "drivers/drive_setup.h"

#include <chrono>
#include <initializer_list>

namespace headway::drivers {

namespace cia402 = hal::cia402;
namespace object = hal::cia402::object;

namespace {

constexpr auto kHeartbeatMs = std::chrono::milliseconds(100);
static_assert(hal::bus::Heartbeat::kCycle == kHeartbeatMs);
/// Our node 1, 300 ms.
constexpr std::uint32_t kWatchUs = 0x0001012C;
static_assert(hal::bus::Heartbeat::kTimeout == std::chrono::milliseconds(kWatchUs & 0xFFFF));

constexpr auto kSyncMs = std::chrono::duration_cast<std::chrono::milliseconds>(hal::bus::Sync::kCycle);

struct Pdo {
  cia402::Object id, type, count;
};
constexpr Pdo kRpdo1{object::kRpdo1Id, object::kRpdo1Type, object::kRpdo1Count},
    kTpdo1{object::kTpdo1Id, object::kTpdo1Type, object::kTpdo1Count},
    kTpdo2{object::kTpdo2Id, object::kTpdo2Type, object::kTpdo2Count};

constexpr void add_behaviour(const DriveNumbers& n, SetupTable& table) noexcept {
  table.add(object::kProducerHeartbeat, static_cast<std::uint32_t>(kHeartbeatMs.count()));
  table.add(object::kConsumerHeartbeat, kWatchUs);
  table.add(object::kAbortConnectionOption, 3);  // quick stop when our heartbeat stays away
  table.add(object::kQuickStopOption, 6);        // on the quick-stop ramp, then hold
  table.add(object::kFaultReactionOption, 2);    // the same ramp
  table.add(object::kSiUnitPosition, cia402::kMilliDegree);
  table.add(object::kPositionLimitLow, static_cast<std::uint32_t>(n.lower));
  table.add(object::kPositionLimitHigh, static_cast<std::uint32_t>(n.upper));
  table.add(object::kProfileVelocity, n.velocity);
  table.add(object::kProfileAcceleration, n.acceleration);
  table.add(object::kProfileDeceleration, n.acceleration);
  table.add(object::kQuickStopDeceleration, n.quick_stop);
  table.add(object::kFollowingErrorWindow, n.following_window);
  table.add(object::kFollowingErrorTimeout, n.following_timeout_ms);
  if (n.cyclic) {
    table.add(object::kInterpolationPeriod, static_cast<std::uint32_t>(kSyncMs.count()));
    table.add(object::kInterpolationExponent, 0xFD);  // 10^-3 s
  }
  if (n.homing && n.homing->may_move) {
    table.add(object::kHomingMethod, static_cast<std::uint8_t>(n.homing->method));
    table.add(object::kHomingSearchSpeed, n.homing->search_speed);
    table.add(object::kHomingZeroSpeed, n.homing->zero_speed);
    table.add(object::kHomingAcceleration, n.homing->acceleration);
  }
}

/// Switched off, mapped, and switched on again.
constexpr void add_pdo(const Pdo& pdo, std::uint32_t id, std::uint8_t type,
                       std::initializer_list<cia402::Object> mapped, SetupTable& table) noexcept {
  table.add(pdo.id, id | cia402::kPdoOff);
  table.add(pdo.type, type);
  table.add(pdo.count, 0);
  std::uint8_t entry = 0;
  for (const cia402::Object& object : mapped)
    table.add({pdo.count.index, ++entry, 4}, cia402::mapping_of(object));
  table.add(pdo.count, entry);
  table.add(pdo.id, id);
}

constexpr SetupTable table_of(std::uint8_t node, const DriveNumbers& n) noexcept {
  SetupTable table;
  add_behaviour(n, table);
  // A cyclic target counts from the next SYNC on, for all joints alike.
  add_pdo(kRpdo1, cia402::kRpdo1Base + node, n.cyclic ? cia402::kOnEverySync : cia402::kAtOnce,
          {object::kControlword, object::kMode, object::kTarget}, table);
  add_pdo(kTpdo1, (cia402::kTpdo1Base + node) | cia402::kPdoNoRemote, cia402::kOnEverySync,
          {object::kStatusword, object::kModeDisplay}, table);
  add_pdo(kTpdo2, (cia402::kTpdo2Base + node) | cia402::kPdoNoRemote, cia402::kOnEverySync,
          {object::kPosition, object::kVelocity}, table);
  return table;
}

/// An entry too many would not compile.
constexpr DriveNumbers kFullest{.cyclic = true, .homing = HomingNumbers{.may_move = true}};
static_assert(table_of(0x12, kFullest).size() == SetupTable::kMost);

}  // namespace

SetupTable setup_table(std::uint8_t node, const DriveNumbers& n) noexcept { return table_of(node, n); }

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
