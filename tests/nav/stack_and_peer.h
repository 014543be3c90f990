// The step stack walking with its peer, the control computer, and judged at every cycle by what both promise.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "nav/step_stack.h"

namespace headway::nav {

constexpr std::uint8_t kSession = 3;
constexpr Duration kStep = std::chrono::milliseconds(800), kShift = std::chrono::milliseconds(1300);
/// After a lift-off the step two after has to be known.
constexpr Duration kKnownAfter = std::chrono::milliseconds(300);
/// Before its deadline a step commits no earlier than this, and no later than that.
constexpr Duration kWindow = std::chrono::milliseconds(300), kLead = std::chrono::milliseconds(150);

/// Tells steps apart: the n-th step ever planned is n millimetres long.
inline hal::Footstep some_step(std::uint32_t index, int mark) {
  const hal::Foot foot = index % 2 == 0 ? hal::Foot::kLeft : hal::Foot::kRight;
  return hal::quantised({foot, {mark * 1e-3, foot == hal::Foot::kLeft ? 0.19 : -0.19, 0}, 0, kStep});
}

inline StepPlan some_plan(std::uint32_t first, int count, bool complete, Time frame, int mark = 0) {
  StepPlan plan;
  plan.session = kSession;
  plan.first_index = first;
  plan.count = count;
  plan.complete = complete;
  plan.newest_frame = frame;
  for (int i = 0; i < count; ++i) {
    plan.steps[static_cast<std::size_t>(i)] = some_step(first + static_cast<std::uint32_t>(i), mark + i);
  }
  return plan;
}

/// The other side as the contract says it: takes steps in order until too late, walks what it has. It answers
/// from what reached it; frames may be lost in either direction. Plain value, so that a search can branch
/// from it.
struct Peer {
  std::uint8_t session = kSession;
  std::uint32_t accepted = 0, started = 0;
  Time lifted{};  ///< of the step under way; of the first, its weight is shifted before
  bool ended = false, refuses = false, standing = true;
  std::uint8_t rejected = hal::kNoStep;
  hal::StepReject reason = hal::StepReject::kNone;

  void take(std::uint32_t index) {
    if (index < accepted) return;  // a repetition
    if (index != accepted || ended || refuses) {
      rejected = static_cast<std::uint8_t>(index % 64);
      reason = ended ? hal::StepReject::kLate : hal::StepReject::kSequence;
      return;
    }
    ++accepted;
  }

  void run(Time now) {
    if (started == 0) {
      if (accepted > 0) lift(now + kShift);
      return;
    }
    if (standing) return;
    if (now - lifted >= kStep) started < accepted ? lift(now) : void(standing = true);
    // The one under way and two more in time, or this walk has an end.
    if (accepted < started + 2 && now >= deadline(accepted)) ended = true;
  }

  void lift(Time when) {
    ++started;
    lifted = when;
    standing = false;
  }

  /// By then the step must be there; as long as one is under way.
  Time deadline(std::uint32_t index) const {
    return lifted + kKnownAfter + (static_cast<std::int64_t>(index) - (started + 1)) * kStep;
  }

  hal::WalkStatus status(Time now) const {
    hal::WalkStatus s;
    s.session = session;
    s.state = standing ? hal::WalkState::kStanding
              : ended  ? hal::WalkState::kStopping
                       : hal::WalkState::kWalking;
    s.executing = started == 0 ? hal::kNoStep : static_cast<std::uint8_t>((started - 1) % 64);
    s.accepted = accepted == 0 ? hal::kNoStep : static_cast<std::uint8_t>((accepted - 1) % 64);
    s.rejected = rejected == hal::kNoStep ? std::uint8_t{0} : rejected;
    s.reject_reason = reason;
    s.phase_remaining = standing || started == 0 ? Duration{} : lifted + kStep - now;
    s.stamp = now;
    return s;
  }
};

/// The step stack, its peer and the driver between them, which repeats a step until it is answered.
struct Walking {
  StepStack stack;
  Peer peer;
  hal::WalkStatus heard;
  Time now = at_seconds(10);
  bool answers = true, listens = true, sends = true;

  // What the test remembers to judge by.
  hal::Stance first;
  std::array<hal::Footstep, 200> committed{};
  std::uint32_t high = 0;  ///< steps ever committed
  bool stopped = false;
  std::uint32_t stopped_at = 0;
  const char* fault = nullptr;

