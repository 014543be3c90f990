// Frames on their way from the sensor to the computer, in the order in which they were taken.
#pragma once

#include <algorithm>
#include <cstddef>
#include <deque>
#include <utility>

#include "hal/time.h"

namespace headway::sim {

/// Holds each frame back until it has arrived. None overtakes another: a late one holds up those behind it.
template <class Frame>
class Transfer {
 public:
  void put(Time exposure, Duration takes, Frame frame) {
    drop_superseded(exposure);
    const Time behind = frames_.empty() ? exposure : frames_.back().first;
    frames_.emplace_back(std::max(exposure + takes, behind), std::move(frame));
  }

  /// Moves the newest frame that has arrived by `now` into `into` and drops those before it.
  bool take_newest(Time now, Frame& into) {
    drop_superseded(now);
    if (frames_.empty() || frames_.front().first > now) return false;
    into = std::move(frames_.front().second);
    frames_.pop_front();
    return true;
  }

 private:
  /// Of those that have arrived, all but the newest: nobody will want them.
  void drop_superseded(Time now) {
    while (frames_.size() > 1 && frames_[1].first <= now) frames_.pop_front();
  }

  std::deque<std::pair<Time, Frame>> frames_;
};

}  // namespace headway::sim
