// Frames on their way from the sensor to the computer.
#pragma once

#include <cstddef>
#include <deque>
#include <utility>

#include "hal/time.h"

namespace headway::sim {

/// Holds each frame back until it has arrived; like a driver's buffers, it keeps only the newest few.
template <class Frame>
class Transfer {
 public:
  void put(Time arrival, Frame frame) {
    if (frames_.size() == kMost) frames_.pop_front();
    frames_.emplace_back(arrival, std::move(frame));
  }

  /// Moves the newest frame that has arrived by `now` into `into` and drops those before it.
  bool take_newest(Time now, Frame& into) {
    bool any = false;
    while (!frames_.empty() && frames_.front().first <= now) {
      into = std::move(frames_.front().second);
      frames_.pop_front();
      any = true;
    }
    return any;
  }

 private:
  static constexpr std::size_t kMost = 8;
  std::deque<std::pair<Time, Frame>> frames_;
};

}  // namespace headway::sim
