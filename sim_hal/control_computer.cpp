#include "sim_hal/control_computer.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "hal/error.h"
#include "hal/step_number.h"

namespace headway::sim {
namespace {

namespace bus = hal::bus;

void require(bool ok, const std::string& what) {
  if (!ok) throw InputError("control_computer: " + what);
}

hal::Footstep footstep_of(const bus::StepCommand& c) {
  return {c.foot == bus::StepCommand::Foot::kLeft ? hal::Foot::kLeft : hal::Foot::kRight,
          {c.dx, c.dy, c.dtheta},
          c.dz,
          seconds(c.duration),
          c.clear};
}

hal::WalkOrder order_of(const bus::WalkOrder& m) {
  return {static_cast<hal::WalkOrder::Kind>(m.kind), m.x, m.y, m.theta};
}

}  // namespace

bool StrideLimits::allow(const hal::Footstep& step) const {
  constexpr double kSlack = 1e-9;
  const double side = step.foot == hal::Foot::kLeft ? step.landing.y : -step.landing.y;
  return step.clear <= clear + kSlack &&
         step.landing.x <= (step.clear > 0 ? forward_over : forward) + kSlack &&
         step.landing.x >= -backward - kSlack && side >= nearest_side - kSlack &&
         side <= farthest_side + kSlack && std::abs(step.landing.yaw) <= yaw + kSlack &&
         std::abs(step.dz) <= dz + kSlack;
}

void ControlComputerConfig::validate() const {
  walking.validate();
  gait.validate();
  chest.validate();
  require(limits.forward > 0 && limits.backward >= 0,
          "limits.forward and limits.backward must not be negative");
  require(limits.nearest_side > 0 && limits.farthest_side >= limits.nearest_side,
          "limits.farthest_side must not be less than limits.nearest_side, which must be positive");
  require(limits.yaw >= 0 && limits.dz >= 0, "limits.yaw and limits.dz must not be negative");
  require(control_lost > Duration{}, "control_lost must be positive");
  require(status_period > Duration{} && time_period > Duration{}, "periods must be positive");
}

ControlComputer::ControlComputer(const ControlComputerConfig& config, const hal::Stance& start,
                                 hal::CanBus& bus, Time power_on)
    : config_((config.validate(), config)),
      bus_(bus),
      pattern_(config.walking, start),
      power_on_(power_on),
      now_(power_on),
      step_check_(bus::StepCommand::kDataId),
      order_check_(bus::WalkOrder::kDataId),
      control_check_(bus::WalkControl::kDataId),
      status_out_(bus::WalkStatus::kDataId),
      chest_xy_out_(bus::ChestXY::kDataId),
      chest_zrot_out_(bus::ChestZRot::kDataId),
      time_out_(bus::ControlTime::kDataId),
      next_status_(power_on + config.status_period),
      next_time_(power_on + config.time_period) {}

void ControlComputer::receive(const hal::CanFrame& frame) noexcept {
  if (now_ < up_at_) return;
  switch (frame.id) {
    case bus::StepCommand::kId:
      return take_step(frame);
    case bus::WalkControl::kId:
      return take_control(frame);
    case bus::WalkOrder::kId:
      return take_order(frame);
    default:
      return;
  }
}

void ControlComputer::take_step(const hal::CanFrame& frame) noexcept {
  const auto command = bus::StepCommand::unpack(frame);
  if (!command || !bus::is_usable(step_check_.check(frame))) {
    ++counters_.unusable;
    return;
  }
  const hal::Footstep step = footstep_of(*command);
  if (command->session == session_ && repeats_accepted(command->seq))
    return;  // the next status says so again
  hal::StepReject reason = judge(command->session, command->seq);
  if (reason == hal::StepReject::kNone && !config_.limits.allow(step)) reason = hal::StepReject::kReach;
  if (reason != hal::StepReject::kNone) return reject(command->seq, reason);
  if (!push(step)) return reject(command->seq, hal::StepReject::kReach);
  order_ = {};
}

void ControlComputer::take_order(const hal::CanFrame& frame) noexcept {
  const auto order = bus::WalkOrder::unpack(frame);
  if (!order || !bus::is_usable(order_check_.check(frame))) {
    ++counters_.unusable;
    return;
  }
  if (order->session == session_ && repeats_accepted(order->seq)) return;
  const hal::StepReject reason = judge(order->session, order->seq);
  if (reason != hal::StepReject::kNone) return reject(order->seq, reason);
  const auto steps = nav::steps_of(order_of(*order), pattern_.planned_stance(), last_foot_, config_.gait);
  const auto allowed = [this](const hal::Footstep& step) { return config_.limits.allow(step); };
  if (!steps || !std::ranges::all_of(steps->all(), allowed) || !push(steps->steps[0]))
    return reject(order->seq, hal::StepReject::kReach);
  order_ = *steps;
  order_done_ = 1;
  ++counters_.orders;
}

bool ControlComputer::push(const hal::Footstep& step) noexcept {
  if (!pattern_.push(step)) return false;
  ++accepted_;
  ++counters_.accepted;
  last_foot_ = step.foot;
  reject_reason_ = hal::StepReject::kNone;
  return true;
}

/// Accepts the order's steps up to that number.
void ControlComputer::release(std::uint8_t last_seq) noexcept {
  std::uint32_t more = (last_seq + 1 + hal::kStepNumbers - hal::wire_number(accepted_)) % hal::kStepNumbers;
  if (more > hal::kStepNumbers / 2) return;  // it lies behind
  while (more-- > 0 && order_done_ < order_.count && push(order_.steps[order_done_])) ++order_done_;
}

void ControlComputer::reject(std::uint8_t seq, hal::StepReject reason) noexcept {
  ++counters_.rejected;
  rejected_ = seq;
  reject_reason_ = reason;
}

bool ControlComputer::repeats_accepted(std::uint8_t seq) const noexcept {
  const std::uint32_t back = (accepted_ - seq) % hal::kStepNumbers;
  return back >= 1 && back <= std::min(accepted_, hal::kStepNumbers / 2);
}

hal::StepReject ControlComputer::judge(std::uint8_t session, std::uint8_t seq) const noexcept {
  using enum hal::StepReject;
  if (failed_ || rejecting_) return kState;
  if (session_ == 0 || session != session_) return kSession;
  if (pattern_.closed()) return stop_asked_ ? kState : kLate;
  if (seq != hal::wire_number(accepted_)) return kSequence;
  return pattern_.queue_free() == 0 ? kFull : kNone;
}

void ControlComputer::take_control(const hal::CanFrame& frame) noexcept {
  const auto control = bus::WalkControl::unpack(frame);
  if (!control || !bus::is_usable(control_check_.check(frame))) {
    ++counters_.unusable;
    return;
  }
  using enum bus::WalkControl::Request;
  if (control->session == session_) {
    control_heard_ = frame.stamp;
    release(control->last_seq);
  }
  switch (control->request) {
    case kNone:
      return;
    case kWalk:
      if (control->session != session_ && control->session != 0) {
        control_heard_ = frame.stamp;
        open_session(control->session);
      }
      return;
    case kSmoothStop:
      return stop();
    case kAbort:
      stop();
      return pattern_.abort();
  }
}

/// A new walk begins only from a stand; until then the request is heard again and again.
void ControlComputer::open_session(std::uint8_t session) noexcept {
  if (failed_ || pattern_.phase() != nav::WalkingPattern::Phase::kStanding) return;
  if (pattern_.pushed() != pattern_.started()) return;
  pattern_.reopen();
  session_ = session;
  accepted_ = 0;
  last_foot_.reset();
  order_ = {};
  order_done_ = 0;
  stop_asked_ = false;
  reject_reason_ = hal::StepReject::kNone;
  rejected_ = 0;
}

void ControlComputer::stop() noexcept {
  if (pattern_.closed()) return;
  stop_asked_ = true;
  pattern_.close();
}

/// The vision computer that is not heard any more asks for a stop.
void ControlComputer::watch() noexcept {
  if (session_ != 0 && now_ - control_heard_ >= config_.control_lost) stop();
  pattern_.begin();
}

void ControlComputer::tick(Time now) noexcept {
  now_ = now;
  if (!failed_) {
    watch();
    pattern_.tick();
  }
  if (now_ >= next_status_) {
    next_status_ += config_.status_period;
    report_walk();
    report_chest();
  }
  if (now_ >= next_time_) {
    next_time_ += config_.time_period;
    report_time();
  }
}

void ControlComputer::fail() noexcept { failed_ = true; }

void ControlComputer::restart(Duration boot) noexcept {
  up_at_ = power_on_ = now_ + boot;
  if (pattern_.started() == 0) pattern_.abort();
  pattern_.close();
  session_ = 0;
  accepted_ = 0;
  last_foot_.reset();
  order_ = {};
  order_done_ = 0;
  stop_asked_ = false;
  rejected_ = 0;
  reject_reason_ = hal::StepReject::kNone;
  step_check_ = bus::ProtectionChecker(bus::StepCommand::kDataId);
  order_check_ = bus::ProtectionChecker(bus::WalkOrder::kDataId);
  control_check_ = bus::ProtectionChecker(bus::WalkControl::kDataId);
  status_out_ = bus::Protector(bus::WalkStatus::kDataId);
  chest_xy_out_ = bus::Protector(bus::ChestXY::kDataId);
  chest_zrot_out_ = bus::Protector(bus::ChestZRot::kDataId);
  time_out_ = bus::Protector(bus::ControlTime::kDataId);
  sample_ = 0;
  next_status_ = up_at_ + config_.status_period;
  next_time_ = up_at_ + config_.time_period;
}

Eigen::Isometry3d ControlComputer::odom_from_chest() const noexcept {
  const nav::WalkingSample& s = pattern_.sample();
  return chest_pose(config_.chest, s.com, s.com_acceleration, s.yaw);
}

hal::WalkStatus ControlComputer::status() const noexcept {
  using Phase = nav::WalkingPattern::Phase;
  hal::WalkStatus s;
  s.state = failed_                                                     ? hal::WalkState::kFault
            : pattern_.phase() == Phase::kStanding                      ? hal::WalkState::kStanding
            : pattern_.phase() == Phase::kSettling || pattern_.closed() ? hal::WalkState::kStopping
                                                                        : hal::WalkState::kWalking;
  s.session = session_;
  const bool stepped = session_ != 0 && pattern_.started() > 0;
  s.executing = stepped ? hal::wire_number(pattern_.started() - 1) : hal::kNoStep;
  s.accepted = accepted_ == 0 ? hal::kNoStep : hal::wire_number(accepted_ - 1);
  s.rejected = rejected_;
  s.reject_reason = reject_reason_;
  s.queue_free = static_cast<int>(pattern_.queue_free());
  s.phase_remaining = pattern_.phase_remaining();
  s.stamp = now_;
  return s;
}

template <class Message>
void ControlComputer::send(const Message& message, bus::Protector& protector) noexcept {
  std::optional<hal::CanFrame> frame = message.pack();
  if (!frame) return;
  protector.protect(*frame);
  bus_.send(*frame);
}

void ControlComputer::report_walk() noexcept {
  const hal::WalkStatus s = status();
  bus::WalkStatus m;
  m.state = static_cast<bus::WalkStatus::State>(s.state);
  m.seq_executing = s.executing;
  m.seq_accepted = s.accepted;
  m.queue_free = static_cast<std::uint8_t>(s.queue_free);
  m.reject_reason = static_cast<bus::WalkStatus::RejectReason>(s.reject_reason);
  m.phase_remaining = std::min(to_seconds(s.phase_remaining), 4.095);
  m.support_foot = static_cast<bus::WalkStatus::SupportFoot>(pattern_.sample().support);
  m.session = s.session;
  m.seq_rejected = s.rejected;
  send(m, status_out_);
}

void ControlComputer::report_chest() noexcept {
  const Eigen::Isometry3d chest = odom_from_chest();
  const Eigen::Matrix3d r = chest.linear();
  bus::ChestXY xy;
  xy.sample = sample_;
  xy.x = chest.translation().x();
  xy.y = chest.translation().y();
  xy.age = 0;
  bus::ChestZRot zrot;
  zrot.sample = sample_;
  zrot.z = chest.translation().z();
  zrot.roll = std::atan2(r(2, 1), r(2, 2));
  zrot.pitch = -std::asin(std::clamp(r(2, 0), -1.0, 1.0));
  zrot.yaw = std::atan2(r(1, 0), r(0, 0));
  send(xy, chest_xy_out_);
  send(zrot, chest_zrot_out_);
  sample_ = static_cast<std::uint8_t>((sample_ + 1) % 16);
}

void ControlComputer::report_time() noexcept {
  using std::chrono::duration_cast, std::chrono::milliseconds;
  bus::ControlTime m;
  m.ms = static_cast<std::uint32_t>(duration_cast<milliseconds>(now_ - power_on_).count());
  send(m, time_out_);
}

}  // namespace headway::sim
