// A joint of the head as a CiA 402 drive on a CANopen network (CiA 301), written from the standards and
// independent of the master in drivers/: NMT slave, SDO server (expedited), heartbeat producer and consumer,
// PDOs with a mapping that must be set up, power state machine, profile position. Angles positive as in
// hal::HeadAngles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/can_bus.h"
#include "sim_hal/object_dictionary.h"
#include "sim_hal/trapezoid.h"

namespace headway::sim {

struct HeadDriveConfig {
  std::uint8_t node = 0x11;
  double start_angle = 0;              ///< [rad]
  double lag = 0.008;                  ///< time constant with which the joint follows the drive's profile [s]
  Duration boot_time = seconds(0.05);  ///< from power-on or reset to the boot-up message

  void validate() const;
};

/// CiA 301 states, as in the heartbeat.
enum class NmtState : std::uint8_t {
  kInitialising = 0,
  kStopped = 4,
  kOperational = 5,
  kPreOperational = 127
};

/// CiA 402 power states.
enum class PowerState : std::uint8_t {
  kNotReadyToSwitchOn,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReactionActive,
  kFault,
};

class HeadDrive final : public hal::BusNode {
 public:
  /// `bus` outlives the drive. Position unit on the wire 0.001 deg.
  HeadDrive(const HeadDriveConfig& config, hal::CanBus& bus, Time power_on);

  /// Moves the joint to the frame's stamp, then answers it.
  void receive(const hal::CanFrame& frame) noexcept override;
  /// Moves the joint to `now`; heartbeats and watchdogs.
  void tick(Time now) noexcept override;

  /// The true joint angle [rad] and velocity [rad/s] at the last tick.
  double angle() const { return actual_; }
  double velocity() const { return actual_velocity_; }
  NmtState nmt_state() const { return nmt_; }
  PowerState power_state() const { return power_; }
  std::uint16_t status_word() const;

  // Faults on demand.
  void set_stalled(bool stalled) {
    stalled_ = stalled;
  }                        ///< the joint stays where it is, whatever the drive does
  void reboot() noexcept;  ///< power lost and back: set-up forgotten, boot-up again
  void set_silent(bool silent) { silent_ = silent; }  ///< neither hears nor speaks

 private:
  // Network (head_drive_network.cpp).
  void boot() noexcept;
  void handle_nmt(const hal::CanFrame& frame) noexcept;
  void handle_sdo(const hal::CanFrame& frame) noexcept;
  void sdo_download(const hal::CanFrame& frame) noexcept;
  void sdo_upload(std::uint16_t index, std::uint8_t sub) noexcept;
  void sdo_abort(std::uint16_t index, std::uint8_t sub, std::uint32_t code) noexcept;
  void handle_receive_pdo(const hal::CanFrame& frame) noexcept;
  void handle_sync() noexcept;
  void send_transmit_pdo(int which) noexcept;
  void heartbeats(Time now) noexcept;
  void lose_heartbeat() noexcept;
  void send(std::uint32_t id, const std::uint8_t* data, std::uint8_t size) noexcept;
  void send_emergency(std::uint16_t code) noexcept;
  void set_nmt(NmtState state) noexcept;

  // Objects with a meaning beyond their value.
  void refresh_objects() noexcept;  ///< statusword, position and the like, before they are read
  void object_written(std::uint16_t index, std::uint8_t sub) noexcept;

  // Drive (head_drive.cpp).
  void move_to(Time now) noexcept;
  void obey(std::uint16_t control_word) noexcept;
  void set_point(std::uint16_t control_word) noexcept;
  void start_motion(std::int32_t target) noexcept;
  void stop_motion(std::uint32_t deceleration) noexcept;
  void enter(PowerState state) noexcept;
  void raise_fault(std::uint16_t code, std::uint8_t error_register) noexcept;
  void watch_following_error(Duration passed) noexcept;
  void watch_target(Duration passed) noexcept;
  void abort_connection() noexcept;

  HeadDriveConfig config_;
  hal::CanBus& bus_;
  ObjectDictionary objects_;
  Time now_{};
  NmtState nmt_ = NmtState::kInitialising;
  PowerState power_ = PowerState::kNotReadyToSwitchOn;
  Time boots_at_{}, next_heartbeat_{};
  std::optional<Time> master_heard_;  ///< last heartbeat of the node that is watched
  bool heartbeat_lost_ = false;
  std::array<std::uint8_t, 2> sync_count_{};

  Trapezoid profile_;  ///< demand [0.001 deg], time from `profile_start_`
  Time profile_start_{};
  double demand_ = 0, demand_velocity_ = 0;  ///< [rad, rad/s]
  double actual_ = 0, actual_velocity_ = 0;
  std::uint16_t control_word_ = 0;
  bool set_point_acknowledged_ = false, limited_ = false, target_reached_ = true, following_error_ = false;
  std::optional<std::int32_t> queued_target_;
  Duration error_for_{}, reached_for_{};
  std::uint8_t error_register_ = 0;
  std::uint16_t error_code_ = 0;
  bool stalled_ = false, silent_ = false;
};

}  // namespace headway::sim
