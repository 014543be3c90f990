#include "drivers/can_walker.h"

#include <algorithm>
#include <chrono>

#include "hal/step_number.h"

namespace headway::drivers {

namespace bus = hal::bus;
using hal::StepReject;
using hal::WalkerHealth;
using hal::WalkRequest;
using hal::WalkState;

static_assert(static_cast<int>(WalkState::kFault) == static_cast<int>(bus::WalkStatus::State::kFault));
static_assert(static_cast<int>(StepReject::kState) ==
              static_cast<int>(bus::WalkStatus::RejectReason::kState));
static_assert(static_cast<int>(WalkRequest::kAbort) == static_cast<int>(bus::WalkControl::Request::kAbort));
static_assert(static_cast<int>(hal::Foot::kRight) == static_cast<int>(bus::StepCommand::Foot::kRight));
static_assert(static_cast<int>(hal::WalkOrder::Kind::kNextStep) ==
              static_cast<int>(bus::WalkOrder::Kind::kNextStep));
static_assert(hal::kNoStep == bus::WalkStatus::kSeqAcceptedNone &&
              hal::kNoStep == bus::WalkStatus::kSeqExecutingNone);

namespace {

constexpr double kOldestMap = 65.535;  ///< what MapAge can say [s]

bus::StepCommand command_of(std::uint8_t session, const hal::NumberedStep& s) noexcept {
  return {.foot = static_cast<bus::StepCommand::Foot>(s.step.foot),
          .clear = s.step.clear,
          .seq = hal::wire_number(s.index),
          .session = session,
          .dx = s.step.landing.x,
          .dy = s.step.landing.y,
          .dtheta = s.step.landing.yaw,
          .duration = to_seconds(s.step.duration),
          .dz = s.step.dz};
}

bus::WalkOrder order_of(std::uint8_t session, std::uint32_t index, const hal::WalkOrder& order) noexcept {
  return {.kind = static_cast<bus::WalkOrder::Kind>(order.kind),
          .session = session,
          .seq = hal::wire_number(index),
          .x = order.x,
          .y = order.y,
          .theta = order.turn};
}

/// What travels for a step: itself, its order, or nothing where the order is on its way already.
bool travels(const hal::NumberedStep& s) noexcept { return !s.order || s.order->place == 0; }

std::optional<hal::CanFrame> frame_of(std::uint8_t session, const hal::NumberedStep& s) noexcept {
  return s.order ? order_of(session, s.index, s.order->order).pack() : command_of(session, s).pack();
}

Eigen::Isometry3d pose_of(const bus::ChestXY& xy, const bus::ChestZRot& r) noexcept {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (AngleAxisd(r.yaw, Vector3d::UnitZ()) * AngleAxisd(r.pitch, Vector3d::UnitY()) *
                   AngleAxisd(r.roll, Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() << xy.x, xy.y, r.z;
  return pose;
}

/// Counters advance only with frames that went out, else the other side would count losses.
bool send_protected(hal::CanBus& bus, bus::Protector& protector, hal::CanFrame frame) noexcept {
  bus::Protector next = protector;
  next.protect(frame);
  if (!bus.send(frame)) return false;
  protector = next;
  return true;
}

}  // namespace

CanWalker::CanWalker(hal::CanBus& bus, const WalkerConfig& config) noexcept
    : bus_(bus),
      config_(config),
      step_protector_(bus::StepCommand::kDataId),
      order_protector_(bus::WalkOrder::kDataId),
      control_protector_(bus::WalkControl::kDataId),
      status_checker_(bus::WalkStatus::kDataId),
      xy_checker_(bus::ChestXY::kDataId),
      rotation_checker_(bus::ChestZRot::kDataId),
      time_checker_(bus::ControlTime::kDataId),
      clock_(config.clock),
      control_cadence_(config.control_cycle) {}

// --- what comes in ---

template <class Message>
std::optional<Message> CanWalker::read(const hal::CanFrame& frame, bus::ProtectionChecker& checker) noexcept {
  if (!bus::is_usable(checker.check(frame))) return std::nullopt;
  const auto message = Message::unpack(frame);
  if (!message) ++undeclared_;
  return message;
}

void CanWalker::receive(const hal::CanFrame& frame) noexcept {
  switch (frame.id) {
    case bus::WalkStatus::kId:
      if (const auto m = read<bus::WalkStatus>(frame, status_checker_)) hear(*m, frame.stamp);
      break;
    case bus::ChestXY::kId:
      if (const auto m = read<bus::ChestXY>(frame, xy_checker_)) {
        xy_ = m;
        xy_stamp_ = frame.stamp;
        pair_halves();
      }
      break;
    case bus::ChestZRot::kId:
      if (const auto m = read<bus::ChestZRot>(frame, rotation_checker_)) {
        rotation_ = m;
        rotation_stamp_ = frame.stamp;
        pair_halves();
      }
      break;
    case bus::ControlTime::kId:
      if (const auto m = read<bus::ControlTime>(frame, time_checker_)) clock_.hear(m->ms, frame.stamp);
      break;
    default:
      break;
  }
}

void CanWalker::hear(const bus::WalkStatus& m, Time stamp) noexcept {
  status_ = hal::WalkStatus{.state = static_cast<WalkState>(m.state),
                            .session = m.session,
                            .executing = m.seq_executing,
                            .accepted = m.seq_accepted,
                            .rejected = m.seq_rejected,
                            .reject_reason = static_cast<StepReject>(m.reject_reason),
                            .queue_free = m.queue_free,
                            .phase_remaining = seconds(m.phase_remaining),
                            .stamp = stamp};
  status_heard_ = stamp;
  match_answer();
}

void CanWalker::pair_halves() noexcept {
  if (!xy_ || !rotation_ || xy_->sample != rotation_->sample) return;
  // Sample comes round after 16 cycles; halves of one pose lie within one.
  const Duration apart = xy_stamp_ - rotation_stamp_;
  if (apart > bus::ChestXY::kCycle || apart < -bus::ChestXY::kCycle) return;
  const Time held = xy_stamp_ - seconds(xy_->age);
  chest_heard_ = std::max(xy_stamp_, rotation_stamp_);
  if (held > chest_.stamp) {
    chest_.stamp = held;
    chest_.odom_from_chest = pose_of(*xy_, *rotation_);
  }
  xy_.reset();
  rotation_.reset();
}

// --- steps ---

bool CanWalker::send(std::uint8_t session, const hal::NumberedStep& step) noexcept {
  if (session == 0 || session > hal::kLastSession || health_ == WalkerHealth::kStarting ||
      health_ == WalkerHealth::kLost) {
    return false;
  }
  const bool begins = session != session_;
  if (step.index != (begins ? 0 : next_index_) || (!begins && (ended_ || queued_ == kSlots))) return false;
  if (!travels(step) && (begins || !goes_on(*step.order))) return false;
  const auto frame = frame_of(session, step);
  if (!frame) return false;
  if (begins) {
    session_ = session;
    queued_ = 0;
    taken_up_ = status_.session == session;
    ended_ = false;
    step_sent_.reset();
  }
  part_ = step.order;
  if (travels(step))
    slots_[(first_slot_ + queued_++) % kSlots] = {step.index, *frame};
  else
    control_changed_ = true;  // releases it
  next_index_ = step.index + 1;
  return true;
}

/// The next step of the order that the step before is part of.
bool CanWalker::goes_on(const hal::PartOfOrder& part) const noexcept {
  return part_ && part_->order == part.order && part_->place + 1 == part.place;
}

void CanWalker::match_answer() noexcept {
  if (session_ == 0 || ended_) return;
  if (status_.session != session_) {
    if (taken_up_) end_session();
    return;
  }
  taken_up_ = true;
  if (queued_ == 0 || !step_sent_) return;
  const Slot& asked = slots_[first_slot_];
  const auto newest = accepted();
  if (newest && *newest >= asked.index) {
    control_changed_ = control_changed_ || asked.is_order();  // releases its steps
    first_slot_ = (first_slot_ + 1) % kSlots;
    --queued_;
    step_sent_.reset();
  } else if (status_.rejected == hal::wire_number(asked.index) &&
             status_.reject_reason != StepReject::kNone && status_.reject_reason != StepReject::kFull) {
    end_session();  // a full queue passes; every other reason is final, for nothing sent is ever replaced
  }
}

void CanWalker::end_session() noexcept {
  queued_ = 0;
  ended_ = true;
  step_sent_.reset();
}

void CanWalker::send_step(Time now) noexcept {
  if (queued_ == 0 || !taken_up_ || health_ == WalkerHealth::kLost || status_.queue_free == 0) return;
  if (step_sent_ && now - *step_sent_ < config_.step_repeat) return;
  const Slot& next = slots_[first_slot_];
  // Its first step must be the next to be accepted.
  if (next.is_order() && next.index != (accepted() ? *accepted() + 1 : 0)) return;
  if (send_protected(bus_, next.is_order() ? order_protector_ : step_protector_, next.frame))
    step_sent_ = now;
}

/// The newest step of the session that was accepted.
std::optional<std::uint32_t> CanWalker::accepted() const noexcept {
  if (next_index_ == 0 || status_.session != session_) return std::nullopt;
  return hal::unwrapped(status_.accepted, next_index_ - 1);
}

/// The newest step handed over, but none of an order still unanswered.
std::uint8_t CanWalker::last_released() const noexcept {
  const bool held = queued_ > 0 && slots_[first_slot_].is_order();
  const std::uint32_t released = held ? slots_[first_slot_].index : next_index_;
  return hal::wire_number(released + hal::kStepNumbers - 1);
}

// --- the walk ---

void CanWalker::control(WalkRequest request, std::uint8_t session, Duration map_age) noexcept {
  if (session > hal::kLastSession) session = 0;
  control_changed_ = control_changed_ || request != request_ || session != control_session_;
  request_ = request;
  control_session_ = session;
  map_age_ = map_age;
}

void CanWalker::send_control(Time now) noexcept {
  if (!control_changed_ && !control_cadence_.is_due(now)) return;
  const bool has_steps = control_session_ != 0 && control_session_ == session_ && next_index_ > 0;
  const bus::WalkControl message{
      .request = static_cast<bus::WalkControl::Request>(request_),
      .session = control_session_,
      .last_seq = has_steps ? last_released() : hal::wire_number(hal::kStepNumbers - 1),
      .map_age = std::clamp(to_seconds(map_age_), 0.0, kOldestMap)};
  if (!send_protected(bus_, control_protector_, *message.pack())) return;
  control_changed_ ? control_cadence_.restart(now) : control_cadence_.done(now);
  control_changed_ = false;
}

// --- the cycle ---

void CanWalker::tick(Time now) noexcept {
  judge(now);
  send_control(now);
  send_step(now);
}

void CanWalker::judge(Time now) noexcept {
  const auto fresh = [now](const std::optional<Time>& heard, Duration timeout) {
    return heard && now - *heard <= timeout;
  };
  // The checkers are not restarted: a sender stuck on one counter must not pass for alive after each
  // time-out.
  const bool status_fresh = fresh(status_heard_, config_.status_timeout);
  const bool chest_fresh = fresh(chest_heard_, config_.chest_timeout);
  clock_fresh_ = clock_.is_heard(now);
  clock_offset_ = clock_.offset(now);

  if (!status_heard_) {
    health_ = WalkerHealth::kStarting;
  } else if (!status_fresh) {
    health_ = WalkerHealth::kLost;
  } else {
    health_ = chest_fresh ? WalkerHealth::kReady : WalkerHealth::kNoChest;
  }
}

WalkerCounts CanWalker::counts() const noexcept {
  WalkerCounts sum{.undeclared = undeclared_};
  for (const bus::ProtectionChecker* c :
       {&status_checker_, &xy_checker_, &rotation_checker_, &time_checker_}) {
    sum.wrong_crc += c->counts().wrong_crc;
    sum.repeated += c->counts().repeated;
    sum.wrong_sequence += c->counts().wrong_sequence;
    sum.lost += c->counts().lost;
  }
  return sum;
}

}  // namespace headway::drivers
