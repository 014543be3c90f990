// The walk that is being followed, and how it fits what the bus loop has committed of it.
#pragma once

#include <cstdint>

#include "nav/footsteps.h"
#include "nav/planner.h"
#include "nav/step_stack.h"

namespace headway::runtime {

struct CurrentWalk {
  std::uint8_t session = 0;
  std::uint32_t first_index = 0;  ///< number of walk.steps[0]
  nav::Path path;
  nav::Walk walk;

  /// Steps of it that are committed.
  std::size_t done(const nav::Committed& committed) const { return committed.next_index - first_index; }
  /// Steps of it that may still change.
  std::size_t left(const nav::Committed& committed) const { return walk.steps.size() - done(committed); }

  /// Whether the committed steps are the first ones of it, and end where it says.
  bool fits(const nav::Committed& committed) const;

  /// The session ended early, at rest in a stance that the walk knows: what is left of it becomes a walk of
  /// the next session. False, and nothing done, where it did not, or amid an order.
  [[nodiscard]] bool carry_over(const nav::Committed& committed);

  /// Whether the steps that may still change are those of `other`, planned from where the committed ones end.
  bool goes_on_as(const nav::Walk& other, const nav::Committed& committed) const;

  /// For the bus loop: the next `count` steps, at most as many as a plan holds.
  nav::StepPlan next_steps(std::size_t count, const nav::Committed& committed) const;
};

}  // namespace headway::runtime
