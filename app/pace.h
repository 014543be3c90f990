// Holds a simulation back to the time of the wall.
#pragma once

#include "hal/clock.h"

namespace headway::app {

class Pace {
 public:
  explicit Pace(hal::Clock& clock) : clock_(clock), since_(clock.now()) {}

  /// Waits until the wall's clock has come as far as the simulation, which is at `now`. Time that a slow
  /// machine has lost is not made up for. How fast the simulation ran of late: 1 is as fast as the wall.
  double keep(Time now) {
    constexpr Duration kWindow = seconds(2);
    if (!begun_) begin_ = now, begun_ = true;
    const Time due = since_ + (now - begin_);
    if (due > clock_.now())
      clock_.sleep_until(due);
    else if (clock_.now() - due > kSlack)
      lost_ = true;
    const Duration wall = clock_.now() - since_, simulated = now - begin_;
    if (wall >= kWindow || lost_) {
      speed_ = to_seconds(simulated) / to_seconds(wall);
      since_ = clock_.now();
      begin_ = now;
      lost_ = false;
    }
    return speed_;
  }

 private:
  static constexpr Duration kSlack = seconds(0.25);

  hal::Clock& clock_;
  Time since_{}, begin_{};
  bool begun_ = false, lost_ = false;
  double speed_ = 1;
};

}  // namespace headway::app
