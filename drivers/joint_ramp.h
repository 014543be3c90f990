// A joint's way to where it is to be, in steps of equal time, within a velocity and an acceleration.
#pragma once

namespace headway::drivers {

/// Any unit of length; velocities are per step. Real-time safe.
class JointRamp {
 public:
  struct Limits {
    double velocity = 0, acceleration = 0;  ///< magnitudes, per second and per second squared
    double period = 0.02;                   ///< of one step [s]
  };

  explicit JointRamp(const Limits& limits) noexcept;

  /// At rest there.
  void stand(double position) noexcept;
  /// One step on the way to `target`: speeds up, and brakes in time to end there exactly. Targets may change
  /// at any time; one that is too near to brake for is passed, and come back to.
  void step_towards(double target) noexcept;
  /// One step of braking.
  void step_to_rest() noexcept;

  double position() const noexcept { return position_; }
  double velocity() const noexcept { return velocity_; }

 private:
  void move(double wanted_velocity) noexcept;

  double fastest_, change_;  ///< velocity and its change in a step, at most
  double position_ = 0, velocity_ = 0;
};

}  // namespace headway::drivers
