#include "sim_hal/trapezoid.h"

#include <algorithm>
#include <cmath>

namespace headway::sim {
namespace {

Trapezoid::State after(Trapezoid::State s, double duration, double acceleration) {
  return {s.position + s.velocity * duration + acceleration * duration * duration / 2,
          s.velocity + acceleration * duration};
}

}  // namespace

void Trapezoid::add(double duration, double acceleration) {
  if (duration > 0) pieces_[size_++] = {duration, acceleration};
}

Trapezoid::State Trapezoid::after_pieces() const {
  State s = start_;
  for (std::size_t i = 0; i < size_; ++i) s = after(s, pieces_[i].duration, pieces_[i].acceleration);
  return s;
}

Trapezoid Trapezoid::stop(State from, double deceleration) {
  Trapezoid t;
  t.start_ = from;
  t.add(std::abs(from.velocity) / deceleration, from.velocity > 0 ? -deceleration : deceleration);
  t.end_ = t.after_pieces().position;
  return t;
}

Trapezoid Trapezoid::move(State from, double target, double velocity, double acceleration,
                          double deceleration) {
  Trapezoid t;
  t.start_ = from;
  t.end_ = target;
  // A motion that leads away, or past the target however hard it brakes, comes to a stand first.
  const double stands_at = from.position + from.velocity * std::abs(from.velocity) / (2 * deceleration);
  const bool brakes_first =
      (target - from.position) * from.velocity < 0 || (stands_at - target) * from.velocity > 0;
  if (brakes_first)
    t.add(std::abs(from.velocity) / deceleration, from.velocity > 0 ? -deceleration : deceleration);

  const State now = t.after_pieces();
  const double way = target - now.position, sign = way < 0 ? -1 : 1;
  const double v0 = std::abs(now.velocity), distance = std::abs(way);
  // The speed at which speeding up turns into braking, were there no limit.
  const double peak = std::sqrt((2 * distance * acceleration * deceleration + v0 * v0 * deceleration) /
                                (acceleration + deceleration));
  const double top = std::min(velocity, std::max(peak, v0));
  if (v0 <= velocity) {
    t.add((top - v0) / acceleration, sign * acceleration);
  } else {
    t.add((v0 - top) / deceleration, -sign * deceleration);
  }
  const double speeding =
      std::abs(top * top - v0 * v0) / (2 * (v0 <= velocity ? acceleration : deceleration));
  const double braking = top * top / (2 * deceleration);
  if (top > 0) t.add((distance - speeding - braking) / top, 0);
  t.add(top / deceleration, -sign * deceleration);
  return t;
}

Trapezoid::State Trapezoid::at(double seconds) const {
  if (seconds <= 0 && size_ > 0) return start_;
  State s = start_;
  for (std::size_t i = 0; i < size_; ++i) {
    const Piece& piece = pieces_[i];
    if (seconds < piece.duration) return after(s, seconds, piece.acceleration);
    s = after(s, piece.duration, piece.acceleration);
    seconds -= piece.duration;
  }
  return {end_, 0};
}

double Trapezoid::duration() const {
  double sum = 0;
  for (std::size_t i = 0; i < size_; ++i) sum += pieces_[i].duration;
  return sum;
}

}  // namespace headway::sim
