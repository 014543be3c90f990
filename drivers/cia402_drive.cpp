#include "drivers/cia402_drive.h"

#include <algorithm>

namespace headway::drivers {

namespace cia402 = hal::cia402;
using hal::bus::DriveCommand;
using hal::bus::DriveMotion;
using hal::bus::DriveStatus;
using hal::bus::Emcy;
using hal::bus::Heartbeat;
using hal::bus::Nmt;
using hal::cia402::Command;
using hal::cia402::State;

namespace {

constexpr int kFaultResets = 3;
/// Bit 7 acts on its rising edge: up for so long, then down for as long.
constexpr Duration kEdge = std::chrono::milliseconds(100);

/// One status may get lost. After more it is not known whether a drive stopped, which the next command would
/// end.
constexpr Duration kStatusHolds = hal::bus::Sync::kCycle * 5 / 2;

/// A joint at its limit may be seen so far beyond it.
constexpr std::int32_t kBeyond = 500;

constexpr std::int32_t milli(double degrees) noexcept {
  return static_cast<std::int32_t>(degrees * 1000 + (degrees < 0 ? -0.5 : 0.5));
}

std::variant<ProfileSetPoints, CyclicSetPoints> set_points_of(const DriveNumbers& n, Duration timeout) {
  const PositionLimits limits{n.lower, n.upper};
  if (!n.cyclic) return ProfileSetPoints(limits, timeout);
  return CyclicSetPoints(limits,
                         {.velocity = static_cast<double>(n.velocity),
                          .acceleration = static_cast<double>(n.acceleration),
                          .period = to_seconds(hal::bus::Sync::kCycle)},
                         timeout);
}

DriveFailure failure_of(DriveSetup::Status status) noexcept {
  switch (status) {
    case DriveSetup::Status::kRefused:
      return DriveFailure::kSetupRefused;
    case DriveSetup::Status::kReadsDifferent:
      return DriveFailure::kSetupReadsDifferent;
    default:
      return DriveFailure::kSetupTimedOut;
  }
}

}  // namespace

Cia402Drive::Cia402Drive(CanopenMaster& master, std::uint8_t node, const DriveNumbers& numbers,
                         const DriveTimeouts& timeouts) noexcept
    : master_(master),
      node_(node),
      numbers_(numbers),
      timeouts_(timeouts),
      setup_(master, node, numbers, timeouts.sdo),
      parting_(master, node, timeouts.sdo),
      heartbeat_(timeouts.heartbeat),
      homing_(numbers.homing),
      set_points_(set_points_of(numbers, timeouts.set_point)) {}

// --- what comes in ---

void Cia402Drive::receive(const hal::CanFrame& frame) noexcept {
  if (frame.id == cia402::kTpdo1Base + node_) {
    if (const auto status = DriveStatus::unpack(frame)) hear(*status, frame.stamp);
  } else if (frame.id == cia402::kTpdo2Base + node_) {
    if (const auto motion = DriveMotion::unpack(frame)) hear(*motion, frame.stamp);
  } else if (frame.id == cia402::kHeartbeatBase + node_) {
    if (const auto heartbeat = Heartbeat::unpack(frame)) hear(*heartbeat, frame.stamp);
  } else if (frame.id == cia402::kEmcyBase + node_) {
    if (const auto emergency = Emcy::unpack(frame)) hear(*emergency);
  } else {
    is_leaving() ? parting_.receive(frame) : setup_.receive(frame);
  }
}

void Cia402Drive::hear(const DriveStatus& status, Time stamp) noexcept {
  const bool stopped = cia402::state_of(status.statusword) == State::kQuickStopActive;
  if (stopped && !was_stopped_ && !is_leaving()) ++report_.quick_stops;
  was_stopped_ = stopped;
  statusword_ = status.statusword;
  mode_ = status.mode;
  status_heard_ = stamp;
}

void Cia402Drive::hear(const DriveMotion& motion, Time stamp) noexcept {
  position_ = milli(motion.position_deg);
  velocity_ = milli(motion.velocity_deg_per_s);
  motion_heard_ = stamp;
}

void Cia402Drive::hear(const Heartbeat& heartbeat, Time stamp) noexcept {
  if (is_leaving()) return;
  if (heartbeat.state == Heartbeat::State::kBootUp) {
    ++report_.boot_ups;
    begin();
    return;
  }
  const bool operational = heartbeat.state == Heartbeat::State::kOperational;
  switch (report_.phase) {
    case DrivePhase::kEnabling:
      heartbeat_.hear(stamp);
      if (!operational) start_ordered_ = false;  // the order to start got lost, or has not arrived yet
      break;
    case DrivePhase::kHoming:
    case DrivePhase::kRunning:
      heartbeat_.hear(stamp);
      if (!operational) set_up_again();
      break;
    case DrivePhase::kFailed:
      if (report_.failure == DriveFailure::kGone) set_up_again();
      break;
    default:
      break;
  }
}

void Cia402Drive::hear(const Emcy& emergency) noexcept {
  report_.emergency_code = emergency.code;
  // Before it runs, the drive may report what happened earlier; its state tells whether that still matters.
  const bool runs = report_.phase == DrivePhase::kRunning || report_.phase == DrivePhase::kHoming;
  if (emergency.code != 0 && runs) fail(DriveFailure::kEmergency);
}

// --- phases ---

void Cia402Drive::begin() noexcept {
  report_.phase = DrivePhase::kOrdering;
  report_.failure = DriveFailure::kNone;
  report_.abort_code = 0;
  setup_.begin();
  homing_.begin();
  heartbeat_.forget();
  status_heard_.reset();
  motion_heard_.reset();
  silent_ = true;
  start_ordered_ = false;
  state_since_.reset();
  was_enabled_ = false;
  fault_resets_ = 0;
  fault_edge_.reset();
  said_.reset();
}

/// Without a boot: what it did meanwhile, for want of our heartbeat or for a reason of its own, may show in
/// its state.
void Cia402Drive::set_up_again() noexcept {
  const bool was = was_enabled_;
  begin();
  was_enabled_ = was;
}

void Cia402Drive::fail(DriveFailure why) noexcept {
  report_.phase = DrivePhase::kFailed;
  report_.failure = why;
}

void Cia402Drive::recover() noexcept {
  if (!has_failed()) return;
  homing_.permit();
  begin();
}

void Cia402Drive::leave() noexcept {
  if (is_leaving()) return;
  const bool answers =
      report_.failure != DriveFailure::kGone && report_.failure != DriveFailure::kSetupTimedOut;
  report_.phase = answers ? DrivePhase::kLeaving : DrivePhase::kLeft;
  parting_.write(hal::cia402::object::kConsumerHeartbeat, 0);
}

bool Cia402Drive::is_leaving() const noexcept { return report_.phase == DrivePhase::kLeaving || has_left(); }

void Cia402Drive::tick(Time now) noexcept {
  silent_ = !status_heard_ || now - *status_heard_ > timeouts_.pdo ||  //
            !motion_heard_ || now - *motion_heard_ > timeouts_.pdo;
  if (!has_failed() && !is_leaving() && heartbeat_.is_missing(now)) fail(DriveFailure::kGone);
  follow_state(now);
  start_where_it_is(now);
  switch (report_.phase) {
    case DrivePhase::kOrdering:
      order_pre_operational();
      break;
    case DrivePhase::kSettingUp:
      set_up(now);
      break;
    case DrivePhase::kEnabling:
      enable(now);
      break;
    case DrivePhase::kHoming:
      home(now);
      break;
    case DrivePhase::kRunning:
      run(now);
      break;
    case DrivePhase::kFailed:
      stand(now);
      break;
    case DrivePhase::kLeaving:
      part(now);
      break;
    case DrivePhase::kLeft:
      break;
  }
}

/// One that can still hear is told to stand; one that looks for home even when it cannot be heard.
void Cia402Drive::stand(Time now) noexcept {
  if (led_) {
    hold(true);
    tell_set_point(now);
  } else if (!homing_.is_done() && report_.state == State::kOperationEnabled) {
    say(cia402::code_of(knows_state(now) ? Command::kEnableOperation : Command::kQuickStop), present_target(),
        now);
  }
}

/// What it does not take it does by itself, when it misses our heartbeat.
void Cia402Drive::part(Time now) noexcept {
  if (!silent_ && report_.state == State::kOperationEnabled) {
    say(cia402::code_of(Command::kQuickStop), present_target(), now);
    return;
  }
  parting_.tick(now);
  if (parting_.status() != SdoClient::Status::kBusy) report_.phase = DrivePhase::kLeft;
}

void Cia402Drive::follow_state(Time now) noexcept {
  const State state = status_heard_ ? cia402::state_of(statusword_) : State::kNotReadyToSwitchOn;
  if (state_since_ && state == report_.state) return;
  report_.state = state;
  state_since_ = now;
}

void Cia402Drive::order_pre_operational() noexcept {
  // PDO mappings may only be written there.
  if (master_.order(Nmt::Command::kEnterPreOperational, node_)) report_.phase = DrivePhase::kSettingUp;
}

void Cia402Drive::set_up(Time now) noexcept {
  setup_.tick(now);
  report_.object = setup_.object();
  switch (setup_.status()) {
    case DriveSetup::Status::kBusy:
      break;
    case DriveSetup::Status::kDone:
      report_.phase = DrivePhase::kEnabling;
      heartbeat_.expect(now);
      state_since_ = now;
      break;
    default:
      report_.abort_code = setup_.abort_code();
      fail(failure_of(setup_.status()));
  }
}

void Cia402Drive::enable(Time now) noexcept {
  if (!start_ordered_) start_ordered_ = master_.order(Nmt::Command::kStart, node_);
  if (was_enabled_ && is_at_fault()) {
    fail(DriveFailure::kDriveFault);
    return;
  }
  if (was_enabled_ && is_quick_stopped()) {
    fail(DriveFailure::kQuickStopped);
    return;
  }
  if (!silent_ && is_too_far_outside()) {
    fail(DriveFailure::kOutsideLimits);
    return;
  }
  const bool in_mode = mode_ == mode_wanted();
  if (!silent_ && report_.state == State::kOperationEnabled && in_mode) {
    report_.phase = homing_.is_done() ? DrivePhase::kRunning : DrivePhase::kHoming;
    was_enabled_ = true;
    return;
  }
  if (now - *state_since_ > timeouts_.state) {
    fail(report_.state == State::kFault ? DriveFailure::kDriveFault : DriveFailure::kStateTimedOut);
    return;
  }
  // Nothing is switched on before it is known where the head is.
  if (silent_ || !knows_state(now)) return;
  const std::uint16_t word =
      report_.state == State::kFault ? reset_fault(now) : cia402::code_of(next_command(now));
  if (!has_failed()) say(word, present_target(), now);
}

Command Cia402Drive::next_command(Time now) const noexcept {
  const bool in_mode = mode_ == mode_wanted();
  // The mode travels with each command; the drive must show it before it gets torque.
  if (report_.state == State::kSwitchedOn && !in_mode) return Command::kSwitchOn;
  if (report_.state == State::kOperationEnabled) return Command::kEnableOperation;
  // Transition 16 is optional: a drive that does not know it goes through Switch on disabled.
  const bool impatient = now - *state_since_ > timeouts_.state / 2;
  if (report_.state == State::kQuickStopActive && impatient) return Command::kDisableVoltage;
  return cia402::towards_operation(report_.state);
}

std::uint16_t Cia402Drive::reset_fault(Time now) noexcept {
  if (!fault_edge_ || now - *fault_edge_ >= 2 * kEdge) {
    if (++fault_resets_ > kFaultResets) {
      fail(DriveFailure::kDriveFault);
      return 0;
    }
    fault_edge_ = now;
  }
  return now - *fault_edge_ < kEdge ? cia402::code_of(Command::kFaultReset) : std::uint16_t{0};
}

/// Set-points begin anew whenever nothing has led the drive for a while, however that came.
void Cia402Drive::start_where_it_is(Time now) noexcept {
  const bool stands_by_us = has_failed() && !silent_ && report_.state == State::kOperationEnabled;
  const bool led = report_.phase == DrivePhase::kRunning || stands_by_us;
  if (!led || !led_) std::visit([&](auto& points) { points.start(position_, now); }, set_points_);
  led_ = led;
}

/// In homing mode nothing moves until bit 4 is set; bit 12 tells whether the drive knows where it is.
void Cia402Drive::home(Time now) noexcept {
  if (is_at_fault()) {
    fail(DriveFailure::kDriveFault);
    return;
  }
  if (report_.state != State::kOperationEnabled) {
    if (homing_.status() == Homing::Status::kMoving) {
      fail(DriveFailure::kHomingFailed);  // interrupted: it is not for the drive to begin again by itself
    } else if (is_quick_stopped()) {
      fail(DriveFailure::kQuickStopped);
    } else {
      report_.phase = DrivePhase::kEnabling;
    }
    return;
  }
  if (mode_ != cia402::kHoming) {  // bit 12 says something else, which nobody here ordered
    if (homing_.status() == Homing::Status::kMoving)
      fail(DriveFailure::kHomingFailed);
    else
      report_.phase = DrivePhase::kEnabling;
    return;
  }
  homing_.tick(silent_ ? std::nullopt : std::optional(statusword_), held_, now);
  if (homing_.status() == Homing::Status::kNotHomed) fail(DriveFailure::kNotHomed);
  if (homing_.status() == Homing::Status::kFailed) fail(DriveFailure::kHomingFailed);
  if (homing_.is_done()) {
    report_.phase = DrivePhase::kEnabling;  // on into the mode for set-points
    state_since_ = now;
    motion_heard_.reset();  // a position from before it was at home means nothing
  }
  if (report_.phase != DrivePhase::kHoming) return;
  if (!knows_state(now)) {
    // One that moves is stopped by the only order that ends no stop of its own.
    if (homing_.status() == Homing::Status::kMoving)
      say(cia402::code_of(Command::kQuickStop), present_target(), now);
    return;
  }
  say(static_cast<std::uint16_t>(cia402::code_of(Command::kEnableOperation) | homing_.bits()),
      present_target(), now);
}

void Cia402Drive::run(Time now) noexcept {
  if (is_at_fault()) {
    fail(DriveFailure::kDriveFault);
    return;
  }
  if (is_quick_stopped()) {
    fail(DriveFailure::kQuickStopped);
    return;
  }
  if (report_.state != State::kOperationEnabled) {
    report_.phase = DrivePhase::kEnabling;  // it was switched off: up again, without a jump
    return;
  }
  tell_set_point(now);
  if (std::visit([](auto& points) { return points.has_timed_out(); }, set_points_))
    fail(DriveFailure::kSetPointTimedOut);
}

// --- set-points ---

void Cia402Drive::tell_set_point(Time now) noexcept {
  if (!knows_state(now)) {
    std::visit([&](auto& points) { points.pause(now); }, set_points_);
    return;
  }
  std::visit(
      [&](auto& points) {
        points.tick(sight(), now, master_.part_until_next_sync());
        const auto word =
            static_cast<std::uint16_t>(cia402::code_of(Command::kEnableOperation) | points.bits());
        if (say(word, points.target(), now)) points.sent();
      },
      set_points_);
}

void Cia402Drive::aim(std::int32_t target) noexcept {
  if (is_ready()) std::visit([&](auto& points) { points.aim(target); }, set_points_);
}

void Cia402Drive::hold(bool hold) noexcept {
  held_ = hold;
  std::visit([&](auto& points) { points.hold(hold, position_); }, set_points_);
}

bool Cia402Drive::is_ready() const noexcept {
  return report_.phase == DrivePhase::kRunning &&
         std::visit([](const auto& points) { return points.is_settled(); }, set_points_);
}

bool Cia402Drive::is_moving() const noexcept {
  return report_.phase == DrivePhase::kRunning &&
         std::visit([&](const auto& points) { return points.is_moving(sight()); }, set_points_);
}

std::optional<Time> Cia402Drive::position_stamp() const noexcept {
  return homing_.is_done() ? motion_heard_ : std::nullopt;
}

std::int32_t Cia402Drive::accepted() const noexcept {
  return std::visit([](const auto& points) { return points.accepted(); }, set_points_);
}

std::int8_t Cia402Drive::mode_wanted() const noexcept {
  if (!homing_.is_done()) return cia402::kHoming;
  return std::visit([](const auto& points) { return points.kMode; }, set_points_);
}

bool Cia402Drive::knows_state(Time now) const noexcept {
  return status_heard_ && now - *status_heard_ <= kStatusHolds;
}

bool Cia402Drive::is_at_fault() const noexcept {
  return report_.state == State::kFault || report_.state == State::kFaultReactionActive;
}

bool Cia402Drive::is_quick_stopped() const noexcept { return report_.state == State::kQuickStopActive; }

/// A position means nothing before the drive is homed.
bool Cia402Drive::is_too_far_outside() const noexcept {
  return !numbers_.may_come_inside && homing_.is_done() &&
         (position_ < numbers_.lower - kBeyond || position_ > numbers_.upper + kBeyond);
}

/// What goes with the commands on the way to Operation enabled. A cyclic one is gone to at once.
std::int32_t Cia402Drive::present_target() const noexcept {
  return numbers_.cyclic ? position_ : std::clamp(position_, numbers_.lower, numbers_.upper);
}

/// True when it went out. In homing mode bit 4 must rise again after a stop.
bool Cia402Drive::say(std::uint16_t controlword, std::int32_t target, Time now) noexcept {
  if (!homing_.is_done() && (held_ || silent_ || has_failed())) {
    controlword = static_cast<std::uint16_t>((controlword & ~cia402::control_bit::kStartHoming) |
                                             cia402::control_bit::kHalt);
  }
  const DriveCommand command{.controlword = controlword, .mode = mode_wanted(), .target_deg = 0.001 * target};
  // In profile position a target alone is no news: the drive takes it only with bit 4 rising. A cyclic one is
  // for the next SYNC, and there is one for each.
  const bool changed = !said_ || said_->controlword != controlword;
  const bool due =
      numbers_.cyclic ? master_.has_just_synced() : changed || now - said_at_ >= DriveCommand::kCycle;
  if (!due || !master_.send(command.pack(cia402::kRpdo1Base + node_))) return false;
  said_ = command;
  said_at_ = now;
  return true;
}

}  // namespace headway::drivers
