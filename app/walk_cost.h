// What a walk costs while it goes on: the map's memory, and the longest work on a frame, every so many
// metres.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/report.h"
#include "runtime/frame_loop.h"

namespace headway::app {

/// A stretch of the way, at its end.
struct WalkStretch {
  double walked = 0;             ///< since the start [m]
  std::size_t window_bytes = 0;  ///< of the map around the robot
  std::size_t aside_bytes = 0;   ///< of what lies outside of it
  std::size_t aside_bricks = 0;  ///< seen there
  double resident_mib = 0;       ///< memory of the whole program
  Duration worst_frame{};        ///< the longest work on one of the stretch's frames
};

class WalkCost {
 public:
  explicit WalkCost(double stretch = 10) : stretch_(stretch) {}

  /// After each frame's work; `walked` since the start [m].
  void note(const runtime::FrameSnapshot& snapshot, double walked);

  const std::vector<WalkStretch>& stretches() const { return stretches_; }

 private:
  double stretch_;  ///< [m]
  Duration worst_{};
  std::vector<WalkStretch> stretches_;
};

Json walk_cost_report(const std::vector<WalkStretch>& stretches);
/// A line per stretch; empty without one.
std::string walk_cost_table(const std::vector<WalkStretch>& stretches);

}  // namespace headway::app
