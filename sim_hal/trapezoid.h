// Time-optimal motion to a target with bounded velocity and acceleration, from any present velocity.
#pragma once

#include <array>
#include <cstddef>

namespace headway::sim {

/// Pieces of constant acceleration; any unit of length, seconds. Before the start and after the end it stands
/// still.
class Trapezoid {
 public:
  struct State {
    double position = 0, velocity = 0;
  };

  Trapezoid() = default;
  /// At rest.
  explicit Trapezoid(double position) : start_{position, 0}, end_(position) {}
  /// To `target`; limits are positive magnitudes.
  static Trapezoid move(State from, double target, double velocity, double acceleration, double deceleration);
  /// To a stand as soon as `deceleration` allows.
  static Trapezoid stop(State from, double deceleration);

  State at(double seconds) const;
  double duration() const;
  double end() const { return end_; }

 private:
  struct Piece {
    double duration = 0, acceleration = 0;
  };
  void add(double duration, double acceleration);
  State after_pieces() const;

  State start_;
  double end_ = 0;
  std::array<Piece, 4> pieces_{};
  std::size_t size_ = 0;
};

}  // namespace headway::sim
