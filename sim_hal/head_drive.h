// A joint of the head as a CiA 402 drive on a CANopen network (CiA 301), written from the standards and
// independent of the master in drivers/: NMT slave, SDO server (expedited), heartbeat producer and consumer,
// PDOs with a mapping that must be set up, power state machine, profile and cyclic synchronous position,
// homing. Angles positive as in hal::HeadAngles.
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
  bool homed = true;                   ///< else it takes for zero where it is switched on, until it is homed
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
  double angle() const;
  double velocity() const;
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
  // On the network (head_drive_network.cpp).
  void boot() noexcept;
  void reset_communication() noexcept;
  void obey_network(const hal::CanFrame& frame) noexcept;
  void answer_sdo(const hal::CanFrame& frame) noexcept;
  void sdo_download(const hal::CanFrame& frame) noexcept;
  void sdo_upload(const hal::CanFrame& frame) noexcept;
  void answer(std::uint8_t command, const hal::CanFrame& request, std::uint32_t data) noexcept;
  void object_written(std::uint16_t index) noexcept;
  void take_receive_pdo(const hal::CanFrame& frame) noexcept;
  void transmit_on_sync() noexcept;
  void transmit_on_change() noexcept;
  hal::CanFrame transmit_pdo(std::size_t which) noexcept;
  void refresh_objects() noexcept;
  void produce_heartbeat() noexcept;
  void watch_master() noexcept;
  void send_emergency(std::uint16_t code) noexcept;
  void send(const hal::CanFrame& frame) noexcept;

  // The drive itself (head_drive.cpp). Positions in 0.001 deg, as the objects.
  void move_to(Time now) noexcept;
  void move_joint(double seconds) noexcept;
  void obey(std::uint16_t control_word) noexcept;
  void change_power(std::uint16_t control_word) noexcept;
  void take_set_point(std::uint16_t control_word) noexcept;
  void take_cyclic_target() noexcept;
  void start_motion(std::int64_t target) noexcept;
  std::int64_t limited(std::int64_t target) noexcept;
  bool is_cyclic() const;
  bool is_homing_mode() const;
  void take_homing_order(std::uint16_t control_word) noexcept;
  void finish_homing() noexcept;
  void stop_motion(std::uint16_t deceleration_object) noexcept;
  void quick_stop() noexcept;
  void enter(PowerState state) noexcept;
  void raise_fault(std::uint16_t code, std::uint8_t error_register) noexcept;
  void abort_connection() noexcept;
  void finish_stops() noexcept;
  void watch_following_error(double seconds) noexcept;
  void watch_target(double seconds) noexcept;
  bool has_torque() const;
  bool moving() const;

  HeadDriveConfig config_;
  hal::CanBus& bus_;
  ObjectDictionary objects_;
  Time now_{};
  bool stalled_ = false, silent_ = false;

  NmtState nmt_ = NmtState::kInitialising;
  Time boots_at_{}, next_heartbeat_{};
  std::optional<Time> master_heard_;
  bool master_lost_ = false;
  std::array<int, 2> syncs_{};
  std::optional<hal::CanFrame> waits_for_sync_;  ///< a synchronous RPDO
  std::array<hal::CanFrame, 2> last_sent_{};

  PowerState power_ = PowerState::kNotReadyToSwitchOn;
  std::uint16_t control_word_ = 0;
  Trapezoid profile_;
  Time profile_start_{};
  double cyclic_from_ = 0;  ///< where the demand was when the last cyclic target came
  double demand_ = 0, demand_velocity_ = 0, actual_ = 0, actual_velocity_ = 0;
  double datum_ = 0;  ///< true position where it reads zero
  bool homed_ = true, homing_ = false;
  std::int64_t target_ = 0;
  std::optional<std::int64_t> next_target_;
  bool acknowledged_ = false, limited_ = false, halted_ = false;
  double far_for_ = 0,
         reached_for_ = 0;  ///< how long the joint is too far from its demand, near its target [s]
  std::uint8_t error_register_ = 0;
  std::uint16_t error_code_ = 0;
};

}  // namespace headway::sim
