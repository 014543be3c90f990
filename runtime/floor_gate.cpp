#include "runtime/floor_gate.h"

#include <algorithm>

#include "nav/low_ahead.h"

namespace headway::runtime {

Gate FloorGate::check(const nav::Walk& walk, std::size_t from, const nav::FloorMap& floor,
                      const Pose2& robot_now, Time now) const {
  Gate gate;
  const bool any_low = nav::any_low(floor);
  for (std::size_t step = from; step < walk.steps.size(); ++step) {
    check_step(walk, step, floor, robot_now, now, gate);
    if (any_low && trips(walk, step, floor)) gate.blocked = true;
    if (gate.blocked || !gate.missing.empty()) break;
    ++gate.open;
  }
  return gate;
}

void FloorGate::check_step(const nav::Walk& walk, std::size_t step, const nav::FloorMap& floor,
                           const Pose2& robot_now, Time now, Gate& gate) const {
  const auto near = [&](const Eigen::Vector2i& cell) {
    return (floor.grid.centre(cell) - robot_now.position()).norm() < config_.blind_radius;
  };
  const auto judge = [&](const Eigen::Vector2i& cell, bool under_sole) {
    const nav::Floor state = floor.at(cell);
    if (under_sole ? nav::is_occupied(state) : state == nav::Floor::kBlocked) gate.blocked = true;
    const Time seen = floor.seen(cell);
    const bool known = state != nav::Floor::kUnseen && seen != nav::kNever;
    const bool recent = known && now - seen <= config_.recent;
    if (near(cell) ? under_sole && !known : !recent) gate.missing.push_back(cell);
  };
  const hal::Footstep& footstep = walk.steps[step];
  for (const auto& cell : nav::sole_cells(floor.grid, gait_, walk.stances[step].at(footstep.foot)))
    judge(cell, true);
  for (const auto& cell : nav::body_cells(floor.grid, outline_.bare(), walk.bases[step])) judge(cell, false);
}

/// Whether a foot that goes no higher than usual goes over something low.
bool FloorGate::trips(const nav::Walk& walk, std::size_t step, const nav::FloorMap& floor) const {
  const hal::Footstep& footstep = walk.steps[step];
  const hal::Stance& before = step > 0 ? walk.stances[step - 1] : walk.from;
  return footstep.clear == 0 &&
         nav::passes_low(floor, gait_, before.at(footstep.foot), walk.stances[step].at(footstep.foot));
}

std::size_t FloorGate::clear_steps(const nav::Walk& walk, std::size_t from,
                                   const nav::FloorMap& floor) const {
  // Half the safety margin: a plan made with the whole of it is not thrown away for one more voxel.
  nav::BodyOutline outline = outline_;
  outline.safety_margin /= 2;
  const auto any = [&](const std::vector<Eigen::Vector2i>& cells, nav::Floor of) {
    return std::ranges::any_of(cells, [&](const Eigen::Vector2i& cell) { return floor.at(cell) == of; });
  };
  const bool any_low = nav::any_low(floor);
  for (std::size_t step = from; step < walk.steps.size(); ++step) {
    if (any(nav::body_cells(floor.grid, outline, walk.bases[step]), nav::Floor::kBlocked)) return step - from;
    const Pose2& sole = walk.stances[step].at(walk.steps[step].foot);
    if (any_low && (nav::is_on_low(floor, gait_, sole) || trips(walk, step, floor))) return step - from;
  }
  return walk.steps.size() - std::min(from, walk.steps.size());
}

bool FloorGate::clear(const nav::Walk& walk, std::size_t from, const nav::FloorMap& floor) const {
  return from + clear_steps(walk, from, floor) >= walk.steps.size();
}

bool FloorGate::hits(std::span<const Pose2> bases, const nav::FloorMap& floor) const {
  const nav::BodyOutline body = outline_.bare();
  for (const Pose2& base : bases)
    for (const auto& cell : nav::body_cells(floor.grid, body, base))
      if (floor.at(cell) == nav::Floor::kBlocked) return true;
  return false;
}

}  // namespace headway::runtime
