// The head as two CANopen drives (CiA 402) for pan and tilt, on any hal::CanBus.
#pragma once

#include <cstdint>

#include "drivers/canopen_master.h"
#include "drivers/cia402_drive.h"
#include "hal/can_bus.h"
#include "hal/head.h"

namespace headway::drivers {

/// How drives are told where to go: profile position, where each makes its own way and a late order jerks
/// nothing, or cyclic synchronous position, a target with every SYNC.
enum class SetPointMode : std::uint8_t { kProfile, kCyclic };

/// What is done about drives that do not know where their joints are after power-on.
struct HomingConfig {
  enum class Policy : std::uint8_t {
    kNone,      ///< they know, by absolute sensors, and are not asked
    kRequired,  ///< they are asked; the head is not moved when one does not know (HeadHealth::kNotHomed)
    kMove,      ///< such a drive finds it out by itself: it moves, beyond the limits if its method wants that
  } policy = Policy::kNone;
  int method = 0;                               ///< object 0x6098, as the drive's manual tells; for kMove
  double search_speed = 0.1;                    ///< [rad/s]
  double zero_speed = 0.02;                     ///< [rad/s]
  double acceleration = 0.5;                    ///< [rad/s^2]
  Duration longest = std::chrono::seconds(60);  ///< that it may take
};

struct HeadConfig {
  std::uint8_t pan_node = 0x11, tilt_node = 0x12;  ///< as in config/can/headway.dbc
  hal::HeadLimits limits;
  SetPointMode set_points = SetPointMode::kProfile;
  /// A joint that stands outside its limits is led back; else it is refused. By profile only: cyclically it
  /// always is.
  bool may_come_inside = true;
  HomingConfig homing;
  double quick_stop_deceleration = 10;  ///< [rad/s^2]
  double following_error = 0.0873;      ///< the drive faults when it lags more than this [rad]...
  Duration following_error_time = std::chrono::milliseconds(100);  ///< ...for this long
  DriveTimeouts timeouts;

  /// Throws InputError when no drive could work with these.
  void validate() const;
};

/// Leads both drives to Operation enabled, keeps them there and hands them set-points. Real-time safe after
/// construction. A drive that boots up unexpectedly, or comes back after it was gone, is set up again and
/// first told to stay where it is; after a drive's own fault recover() is needed.
class Cia402Head final : public hal::Head {
 public:
  /// Throws InputError as HeadConfig::validate. The bus must outlive the head.
  Cia402Head(hal::CanBus& bus, const HeadConfig& config);

  void receive(const hal::CanFrame& frame) noexcept override;
  void tick(Time now) noexcept override;
  void command(const hal::HeadAngles& target) noexcept override;
  hal::HeadState state() const noexcept override { return state_; }

  /// After a fault: begin anew with both drives.
  void recover() noexcept override;

  /// At the end: both drives stop and hold, and wait for nobody. Takes some ticks, until has_left().
  void leave() noexcept;
  bool has_left() const noexcept { return pan_.has_left() && tilt_.has_left(); }

  const DriveReport& pan() const noexcept { return pan_.report(); }
  const DriveReport& tilt() const noexcept { return tilt_.report(); }

 private:
  hal::HeadHealth judge() const noexcept;
  void pair_positions() noexcept;

  CanopenMaster master_;
  Cia402Drive pan_, tilt_;
  hal::HeadState state_;
};

}  // namespace headway::drivers
