// From footsteps to motion: feet, centre of mass and yaw for every tick, by preview control of the ZMP.
//
// A step lasts from lift-off to the next lift-off: single support with the ZMP reference on the standing
// sole's centre, then double support with the reference moving on to the next sole (or, after the last step,
// to the middle between the feet). Before the first step the weight is shifted, for one
// window and a double support: the controller needs to see it coming. When the preview window comes to where
// the weight goes on to a step or to rest, that step has to be known (`known_after`), so what has been shown
// to the controller never changes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/footstep.h"
#include "nav/walking/preview_control.h"

namespace headway::nav {

struct WalkingConfig {
  /// The window may last two of the shortest steps less a double support, 1.5 s. What it lasts less a step
  /// may be known later, and the robot rests the sooner; with 0.3 s less the ZMP strays by 10 mm at most,
  /// not 3.
  PreviewConfig preview{.window = 1.2};
  double double_support = 0.10;  ///< at the end of each step [s]
  double swing_height = 0.07;    ///< of the foot in mid swing [m]
  double clearance = 0.03;       ///< above what the foot goes over [m]
  double shortest_step = 0.8;    ///< [s]
  double longest_step = 1.55;    ///< [s]
  /// Standing: the CoM is this near to the middle of the feet [m], and no faster than that [m/s]: 0.3 s after
  /// the longest steps. By then the ZMP is in the middle, and what is left dies out as exp(-3.5 t) by itself.
  double settled_distance = 0.025, settled_speed = 0.0875;

  /// After the lift-off of a step the one two after it has to be known [s]. The second step of a walk, as if
  /// one of the shortest came before the first.
  double known_after() const { return 2 * shortest_step - double_support - preview.window; }

  /// Throws InputError when a value makes no sense or the window is longer than two steps allow.
  void validate() const;
};

enum class Support : std::uint8_t { kLeft, kRight, kBoth };

/// A foot in the odometry frame; z = 0: its sole on the floor.
struct FootPose {
  Pose2 pose;
  double z = 0;  ///< [m]
};

/// Everything at one tick, in the odometry frame.
struct WalkingSample {
  Eigen::Vector2d com{0, 0}, com_velocity{0, 0}, com_acceleration{0, 0};  ///< [m, m/s, m/s^2]
  Eigen::Vector2d zmp{0, 0}, zmp_reference{0, 0};                         ///< of the model [m]
  FootPose left, right;
  double yaw = 0;  ///< mean of the feet [rad]
  Support support = Support::kBoth;
  std::uint32_t landed = 0;  ///< steps completed since construction

  const FootPose& at(hal::Foot f) const { return f == hal::Foot::kLeft ? left : right; }
};

/// Real-time safe after construction.
class WalkingPattern {
 public:
  static constexpr std::size_t kQueue = 8;  ///< steps that wait, besides the one under way

  enum class Phase : std::uint8_t {
    kStanding,  ///< at rest; pushed steps wait for begin()
    kWalking,   ///< shifting the weight, or stepping
    kSettling,  ///< the last step has landed, the CoM still moves
  };

  WalkingPattern(const WalkingConfig& config, const hal::Stance& start);
  /// As after construction, from another place.
  void stand_at(const hal::Stance& start) noexcept;

  /// Appends a step. False, and nothing done, when the queue is full, the duration is out of bounds, the foot
  /// swung last already, or the walk has been closed.
  bool push(const hal::Footstep& step) noexcept;
  /// Starts walking the steps there are; at most once per walk. No effect without steps or unless standing.
  void begin() noexcept;
  /// No further steps: walk what has been pushed, then rest. A walk also closes by itself when a step is not
  /// known that has to be.
  void close() noexcept { closed_ = true; }
  /// Closes, and forgets what need not be walked: all but the step under way and what had to be known by now
  /// (all, when standing).
  void abort() noexcept;
  /// Opens a new walk; only when standing and nothing waits.
  void reopen() noexcept;

  /// One period on.
  const WalkingSample& tick() noexcept;
  const WalkingSample& sample() const noexcept { return sample_; }

  Phase phase() const noexcept { return phase_; }
  bool closed() const noexcept { return closed_; }
  std::size_t queue_free() const noexcept;
  /// Steps of this walk that have started (0: none); the one under way has index started() - 1.
  std::uint32_t started() const noexcept { return started_; }
  std::uint32_t pushed() const noexcept { return pushed_; }
  /// The walk goes no further without another step: it has not one, or closes within the next period.
  bool wants_step() const noexcept { return pushed_ < needed(tick_in_step_ + 1); }
  /// Time until the step under way (with its first shift) ends; zero when none is.
  Duration phase_remaining() const noexcept;
  /// Where the feet will stand when all pushed steps have landed.
  const hal::Stance& planned_stance() const noexcept { return planned_; }
  const PreviewControl& control() const noexcept { return control_; }
  const WalkingConfig& config() const noexcept { return config_; }

 private:
  struct Step {
    hal::Foot foot = hal::Foot::kLeft;
    Pose2 lift, landing, support;  ///< odometry frame
    double lift_z = 0, landing_z = 0, support_z = 0;
    double clear = 0;
    int ticks = 0, single_ticks = 0;
  };
  static constexpr std::size_t kRing = 2 * kQueue;

  const Step& step(std::uint32_t index) const noexcept { return ring_[index % kRing]; }
  bool known(std::uint32_t index) const noexcept { return index < pushed_; }
  Eigen::Vector2d middle_after(std::uint32_t index) const noexcept;
  /// Steps that have to be known when the one under way has come so far.
  std::uint32_t needed(int tick) const noexcept;
  void plan_stance() noexcept;
  void start_step() noexcept;
  void advance_feet() noexcept;
  void land() noexcept;
  void swing(double share) noexcept;
  void swing_over(double share) noexcept;
  void write_ahead() noexcept;
  Eigen::Vector2d next_reference() noexcept;
  void settle() noexcept;
  void publish() noexcept;

  WalkingConfig config_;
  PreviewControl control_;
  std::array<Step, kRing> ring_{};
  hal::Stance planned_;
  double planned_left_z_ = 0, planned_right_z_ = 0;
  FootPose left_, right_;
  Phase phase_ = Phase::kStanding;
  bool closed_ = false;
  std::uint32_t pushed_ = 0, started_ = 0, landed_ = 0;
  int double_ticks_ = 0;
  int tick_in_step_ = 0;  ///< of the step under way; negative while the weight is shifted before the first
  Support support_ = Support::kBoth;

  // The reference of the coming periods, oldest at `oldest_`; kept twice, one window apart, so that it is
  // contiguous.
  std::vector<Eigen::Vector2d> window_;
  std::size_t window_ticks_ = 0;
  int shift_ticks_ = 0;  ///< from the order to walk to the first lift-off
  int known_by_ = 0;     ///< tick of a step at which the one two after it has to be known
  int shortest_ticks_ = 0;
  std::size_t oldest_ = 0;
  // What is written next at the far end of the window: tick `write_tick_` of step `write_step_`, or rest.
  bool writing_ = false;
  std::uint32_t write_step_ = 0;
  int write_tick_ = 0;
  Eigen::Vector2d rest_{0, 0};

  WalkingSample sample_;
};

}  // namespace headway::nav
