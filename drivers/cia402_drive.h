// One drive of the head (CiA 402): set up, led to Operation enabled, given set-points, watched.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "drivers/canopen_master.h"
#include "drivers/cyclic_set_points.h"
#include "drivers/drive_setup.h"
#include "drivers/homing.h"
#include "drivers/profile_set_points.h"
#include "hal/bus_codec.h"
#include "hal/cia402.h"
#include "hal/time.h"

namespace headway::drivers {

struct DriveTimeouts {
  SdoClient::Config sdo;
  Duration pdo = hal::bus::DriveStatus::kTimeout;       ///< status or position missed
  Duration heartbeat = hal::bus::Heartbeat::kTimeout;   ///< drive gone
  Duration state = std::chrono::seconds(2);             ///< for one transition of the drive's states
  Duration set_point = std::chrono::milliseconds(500);  ///< for the acknowledgement of a set-point
};

enum class DrivePhase : std::uint8_t {
  kOrdering,  ///< to be sent to pre-operational
  kSettingUp,
  kEnabling,  ///< on its way to Operation enabled
  kHoming,    ///< asked whether it knows where its joint is, or finding that out
  kRunning,
  kFailed,
  kLeaving,  ///< being told that nobody leads it any more
  kLeft,
};

enum class DriveFailure : std::uint8_t {
  kNone,
  kSetupTimedOut,        ///< no SDO answer in all tries
  kSetupRefused,         ///< an SDO abort; see abort_code
  kSetupReadsDifferent,  ///< an object did not keep its value
  kStateTimedOut,        ///< did not follow towards Operation enabled
  kSetPointTimedOut,     ///< does not acknowledge set-points, or does not follow them
  kOutsideLimits,        ///< stands too far outside its limits, and may not be led back
  kNotHomed,             ///< does not know where its joint is, and may not find it out by itself
  kHomingFailed,         ///< did not find that out
  kDriveFault,           ///< its state is Fault
  kQuickStopped,         ///< it has stopped by itself: Quick stop active, which nobody here ordered
  kEmergency,            ///< it sent an emergency message
  kGone,                 ///< its heartbeat stays away
};

/// What is known of a drive, for the black box and the screen.
struct DriveReport {
  DrivePhase phase = DrivePhase::kOrdering;
  DriveFailure failure = DriveFailure::kNone;
  hal::cia402::State state = hal::cia402::State::kNotReadyToSwitchOn;
  hal::cia402::Object object;        ///< being set up, or that failed
  std::uint32_t abort_code = 0;      ///< of an SDO abort
  std::uint16_t emergency_code = 0;  ///< of the newest emergency message
  std::uint32_t boot_ups = 0;        ///< boot-up messages heard
  std::uint32_t quick_stops = 0;     ///< times that it was found in Quick stop active
};

/// Real-time safe. Positions are in 0.001 degree.
class Cia402Drive {
 public:
  Cia402Drive(CanopenMaster& master, std::uint8_t node, const DriveNumbers& numbers,
              const DriveTimeouts& timeouts) noexcept;

  void receive(const hal::CanFrame& frame) noexcept;
  void tick(Time now) noexcept;

  /// The next set-point, clamped to the limits; the newest wins. Nothing happens unless running.
  void aim(std::int32_t target) noexcept;
  /// Stops where it is, as long as `hold`; afterwards it stays there until aimed again.
  void hold(bool hold) noexcept;
  /// After a failure: reset the fault and begin anew.
  void recover() noexcept;
  /// Lets it stop quickly and hold, then no longer wait for our heartbeat. For good.
  void leave() noexcept;
  bool has_left() const noexcept { return report_.phase == DrivePhase::kLeft; }

  const DriveReport& report() const noexcept { return report_; }
  bool has_failed() const noexcept { return report_.phase == DrivePhase::kFailed; }
  /// Running, and told to stay where it is.
  bool is_ready() const noexcept;
  /// Status or position stayed away (judged at the last tick).
  bool is_silent() const noexcept { return silent_; }
  bool is_moving() const noexcept;
  std::int32_t position() const noexcept { return position_; }
  std::int32_t velocity() const noexcept { return velocity_; }
  /// None while it is not known that the drive knows where its joint is.
  std::optional<Time> position_stamp() const noexcept;
  /// The set-point last acknowledged or, in cyclic mode, the one the targets are on their way to; the
  /// position until there is one.
  std::int32_t accepted() const noexcept;

 private:
  void hear(const hal::bus::DriveStatus& status, Time stamp) noexcept;
  void hear(const hal::bus::DriveMotion& motion, Time stamp) noexcept;
  void hear(const hal::bus::Heartbeat& heartbeat, Time stamp) noexcept;
  void hear(const hal::bus::Emcy& emergency) noexcept;

  void begin() noexcept;
  void set_up_again() noexcept;
  void fail(DriveFailure why) noexcept;
  void order_pre_operational() noexcept;
  void set_up(Time now) noexcept;
  void enable(Time now) noexcept;
  void start_where_it_is(Time now) noexcept;
  void home(Time now) noexcept;
  void run(Time now) noexcept;
  void stand(Time now) noexcept;
  void part(Time now) noexcept;
  bool is_leaving() const noexcept;
  void tell_set_point(Time now) noexcept;
  hal::cia402::Command next_command(Time now) const noexcept;
  std::uint16_t reset_fault(Time now) noexcept;
  void follow_state(Time now) noexcept;
  bool say(std::uint16_t controlword, std::int32_t target, Time now) noexcept;
  std::int32_t present_target() const noexcept;
  std::int8_t mode_wanted() const noexcept;
  bool is_too_far_outside() const noexcept;
  bool knows_state(Time now) const noexcept;
  bool is_at_fault() const noexcept;
  bool is_quick_stopped() const noexcept;
  DriveSight sight() const noexcept { return {statusword_, position_, silent_}; }

  CanopenMaster& master_;
  std::uint8_t node_;
  DriveNumbers numbers_;
  DriveTimeouts timeouts_;
  DriveSetup setup_;
  SdoClient parting_;
  HeartbeatWatch heartbeat_;
  DriveReport report_;

  std::uint16_t statusword_ = 0;
  std::int8_t mode_ = 0;
  std::int32_t position_ = 0, velocity_ = 0;
  std::optional<Time> status_heard_, motion_heard_;
  bool silent_ = true, start_ordered_ = false;
  bool was_stopped_ = false;  ///< the newest status that was heard says Quick stop active

  std::optional<Time> state_since_;  ///< the drive has been in report_.state since
  bool was_enabled_ = false;         ///< by us: a fault or a quick stop after that is no old one
  int fault_resets_ = 0;
  std::optional<Time> fault_edge_;

  Homing homing_;
  bool held_ = false;
  std::variant<ProfileSetPoints, CyclicSetPoints> set_points_;
  bool led_ = false;  ///< it is told set-points

  std::optional<hal::bus::DriveCommand> said_;  ///< what the drive was last told
  Time said_at_{};
};

}  // namespace headway::drivers
