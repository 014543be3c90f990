// The robot's own control computer as a node on the bus: takes footsteps, and orders that it makes into
// steps; walks them by preview control, reports its state and where it believes its chest to be. It believes
// what it was told: the odometry is the exact chain of the footsteps that it made; what really happens is in
// body.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "hal/bus_codec.h"
#include "hal/bus_protection.h"
#include "hal/can_bus.h"
#include "hal/walker.h"
#include "nav/walking/order_steps.h"
#include "nav/walking/walking_pattern.h"
#include "sim_hal/chest.h"

namespace headway::sim {

/// Landing of the swinging foot seen from the standing one. `side` is away from the standing foot.
struct StrideLimits {
  double forward = 0.255, backward = 0.15;           ///< [m]
  double nearest_side = 0.15, farthest_side = 0.26;  ///< [m]
  double yaw = 0.19;                                 ///< either way [rad]
  double dz = 0.0;                                   ///< either way [m]
  double clear = 0.10, forward_over = 0.46;          ///< what a step may go over, and how far ahead [m]

  bool allow(const hal::Footstep& step) const;
};

struct ControlComputerConfig {
  nav::WalkingConfig walking{};
  StrideLimits limits{};
  nav::GaitLimits gait{};  ///< of the steps that it makes of an order
  ChestConfig chest{};
  Duration control_lost = seconds(0.15);   ///< without WalkControl: smooth stop
  Duration status_period = seconds(0.02);  ///< WalkStatus, ChestXY, ChestZRot
  Duration time_period = seconds(1);       ///< Time

  void validate() const;
};

class ControlComputer final : public hal::BusNode {
 public:
  struct Counters {
    std::uint64_t unusable = 0;  ///< frames with a bad CRC or counter, or values not declared
    std::uint64_t accepted = 0;  ///< steps
    std::uint64_t rejected = 0;  ///< steps, repetitions counted
    std::uint64_t orders = 0;    ///< accepted
  };

  /// Feet at `start` in the odometry frame.
  ControlComputer(const ControlComputerConfig& config, const hal::Stance& start, hal::CanBus& bus,
                  Time power_on);

  void receive(const hal::CanFrame& frame) noexcept override;
  /// Once every 5 ms (the walking pattern's period).
  void tick(Time now) noexcept override;

  /// Drives off: reports kFault from now on and moves no more.
  void fail() noexcept;

  // Faults on demand.
  /// Refuses every step and order, as one that is not in a state to walk.
  void set_rejecting(bool rejecting) noexcept { rejecting_ = rejecting; }
  /// Its program ends, and begins anew after `boot`. Meanwhile it neither hears nor speaks. The joints are
  /// led by what lies below that program: they finish the steps under way and come to rest, as after a lost
  /// master; steps that have not begun from a stand are forgotten. The new program knows of no walk, counts
  /// time and frames from zero, and takes its odometry over from the joints.
  void restart(Duration boot) noexcept;
  /// Its clock says so much more from now on.
  void put_clock_forward(Duration by) noexcept { power_on_ -= by; }

  const nav::WalkingSample& walking() const noexcept { return pattern_.sample(); }
  const nav::WalkingPattern& pattern() const noexcept { return pattern_; }
  /// Where it believes the chest to be (what travels in ChestXY and ChestZRot).
  Eigen::Isometry3d odom_from_chest() const noexcept;
  /// What it reports in WalkStatus.
  hal::WalkStatus status() const noexcept;
  const Counters& counters() const noexcept { return counters_; }

 private:
  void take_step(const hal::CanFrame& frame) noexcept;
  void take_order(const hal::CanFrame& frame) noexcept;
  void take_control(const hal::CanFrame& frame) noexcept;
  hal::StepReject judge(std::uint8_t session, std::uint8_t seq) const noexcept;
  bool push(const hal::Footstep& step) noexcept;
  void release(std::uint8_t last_seq) noexcept;
  bool repeats_accepted(std::uint8_t seq) const noexcept;
  void reject(std::uint8_t seq, hal::StepReject reason) noexcept;
  void open_session(std::uint8_t session) noexcept;
  void stop() noexcept;
  void watch() noexcept;
  void report_walk() noexcept;
  void report_chest() noexcept;
  void report_time() noexcept;
  template <class Message>
  void send(const Message& message, hal::bus::Protector& protector) noexcept;

  ControlComputerConfig config_;
  hal::CanBus& bus_;
  nav::WalkingPattern pattern_;
  Time power_on_{}, now_{};
  bool failed_ = false, rejecting_ = false;
  Time up_at_{};  ///< neither hears nor speaks before
  std::uint8_t session_ = 0;
  std::uint32_t accepted_ = 0;          ///< steps of this session
  std::optional<hal::Foot> last_foot_;  ///< of the newest one accepted
  nav::OrderSteps order_;               ///< the newest order, and how many of its steps are accepted
  std::size_t order_done_ = 0;
  bool stop_asked_ = false;
  Time control_heard_{};
  std::uint8_t rejected_ = 0;
  hal::StepReject reject_reason_ = hal::StepReject::kNone;
  hal::bus::ProtectionChecker step_check_, order_check_, control_check_;
  hal::bus::Protector status_out_, chest_xy_out_, chest_zrot_out_, time_out_;
  std::uint8_t sample_ = 0;
  Time next_status_{}, next_time_{};
  Counters counters_;
};

}  // namespace headway::sim
