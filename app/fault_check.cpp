#include "app/fault_check.h"

#include <algorithm>

#include <fmt/format.h>

namespace headway::app {

namespace {

using sim::FaultKind;
using enum sim::FaultKind;

constexpr Duration kCycle = seconds(0.005);       // of the bus loop
constexpr Duration kStatus = seconds(0.02);       // between two reports of the control computer
constexpr Duration kPositionAway = seconds(0.1);  // a head whose position stays away so long is degraded
constexpr Duration kAfterwards = seconds(2);      // so long after its end, signs are still a fault's
constexpr double kCovered = 0.1;                  // share of the light below which nothing is seen

/// A part of the program that tells of a kind of faults.
enum class Concern : std::uint8_t { kFrames, kBus, kHead, kControl, kLoops };

Concern concern_of(FaultKind kind) {
  if (kind <= kSwapped) return Concern::kFrames;
  if (kind <= kBusOff) return Concern::kBus;
  if (kind <= kSilentTilt) return Concern::kHead;
  if (kind <= kControlClockJump) return Concern::kControl;
  return Concern::kLoops;
}

std::string frame_sign(const ProgramSigns& before, const ProgramSigns& now) {
  if (now.frames.unusable > before.frames.unusable) return "a picture that tells nothing";
  if (now.frames.no_pose > before.frames.no_pose) return "a picture without a pose";
  if (now.frames.lost > before.frames.lost) return "pictures lost";
  return now.committed.why == nav::StackStop::kStale ? "the map is too old" : "";
}

std::string head_sign(const ProgramSigns& now) {
  switch (now.head) {
    case hal::HeadHealth::kStarting:
      return "the head starts anew";
    case hal::HeadHealth::kDegraded:
      return "the head's pose is not known";
    case hal::HeadHealth::kNotHomed:
      return "the head is not homed";
    case hal::HeadHealth::kFault:
      return "the head's fault";
    case hal::HeadHealth::kReady:
      break;
  }
  return "";
}

std::string control_sign(const ProgramSigns& before, const ProgramSigns& now) {
  if (now.control == hal::WalkerHealth::kLost) return "the control computer is lost";
  if (now.control == hal::WalkerHealth::kNoChest) return "no chest pose";
  if (now.committed.why == nav::StackStop::kRestarted) return "the control computer began anew";
  if (now.reject != hal::StepReject::kNone && now.reject != before.reject) return "a step refused";
  if (before.clock_known && !now.clock_known) return "the control computer's clock is not known";
  if (now.unused.wrong_crc > before.unused.wrong_crc) return "a frame with a wrong CRC";
  if (now.unused.lost > before.unused.lost) return "CAN frames lost";
  if (now.unused.repeated > before.unused.repeated ||
      now.unused.wrong_sequence > before.unused.wrong_sequence)
    return "CAN frames out of order";
  return now.unused.undeclared > before.unused.undeclared ? "a frame with undeclared values" : "";
}

std::string bus_sign(const ProgramSigns& before, const ProgramSigns& now) {
  if (now.bus != hal::CanBusState::kErrorActive) return "the bus is off";
  const std::string control = control_sign(before, now);
  return control.empty() ? head_sign(now) : control;
}

std::string loop_sign(const ProgramSigns& before, const ProgramSigns& now) {
  if (now.cycles_missed > before.cycles_missed) return "cycles missed";
  return frame_sign(before, now);
}

std::string sign_of(Concern concern, const ProgramSigns& before, const ProgramSigns& now) {
  switch (concern) {
    case Concern::kFrames:
      return frame_sign(before, now);
    case Concern::kBus:
      return bus_sign(before, now);
    case Concern::kHead:
      return head_sign(now);
    case Concern::kControl:
      return control_sign(before, now);
    case Concern::kLoops:
      return loop_sign(before, now);
  }
  return "";
}

const char* text_of(nav::StackStop why) {
  switch (why) {
    case nav::StackStop::kNone:
      return "the walk had come to its end";
    case nav::StackStop::kAsked:
      return "stopped: asked for";
    case nav::StackStop::kMissed:
      return "stopped: no step in time";
    case nav::StackStop::kStale:
      return "stopped: the map is too old";
    case nav::StackStop::kRejected:
      return "stopped: a step was refused";
    case nav::StackStop::kLost:
      return "stopped: the control computer is lost";
    case nav::StackStop::kNoStart:
      return "stopped: the walk did not begin";
    case nav::StackStop::kEnded:
      return "stopped: the control computer came to rest";
    case nav::StackStop::kRestarted:
      return "stopped: the control computer began anew";
  }
  return "stopped";
}

std::string answer_of(Demand::Answer demanded, const ProgramSigns& now) {
  if (demanded == Demand::Answer::kDegrade) return head_sign(now);
  if (now.committed.stopping) return text_of(now.committed.why);
  if (now.committed.at_rest) return "at rest";
  return now.braking ? "the control computer brakes by itself" : "";
}

bool hits_status(const sim::Fault& fault) {
  return fault.share >= 1 && (fault.id == sim::kAnyId || fault.id == hal::bus::WalkStatus::kId);
}

/// The map ages, and no step rests on it any more; at the next step's deadline the walk is ended.
Demand blind(Duration step, const DemandConfig& config) {
  const Duration age = config.steps.max_map_age;
  return {Demand::Answer::kStop, age + step + kStatus + 2 * kCycle, age + kCycle};
}

/// The next step is sent, and refused.
Demand refused(Duration step, const DemandConfig& config) {
  const Duration window = config.steps.commit_from - config.steps.commit_by;
  const Duration answered = step + window + 3 * kStatus + 2 * kCycle;
  return {Demand::Answer::kStop, answered, std::nullopt};
}

Demand unheard(const DemandConfig& config) {
  const Duration soon = config.steps.status_timeout + 2 * kCycle;
  return {Demand::Answer::kStop, soon, soon};
}

/// What it asks for if it lasts for ever.
std::optional<Demand> lasting(const sim::Fault& fault, Duration remaining, const DemandConfig& config) {
  const Duration step = std::max(config.step, remaining);
  const Demand degrade{Demand::Answer::kDegrade, kPositionAway + kStatus + 2 * kCycle, std::nullopt};
  const bool late = fault.delay > config.steps.status_timeout;
  switch (fault.kind) {
    case kFrameLoss:
      return fault.share >= 1 ? std::optional(blind(step, config)) : std::nullopt;
    case kFrameDelay:
      return fault.delay >= config.steps.max_map_age ? std::optional(blind(step, config)) : std::nullopt;
    case kDark:
      return fault.light < kCovered ? std::optional(blind(step, config)) : std::nullopt;
    case kFrozenPicture:
    case kFrozenStamp:
    case kSwapped:
    case kStarvedFrameLoop:
      return blind(step, config);
    case kCanLoss:
    case kCanCorruption:
      return hits_status(fault) ? std::optional(unheard(config)) : std::nullopt;
    case kCanDelay:
      return hits_status(fault) && late ? std::optional(unheard(config)) : std::nullopt;
    case kSlowControl:
      return late ? std::optional(unheard(config)) : std::nullopt;
    case kBusOff:
    case kSilentControl:
      return unheard(config);
    case kRestartControl: {
      Demand demand = unheard(config);
      demand.within += kStatus;
      demand.last_step = demand.within;
      return demand;
    }
    case kRejectingControl:
      return refused(step, config);
    case kStarvedBusLoop:
    case kStarvedLoops:
      return Demand{Demand::Answer::kStop, seconds(0.15) + 8 * kCycle, Duration{}};
    case kRebootPan:
    case kRebootTilt:
    case kSilentPan:
    case kSilentTilt:
      return degrade;
    case kNoise:
    case kStallPan:
    case kStallTilt:
    case kControlClockJump:
      return std::nullopt;
  }
  return std::nullopt;
}

/// It is over in an instant, and what it does lasts.
bool leaves_its_mark(FaultKind kind) {
  return kind == kRebootPan || kind == kRebootTilt || kind == kRestartControl;
}

Json seconds_json(const std::optional<Time>& t) { return t ? rounded(to_seconds(*t), 3) : Json(nullptr); }

}  // namespace

std::optional<Demand> demand_of(const sim::Fault& fault, Duration remaining, const DemandConfig& config) {
  const auto demand = lasting(fault, remaining, config);
  if (!demand || leaves_its_mark(fault.kind)) return demand;
  return fault.length >= demand->within ? demand : std::nullopt;
}

FaultCheck::FaultCheck(const sim::FaultPlan& plan, const DemandConfig& config) : config_(config) {
  for (const sim::Fault& fault : plan) rows_.emplace_back().fault = fault;
}

void FaultCheck::begin(Row& row, Time at) {
  row.begun = at;
  row.walking = !last_.committed.at_rest && !last_.committed.stopping && !last_.braking;
  const auto demand = demand_of(row.fault, last_.phase_remaining, config_);
  if (!demand) return;
  row.last_step = demand->last_step;
  if (row.walking || demand->answer == Demand::Answer::kDegrade) row.demand = demand;
}

void FaultCheck::watch(Row& row, Time now, const ProgramSigns& signs) {
  if (!row.noticed)
    if (std::string what = sign_of(concern_of(row.fault.kind), last_, signs); !what.empty())
      row.noticed = {now, std::move(what)};
  if (row.demand && !row.answered)
    if (std::string what = answer_of(row.demand->answer, signs); !what.empty())
      row.answered = {now, std::move(what)};
  const bool committed = signs.committed.session == last_.committed.session
                             ? signs.committed.next_index > last_.committed.next_index
                             : signs.committed.next_index > 0;
  if (row.last_step && !row.ended && committed && now > *row.begun + *row.last_step) ++row.late_steps;
}

void FaultCheck::look(Time now, const sim::FaultSchedule& schedule, const ProgramSigns& signs) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (!schedule.begun(i, now)) continue;
    if (!row.begun) begin(row, *schedule.begin(i));
    if (!row.ended && now >= *schedule.end(i)) row.ended = *schedule.end(i);
    if (now <= *schedule.end(i) + kAfterwards) watch(row, now, signs);
  }
  last_ = signs;
}

