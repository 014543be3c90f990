#include "runtime/current_walk.h"

#include <algorithm>
#include <cmath>

namespace headway::runtime {

namespace {

bool same(const Pose2& a, const Pose2& b) {
  return (a.position() - b.position()).norm() < 1e-6 && std::abs(wrap_angle(a.yaw - b.yaw)) < 1e-6;
}

bool same(const hal::Stance& a, const hal::Stance& b) {
  return same(a.left, b.left) && same(a.right, b.right);
}

bool same(const hal::Footstep& a, const hal::Footstep& b) {
  return a.foot == b.foot && same(a.landing, b.landing) && a.dz == b.dz && a.duration == b.duration &&
         a.clear == b.clear;
}

}  // namespace

bool CurrentWalk::fits(const nav::Committed& committed) const {
  if (committed.session != session || committed.next_index < first_index) return false;
  const std::size_t steps = done(committed);
  if (steps > walk.steps.size()) return false;
  if (steps == 0) return true;
  // The same step may have been committed as part of another order.
  if (!walk.orders.empty() && committed.part != walk.orders[steps - 1]) return false;
  return same(walk.stances[steps - 1], committed.stance);
}

bool CurrentWalk::carry_over(const nav::Committed& committed) {
  const auto here = std::ranges::find_if(
      walk.stances, [&](const hal::Stance& stance) { return same(stance, committed.stance); });
  if (!committed.at_rest || here == walk.stances.end()) return false;
  const auto walked = here - walk.stances.begin() + 1;
  // What is left of an order ended with its session.
  if (walked < std::ssize(walk.orders) && walk.orders[static_cast<std::size_t>(walked)].place > 0)
    return false;
  walk.from = *here;
  walk.steps.erase(walk.steps.begin(), walk.steps.begin() + walked);
  walk.bases.erase(walk.bases.begin(), walk.bases.begin() + walked);
  walk.stances.erase(walk.stances.begin(), walk.stances.begin() + walked);
  if (!walk.orders.empty()) walk.orders.erase(walk.orders.begin(), walk.orders.begin() + walked);
  session = committed.session;
  first_index = committed.next_index;
  return true;
}

bool CurrentWalk::goes_on_as(const nav::Walk& other, const nav::Committed& committed) const {
  const auto from = walk.steps.begin() + static_cast<std::ptrdiff_t>(done(committed));
  return std::equal(from, walk.steps.end(), other.steps.begin(), other.steps.end(),
                    [](const hal::Footstep& a, const hal::Footstep& b) { return same(a, b); });
}

nav::StepPlan CurrentWalk::next_steps(std::size_t count, const nav::Committed& committed) const {
  nav::StepPlan plan;
  plan.session = committed.session;
  plan.first_index = committed.next_index;
  plan.count = static_cast<int>(std::min<std::size_t>(count, nav::StepPlan::kMost));
  plan.complete = static_cast<std::size_t>(plan.count) == left(committed);
  const auto from = static_cast<std::ptrdiff_t>(done(committed));
  std::copy_n(walk.steps.begin() + from, plan.count, plan.steps.begin());
  plan.in_orders = !walk.orders.empty();
  if (plan.in_orders) std::copy_n(walk.orders.begin() + from, plan.count, plan.orders.begin());
  return plan;
}

}  // namespace headway::runtime
