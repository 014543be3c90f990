// The steps that are sent and those that may still change. Owned by the bus loop: no heap, exceptions or
// locks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/footstep.h"
#include "hal/time.h"
#include "hal/walker.h"

namespace headway::nav {

/// Steps proposed by the frame loop. They follow on the committed steps before `first_index`.
struct StepPlan {
  static constexpr int kMost = 64;
  std::uint8_t session = 0;
  std::uint32_t first_index = 0;  ///< number of steps[0] in the session's walk
  std::array<hal::Footstep, kMost> steps{};
  std::array<hal::PartOfOrder, kMost> orders{};  ///< that the steps belong to, if `in_orders`
  bool in_orders = false;                        ///< else the steps themselves travel
  int count = 0;
  bool complete = false;  ///< the last step ends the walk; otherwise more is to follow
  Time newest_frame{};    ///< exposure of the newest frame that the plan rests on
};

enum class PlanVerdict : std::uint8_t {
  kTaken,
  kLate,      ///< its first step is committed already
  kSession,   ///< of another walk
  kGap,       ///< it begins after the next step
  kStopping,  ///< nothing more is committed in this session
  kInvalid,   ///< count out of range, or the feet do not alternate
};

/// Why nothing more is committed in this session.
enum class StackStop : std::uint8_t {
  kNone,       ///< it goes on, or has come to its planned end
  kAsked,      ///< stop() was called
  kMissed,     ///< no step was there at its deadline
  kStale,      ///< the plan rested on frames too old at the deadline
  kRejected,   ///< the control computer refused a step
  kLost,       ///< its status stayed away, is a fault, or made no sense
  kNoStart,    ///< it did not begin to walk in time
  kEnded,      ///< it came to rest before the last step
  kRestarted,  ///< it began anew on the way, and knows nothing of this walk
};

struct StepStackConfig {
  /// Deadlines, as WalkingConfig says them: so long after a lift-off the control computer has to know the
  /// step two after; the second step of a walk, as if one of the shortest came before the first.
  Duration known_after = seconds(0.3), shortest_step = seconds(0.8);
  /// A step may commit this long before its deadline: so at its own lift-off, and not before, the step two
  /// after. What is committed then has landed within three steps, and the robot rests after 2.7 s.
  Duration commit_from = seconds(0.30);
  /// From then on it waits for the next plan, which is in the making, until this much remains.
  Duration commit_by = seconds(0.19);
  Duration lead = seconds(0.15);           ///< it must be sent this long before its deadline
  Duration margin = seconds(0.02);         ///< for the way to the wire
  Duration max_map_age = seconds(1.0);     ///< a step commits only on a plan this fresh
  Duration status_timeout = seconds(0.1);  ///< a status older than this is no status
  Duration start_timeout = seconds(4.0);   ///< from the first step sent to its lift-off

  /// Throws InputError for what no walk could be led by.
  void validate() const;
};

/// A step that can no longer be taken back, and where the feet stand when it has landed.
struct CommittedStep {
  hal::Footstep step;
  hal::Stance stance;
  std::optional<hal::PartOfOrder> part;  ///< the order that it is part of, if of any
};

/// What the frame loop needs to know to plan on.
struct Committed {
  static constexpr std::uint32_t kRemembered = 8;
  /// Steps at the end that the robot turns out not to walk, four at most, must not cost those before them.
  static constexpr std::uint32_t kKept = kRemembered + 4;
  std::uint8_t session = 0;
  std::uint32_t next_index = 0;  ///< the first step that may still change
  hal::Stance stance;            ///< after all committed steps
  std::optional<hal::Foot>
      last_foot;  ///< the last one to land in it; nothing before the first step, and at rest
  std::optional<hal::PartOfOrder> part;  ///< the order that the last committed step is part of, if of any
  bool stopping = false;                 ///< nothing more is committed in this session
  StackStop why = StackStop::kNone;      ///< kNone too once the last step of a complete plan is committed
  bool at_rest = true;                   ///< no committed step is left to walk
  Time newest_frame{};                   ///< of the plan of the last committed step
  std::uint32_t taken = 0, late = 0, refused = 0;  ///< plans, since the program began
  std::array<CommittedStep, kKept> newest{};       ///< step i at i modulo the size

  /// Step `index` of the session; nothing when it is not committed, or so long ago that it is forgotten.
  const CommittedStep* step(std::uint32_t index) const noexcept {
    const bool known = index < next_index && next_index - index <= kRemembered;
    return known ? &newest[index % kKept] : nullptr;
  }
};

/// The committed steps are the one under way and the two after it, which the robot needs to come to rest;
/// from a lift-off to the next commit, one of these. A walk begins with one step, and commits the second and
/// the third while the weight is shifted. A step commits with a plan just taken, where one comes in time: a
/// plan that is in the making when a step commits would come too late to be taken. Whatever is missed ends
/// the walk after the steps that are committed, feet as they land. Nothing sent is ever replaced; but a step
/// that the control computer refuses, or does not walk before it comes to rest, was none.
class StepStack {
 public:
  /// Throws InputError as StepStackConfig::validate.
  explicit StepStack(const StepStackConfig& config = {});

  /// A new walk from a stance. False, and nothing done, unless at rest and with a session number (0..15)
  /// other than the last.
  bool begin(std::uint8_t session, const hal::Stance& stance) noexcept;

  /// Takes a plan whose first step is the next to commit, in place of the last plan.
  PlanVerdict propose(const StepPlan& plan) noexcept;

  /// Commits nothing more in this session.
  void stop() noexcept { stop(StackStop::kAsked); }

  /// Call once a bus cycle, walking or not. The step to hand over now, if any; it is committed by sent(). May
  /// be called again in the same cycle for the next one.
  std::optional<hal::NumberedStep> due(Time now, const hal::WalkStatus& status) noexcept;

  /// The walker has taken the step that due() returned last (hal::Walker::send gave true).
  void sent(Time now) noexcept;

  const Committed& committed() const noexcept { return committed_; }
  bool walking() const noexcept { return !committed_.at_rest; }
  /// The number of the step under way, or of the last one; nothing before the first.
  std::optional<std::uint32_t> executing() const noexcept;

 private:
  static constexpr std::int64_t kNone = -1;
  void stop(StackStop why) noexcept;
  PlanVerdict check(const StepPlan& plan) const noexcept;
  void follow(Time now, const hal::WalkStatus& status) noexcept;
  void follow_session(const hal::WalkStatus& status) noexcept;
  void give_up_start(Time now, const hal::WalkStatus& status) noexcept;
  void come_to_rest() noexcept;
  void forget_from(std::int64_t index) noexcept;
  std::int64_t committed_index(std::uint8_t number) const noexcept;
  const hal::Footstep* next_step() const noexcept;
  std::optional<hal::PartOfOrder> next_part() const noexcept;
  bool plan_ends() const noexcept;
  bool fresh(Time now) const noexcept { return now - plan_.newest_frame <= config_.max_map_age; }
  Duration until_deadline(std::uint32_t index, Time now, const hal::WalkStatus& status) const noexcept;
  bool may_commit(Time now, const hal::WalkStatus& status) noexcept;
  void pass_deadline(Time now) noexcept;

  StepStackConfig config_;
  Committed committed_;
  bool begun_ = false, has_plan_ = false, due_ = false;
  bool new_plan_ = false;  ///< taken since the next step may commit
  StepPlan plan_;
  hal::Stance first_stance_;  ///< before step 0
  std::int64_t executing_ = kNone;
  Time first_sent_{};
};

}  // namespace headway::nav