double after(const FaultCheck::Row& row, const FaultCheck::Sign& sign) {
  return to_seconds(sign.at - *row.begun);
}

bool is_late(const FaultCheck::Row& row) {
  if (!row.demand) return false;
  // Where the run ends first, nothing more could be seen.
  return row.answered ? row.answered->at > *row.begun + row.demand->within : row.ended.has_value();
}

std::string fault_lines(const FaultCheck& check) {
  std::string lines;
  const auto sign = [](const FaultCheck::Row& row, const FaultCheck::Sign& s) {
    return fmt::format("{} after {:.3f} s", s.what, after(row, s));
  };
  for (const FaultCheck::Row& row : check.rows()) {
    const std::string name(traits(row.fault.kind).name);
    if (!row.begun) {
      lines += fmt::format("fault {}: did not begin\n", name);
      continue;
    }
    const std::string noticed = row.noticed ? sign(row, *row.noticed) : "not noticed";
    const std::string answer = !row.demand    ? "no reaction needed"
                               : row.answered ? sign(row, *row.answered)
                                              : "no reaction";
    lines += fmt::format("fault {} at {:.2f} s: {}; {}\n", name, to_seconds(row.begun->time_since_epoch()),
                         noticed, answer);
  }
  return lines;
}

Json FaultCheck::report() const {
  const auto sign = [](const Row& row, const std::optional<Sign>& s) {
    return s ? Json{{"what", s->what}, {"after_s", rounded(after(row, *s), 3)}} : Json(nullptr);
  };
  Json all = Json::array();
  for (const Row& row : rows_) {
    const sim::FaultParameters& uses = traits(row.fault.kind).uses;
    Json json = {{"kind", traits(row.fault.kind).name},
                 {"begin_s", seconds_json(row.begun)},
                 {"end_s", seconds_json(row.ended)}};
    if (uses.share) json["share"] = rounded(row.fault.share, 3);
    if (uses.id && row.fault.id != sim::kAnyId) json["id"] = row.fault.id;
    if (uses.delay) json["delay_s"] = rounded(to_seconds(row.fault.delay), 3);
    if (uses.noise) json["noise"] = rounded(row.fault.noise, 1);
    if (uses.light) json["light"] = rounded(row.fault.light, 3);
    if (uses.jump) json["jump_s"] = rounded(to_seconds(row.fault.jump), 3);
    json["walking"] = row.walking;
    json["noticed"] = sign(row, row.noticed);
    if (!row.begun)
      json["reaction"] = "did not begin";
    else if (!row.demand)
      json["reaction"] = "none needed";
    else
      json["reaction"] = sign(row, row.answered);
    if (row.demand) json["within_s"] = rounded(to_seconds(row.demand->within), 3);
    json["late"] = is_late(row);
    json["late_steps"] = row.late_steps;
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace headway::app
