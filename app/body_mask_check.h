// Whether the true body stays inside the planner's masks: on the floor cells that were checked for the motion
// that is being walked.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "nav/masks.h"
#include "nav/planner.h"
#include "runtime/bus_loop.h"
#include "sim_hal/robot.h"

namespace headway::app {

/// The motion being walked is the one whose line passes nearest to the true body's axis, with those walked up
/// to three cells before and after it, on the paths that the step under way, the one before it and the newest
/// plan come from. Turning on the spot at a path's ends counts as motions of their own.
class BodyMaskCheck {
 public:
  static constexpr Duration kPeriod = seconds(0.02);  ///< between judgements

  BodyMaskCheck(const nav::BodyOutline& outline, const nav::FloorGrid& grid);

  /// The path of the plan that a frame's work ends in; it waits to be handed over.
  void plan(const nav::Path& path);
  /// After each bus cycle: whether the waiting plan was taken.
  void handed(Time now, const runtime::BusLoopCounters& counters);
  /// The true body, at this moment; `steps` have begun, the last one is under way or ended in rest.
  void judge(std::span<const runtime::StepRecord> steps, std::span<const sim::BodyBox> body);

  std::uint64_t samples() const { return samples_; }
  std::uint64_t outside() const { return outside_; }  ///< samples with a part of the body on other cells
  /// How far a part was from the nearest cell of its masks, at most [m]; 0 when all stayed inside.
  double farthest() const { return farthest_; }

 private:
  struct Taken {
    Time at{};
    std::shared_ptr<const nav::Path> path;
  };
  using Room = std::vector<Eigen::Vector2i>;  ///< cells, sorted

  std::vector<std::shared_ptr<const nav::Path>> walked(std::span<const runtime::StepRecord> steps) const;
  void add_motions(const nav::Path& path, const Eigen::Vector2d& body, Room& room) const;
  void add_turn(const Pose2& from, const Pose2& to, Room& room) const;
  double off(const Eigen::Vector2i& cell, const Room& room) const;

  nav::BodyOutline outline_;
  nav::FloorGrid grid_;
  nav::Masks masks_;
  std::shared_ptr<const nav::Path> waiting_;
  std::deque<Taken> taken_;
  runtime::BusLoopCounters last_{};
  std::uint64_t samples_ = 0, outside_ = 0;
  double farthest_ = 0;
};

}  // namespace headway::app