  Walking() { begin(kSession, hal::Stance::parallel({0, 0, 0}, 0.19)); }

  /// A walk with another number, which the peer takes up as well.
  void begin(std::uint8_t session, const hal::Stance& stance) {
    if (!stack.begin(session, stance)) complain("a walk at rest does not begin");
    first = stance;
    peer = {};
    peer.session = session;
    heard = peer.status(now);
    high = stopped_at = 0;
    stopped = false;
  }

  std::uint32_t next() const { return stack.committed().next_index; }
  void complain(const char* what) {
    if (fault == nullptr) fault = what;
  }

  void cycle() {
    now += std::chrono::milliseconds(5);
    peer.run(now);
    const bool cyclic = (now.time_since_epoch() / std::chrono::milliseconds(5)) % 4 == 0;
    if (answers && cyclic) heard = peer.status(now);
    while (const auto step = stack.due(now, heard)) {
      judge(*step);
      if (!sends) break;
      stack.sent(now);
    }
    // One unanswered step after the other, as the driver does it.
    if (listens && cyclic && peer.accepted < next()) peer.take(peer.accepted);
    judge_always();
  }

  void judge(const hal::NumberedStep& step) {
    if (step.index != next()) complain("indexes are not consecutive");
    if (stopped) complain("a step after a stop");
    if (step.index > peer.started + 1 || (peer.started == 0 && step.index > 0))
      complain("committed more than the one under way and two after it");
    if (peer.started > 0) {
      const Duration left = peer.deadline(step.index) - now;
      if (left < kLead) complain("committed too late for its deadline");
      if (left > kWindow + std::chrono::milliseconds(5)) complain("committed before it had to");
    }
    if (now - stack_frame > seconds(1)) complain("committed on an old map");
    if (!sends) return;
    if (step.index < high) complain("an index committed twice");
    committed[step.index] = step.step;
    high = std::max(high, step.index + 1);
  }

  void judge_always() {
    const Committed& c = stack.committed();
    if (stopped && c.next_index > stopped_at) complain("grew after a stop");
    if (c.stopping && !stopped) {
      stopped = true;
      stopped_at = c.next_index;
    }
    if (c.next_index > peer.started + 2) complain("too many steps ahead");
    // What the stack says is the chain of the steps it gave out.
    hal::Stance stance = first;
    for (std::uint32_t i = 0; i < c.next_index; ++i) stance = stance.after(committed[i]);
    if (stance.left.x != c.stance.left.x || stance.right.x != c.stance.right.x) complain("another stance");
    if (c.step(c.next_index) != nullptr) complain("a step that is not committed");
    for (std::uint32_t i = c.next_index; i > 0 && c.next_index - i < Committed::kRemembered; --i) {
      const CommittedStep* step = c.step(i - 1);
      if (step == nullptr || step->step.landing.x != committed[i - 1].landing.x) complain("another step");
    }
    if (c.at_rest && c.next_index > 0) {
      if (c.next_index != peer.started || !peer.standing) complain("not at rest, or elsewhere");
    }
    // While it goes on, the peer never runs dry of the two steps it needs to come to rest.
    if (!c.stopping && peer.ended && answers && peer.started > 0 &&
        now - peer.deadline(peer.accepted) > std::chrono::milliseconds(40) &&
        now - heard.stamp <= std::chrono::milliseconds(20)) {
      complain("the peer ends the walk and the stack does not know");
    }
  }

  Time stack_frame = at_seconds(10);
  PlanVerdict propose(const StepPlan& plan) {
    const PlanVerdict verdict = stack.propose(plan);
    if (verdict == PlanVerdict::kTaken) stack_frame = plan.newest_frame;
    return verdict;
  }
  PlanVerdict plan(std::uint32_t from, int count, bool complete, int mark) {
    return propose(some_plan(from, count, complete, now, mark));
  }
  void run(Duration d) {
    for (const Time end = now + d; now < end;) cycle();
  }
  /// Frames that keep coming, so the plan stays fresh.
  void run_fresh(Duration d, int count = 20) {
    for (const Time end = now + d; now < end;) {
      plan(next(), count, false, static_cast<int>(next()));
      run(std::chrono::milliseconds(30));
    }
  }
};

}  // namespace headway::nav
