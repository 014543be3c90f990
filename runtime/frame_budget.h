// How much is done with each frame: as much as there is time for. What is left out, and in which order.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "hal/time.h"
#include "runtime/stage_times.h"

namespace headway::runtime {

/// Each level leaves out what those before it do, and more. The newest frame is worked on at all of them.
enum class FrameLevel : std::uint8_t {
  kFull,
  kEveryOther,      ///< only every other frame: each has the time of two
  kHalfResolution,  ///< of the images that are matched: a quarter of the work, half as precise
  kNear,            ///< nothing is taken in from farther away than the next steps need
};
inline constexpr std::size_t kFrameLevels = 4;

constexpr const char* name(FrameLevel level) {
  constexpr std::array kNames{"full", "every other", "half resolution", "near"};
  return kNames[static_cast<std::size_t>(level)];
}

struct FrameBudgetConfig {
  Duration period = seconds(0.1);  ///< of the camera
  int late = 3;       ///< frames in a row that take longer than there is time, before one level is given up
  double room = 0.8;  ///< share of the time at the better level that work must do with before it is tried
  int calm = 30;      ///< frames in a row that do
  int longest_calm = 1920;  ///< twice as many each time that trying was in vain, up to this
};

/// One level worse when work is late, one better when there is room again. A better level that is late at
/// once is tried more and more seldom, so that a computer that is too slow does not swing between two levels.
/// A plain value.
class FrameBudget {
 public:
  explicit FrameBudget(const FrameBudgetConfig& config = {}) : config_(config), calm_(config.calm) {}

  FrameLevel level() const { return level_; }
  /// For work that is done again as it was done once.
  void fix(FrameLevel level) { level_ = level; }
  /// What there is for a frame.
  Duration time() const { return time_at(level_); }
  /// A frame that follows the last one worked on so soon is left out.
  bool leaves_out(Duration after_last) const {
    return level_ != FrameLevel::kFull && after_last < config_.period + config_.period / 2;
  }

  /// The work on a frame took so long. True when that was too long.
  bool took(Duration work) {
    const bool late = work > time();
    late_ = late ? late_ + 1 : 0;
    quiet_ = work <= room_to_rise() ? quiet_ + 1 : 0;
    if (trial_ > 0 && --trial_ == 0) calm_ = config_.calm;  // the better level holds
    if (late_ >= config_.late && level_ != worst()) {
      if (trial_ > 0) calm_ = std::min(2 * calm_, config_.longest_calm);
      trial_ = 0;
      move(+1);
    } else if (quiet_ >= calm_ && level_ != FrameLevel::kFull) {
      trial_ = 2 * calm_;
      move(-1);
    }
    return late;
  }

 private:
  static constexpr FrameLevel worst() { return static_cast<FrameLevel>(kFrameLevels - 1); }
  Duration time_at(FrameLevel level) const {
    return level == FrameLevel::kFull ? config_.period : 2 * config_.period;
  }
  Duration room_to_rise() const {
    const FrameLevel better = level_ <= FrameLevel::kEveryOther ? FrameLevel::kFull : FrameLevel::kEveryOther;
    return seconds(to_seconds(time_at(better)) * config_.room);
  }
  void move(int levels) {
    level_ = static_cast<FrameLevel>(static_cast<int>(level_) + levels);
    late_ = quiet_ = 0;
  }

  FrameBudgetConfig config_;
  FrameLevel level_ = FrameLevel::kFull;
  int late_ = 0, quiet_ = 0;  ///< frames in a row
  int calm_ = 0;              ///< as many must be, at the moment
  int trial_ = 0;             ///< frames until a better level is taken to hold
};

/// What stages that take so long at full effort would take at a level, in simulation.
inline StageTimes at_level(StageTimes times, FrameLevel level) {
  if (level >= FrameLevel::kHalfResolution) times.see /= 4;
  if (level >= FrameLevel::kNear) times.map /= 2, times.floor /= 2;
  return times;
}

}  // namespace headway::runtime
