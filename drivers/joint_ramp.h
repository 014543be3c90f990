// A joint's way to where it is to be, in steps of equal time, within a velocity and an acceleration; and
// where it is at times in between.
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
  /// One step on the way to `target`, or a part of one: speeds up, and brakes in time to end there exactly.
  /// Targets may change at any time, and count from the next whole step on; one that is too near to brake for
  /// is passed, and come back to. `part` is more than 0 and at most 1.
  void step_towards(double target, double part = 1) noexcept;
  /// One step of braking, or a part of one.
  void step_to_rest(double part = 1) noexcept;

  /// Within a step it moves evenly.
  double position() const noexcept { return end_ - (1 - part_) * velocity_; }
  double velocity() const noexcept { return velocity_; }

 private:
  bool goes_on(double part) noexcept;
  void move(double wanted_velocity) noexcept;

  double fastest_, change_;        ///< velocity and its change in a step, at most
  double end_ = 0, velocity_ = 0;  ///< of the step under way
  double part_ = 1;                ///< that has passed of it
};

}  // namespace headway::drivers
