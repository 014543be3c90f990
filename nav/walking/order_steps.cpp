#include "nav/walking/order_steps.h"

#include <cmath>

namespace headway::nav {

namespace {

using Kind = hal::WalkOrder::Kind;

class Expansion {
 public:
  Expansion(const hal::WalkOrder& order, const hal::Stance& from, const Pose2& base, hal::Foot first,
            const GaitLimits& gait) noexcept
      : order_(order), from_(from), base_(base), first_(first), gait_(gait) {}

  /// False when one of the steps would not keep the limits.
  bool in(std::size_t count, OrderSteps& out) const noexcept {
    hal::Stance stance = from_;
    hal::Foot foot = first_;
    const std::size_t leading = leading_steps(count);
    if (needs_side() && leading == 0) return false;
    for (std::size_t i = 1; i <= count; ++i, foot = hal::other(foot)) {
      const double share = part(i, count), aside = needs_side() ? part(leading_steps(i), leading) : share;
      const Pose2 landing = base_ * way(share, aside) * Pose2{0, side(foot) * gait_.feet_apart / 2, 0};
      const hal::Footstep step =
          hal::quantised({foot, stance.at(hal::other(foot)).inverse() * landing, 0, gait_.step_duration});
      if (!within_limits(step, gait_)) return false;
      stance = stance.after(step);
      out.steps[i - 1] = step;
    }
    out.count = count;
    return true;
  }

 private:
  static double side(hal::Foot foot) noexcept { return foot == hal::Foot::kLeft ? 1 : -1; }
  static double part(std::size_t i, std::size_t n) noexcept {
    return static_cast<double>(i) / static_cast<double>(n);
  }
  bool needs_side() const noexcept { return order_.kind == Kind::kStraightWithTurn && order_.y != 0; }
  /// Of the first `count` steps, those of the foot on the side that the order goes to.
  std::size_t leading_steps(std::size_t count) const noexcept {
    return side(first_) * order_.y > 0 ? (count + 1) / 2 : count / 2;
  }
  /// Where the base is after that share of the order, seen from where it began.
  Pose2 way(double share, double aside) const noexcept {
    const double turn = share * order_.turn;
    if (order_.kind != Kind::kArc) return {share * order_.x, aside * order_.y, turn};
    return Pose2{order_.x, order_.y, turn} * Pose2{-order_.x, -order_.y, 0};
  }

  const hal::WalkOrder& order_;
  const hal::Stance& from_;
  Pose2 base_;
  hal::Foot first_;
  const GaitLimits& gait_;
};

}  // namespace

std::optional<OrderSteps> steps_of(const hal::WalkOrder& order, const hal::Stance& from,
                                   std::optional<hal::Foot> last_foot, const GaitLimits& gait) noexcept {
  const Pose2 base = gait_base(from, last_foot, gait);
  const Expansion left(order, from, base, hal::Foot::kLeft, gait),
      right(order, from, base, hal::Foot::kRight, gait);
  OrderSteps steps;
  const std::size_t most = order.kind == Kind::kNextStep ? 1 : OrderSteps::kMost;
  for (std::size_t count = 1; count <= most; ++count) {
    if (last_foot != hal::Foot::kLeft && left.in(count, steps)) return steps;
    if (last_foot != hal::Foot::kRight && right.in(count, steps)) return steps;
  }
  return std::nullopt;
}

}  // namespace headway::nav
