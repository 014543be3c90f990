#include "nav/walk_orders.h"

#include <cmath>
#include <utility>

#include "nav/path_legs.h"
#include "nav/walking/order_steps.h"

namespace headway::nav {

namespace {

using Kind = hal::WalkOrder::Kind;

constexpr double kThere = 0.005;      // so near to the end of a leg nothing is left to walk [m]
constexpr double kYawSlack = 1.5e-3;  // rounding of the wire [rad]
constexpr std::size_t kTooMany = 20000;

class Orders {
 public:
  Orders(const hal::Stance& from, std::optional<hal::Foot> last_foot, const GaitLimits& gait)
      : gait_(gait), stance_(from), last_foot_(last_foot) {
    walk_.from = from;
  }

  Walk take() { return std::move(walk_); }
  Pose2 base() const { return gait_base(stance_, last_foot_, gait_); }

  bool follow(const Leg& leg) {
    if (std::abs(wrap_angle(leg.yaw - base().yaw)) > gait_.yaw && !turn_to(leg.yaw)) return false;
    return go_to({leg.to.x(), leg.to.y(), leg.yaw});
  }

  bool go_to(const Pose2& end) {
    while ((end.position() - base().position()).norm() > kThere) {
      const Pose2 way = base().inverse() * end;
      if (!give_some({Kind::kStraightWithTurn, way.x, way.y, way.yaw})) return false;
    }
    return true;
  }

  bool turn_to(double yaw) {
    while (std::abs(wrap_angle(yaw - base().yaw)) > kYawSlack)
      if (!give_some({Kind::kArc, 0, 0, wrap_angle(yaw - base().yaw)})) return false;
    return true;
  }

  void close() {
    while (!parallel() && give({Kind::kNextStep, 0, 0, 0})) {
    }
  }

 private:
  bool parallel() const {
    const Pose2 apart = stance_.right.inverse() * stance_.left;
    return std::hypot(apart.x, apart.y - gait_.feet_apart) < 1e-6 && std::abs(apart.yaw) < 1e-6;
  }

  /// An order, or as large a part of it as can be given.
  bool give_some(const hal::WalkOrder& order) {
    for (double share = 1; share > 0.01; share /= 2) {
      const double way = order.kind == Kind::kArc ? 1 : share;  // an arc's centre stays
      if (give({order.kind, way * order.x, way * order.y, share * order.turn})) return true;
    }
    return false;
  }

  bool give(const hal::WalkOrder& asked) {
    const hal::WalkOrder order = hal::quantised(asked);
    const auto steps = steps_of(order, stance_, last_foot_, gait_);
    if (!steps || walk_.steps.size() > kTooMany) return false;
    for (const hal::Footstep& step : steps->all()) {
      walk_.orders.push_back({order, static_cast<std::uint8_t>(&step - steps->all().data())});
      stance_ = stance_.after(step);
      last_foot_ = step.foot;
      walk_.add(step, stance_, base());
    }
    return true;
  }

  GaitLimits gait_;
  hal::Stance stance_;
  std::optional<hal::Foot> last_foot_;
  Walk walk_;
};

}  // namespace

Walk give_orders(const Path& path, const hal::Stance& from, std::optional<hal::Foot> last_foot,
                 const FloorGrid& grid, const GaitLimits& gait) {
  Orders orders(from, last_foot, gait);
  bool on = true;
  for (const Leg& leg : legs_of(path, grid)) on = on && orders.follow(leg);
  if (on && !path.states.empty()) on = orders.go_to({path.end.x(), path.end.y(), orders.base().yaw});
  if (on && path.end_yaw) on = orders.turn_to(*path.end_yaw);
  if (on) orders.close();
  return orders.take();
}

}  // namespace headway::nav
