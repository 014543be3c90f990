// A mission on reports of the bus that are made by hand, over a floor that is seen from above.
#pragma once

#include <algorithm>
#include <optional>
#include <string>

#include "runtime/mission.h"
#include "tests/runtime/flat_room.h"

namespace headway::runtime {

using Walk = MotionOrder::Walk;

inline const nav::Goal kAhead{{3, 0}, std::nullopt};

inline MissionConfig hand_made() {
  MissionConfig config;
  config.neck.chest_from_pan.translation().z() = 0.4;
  config.neck.tilt_from_camera.linear() = hal::body_from_optical();
  config.viewpoints = {{0, 0.5}, {0.6, 0.5}, {-0.6, 0.5}};
  return config;
}

/// A mission, a map that is looked at from above, and a head that is always where it should be.
struct Bench {
  explicit Bench(const MissionConfig& config = hand_made())
      : mission_config(config), mission(config, mapper.floor().grid) {
    bus.head.health = hal::HeadHealth::kReady;
    bus.walker = hal::WalkerHealth::kReady;
    bus.committed.session = 1;
    bus.committed.stance = hal::Stance::parallel({}, config.gait.feet_apart);
  }

  /// So many frames, a tenth of a second each.
  void frames(int count) {
    for (int i = 0; i < count; ++i) {
      now += seconds(0.1);
      if (blind.empty()) {
        mapper.integrate(look(boxes, from_above(eye, 4.5)), from_above(eye, 4.5), chest(), now);
        mapper.project();
        last_look = now;
      }
      order = mission.update({now, last_look, blind, faulty, placed, order.look, chest(), bus, mapper});
    }
  }
  Eigen::Isometry3d chest() const { return bus.committed.stance.base().lifted(1); }
  /// Up to the first order to walk, or the end.
  void until_walking(const nav::Goal& goal) {
    mission.set_goal(goal);
    for (int i = 0; i < 60 && order.walk != Walk::kPlan && !mission.over(); ++i) frames(1);
  }
  void until_over() {
    for (int i = 0; i < 600 && !mission.over(); ++i) frames(1);
  }
  /// The bus loop commits a step, which may be part of an order.
  void commit(const hal::Footstep& step, std::optional<hal::PartOfOrder> part = std::nullopt) {
    nav::Committed& c = bus.committed;
    c.stance = c.stance.after(step);
    c.last_foot = step.foot;
    c.part = part;
    c.newest[c.next_index++ % nav::Committed::kKept] = {step, c.stance, part};
    c.at_rest = false;
  }
  /// The bus loop commits the next steps of the plan that it was given.
  void commit(int steps) {
    for (int i = 0; i < steps; ++i) {
      const auto at = static_cast<std::size_t>(i);
      commit(order.plan.steps[at],
             order.plan.in_orders ? std::optional(order.plan.orders[at]) : std::nullopt);
    }
  }
  /// The walk ends where it is, and the bus loop opens the next.
  void end_session(nav::StackStop why, std::uint32_t walked,
                   hal::StepReject reject = hal::StepReject::kNone) {
    bus.last_stop = why;
    bus.last_reject = reject;
    bus.last_steps = walked;
    ++bus.committed.session;
    bus.committed.next_index = 0;
    bus.committed.last_foot.reset();
    bus.committed.part.reset();
    bus.committed.stopping = false;
    bus.committed.at_rest = true;
  }
  /// Walks to the end of the plan.
  void walk_all() {
    for (int i = 0; i < 100 && !mission.over(); ++i) {
      const int left = order.walk == Walk::kPlan ? order.plan.count : 0;
      commit(std::min(left, 1));
      if (left <= 1 && !bus.committed.at_rest) end_session(nav::StackStop::kNone, 1);
      frames(1);
    }
  }

  Boxes boxes;
  Eigen::Vector2d eye{1.7, 0};
  Mapper mapper{small_map(), {}};
  MissionConfig mission_config;
  Mission mission;
  BusReport bus;
  MotionOrder order;
  std::string blind;
  bool faulty = false, placed = true;
  Time now{}, last_look = nav::kNever;
};

}  // namespace headway::runtime
