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
constexpr int kOffers = 3;
/// Bit 7 acts on its rising edge: up for so long, then down for as long.
constexpr Duration kEdge = std::chrono::milliseconds(100);

constexpr std::int32_t milli(double degrees) noexcept {
  return static_cast<std::int32_t>(degrees * 1000 + (degrees < 0 ? -0.5 : 0.5));
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
      heartbeat_(timeouts.heartbeat) {}

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
    setup_.receive(frame);
  }
}

void Cia402Drive::hear(const DriveStatus& status, Time stamp) noexcept {
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
    case DrivePhase::kRunning:
      heartbeat_.hear(stamp);
      if (!operational) begin();
      break;
    case DrivePhase::kFailed:
      if (report_.failure == DriveFailure::kGone) begin();
      break;
    case DrivePhase::kOrdering:
    case DrivePhase::kSettingUp:
      break;
  }
}

void Cia402Drive::hear(const Emcy& emergency) noexcept {
  report_.emergency_code = emergency.code;
  // Before it runs, the drive may report what happened earlier; its state tells whether that still matters.
  if (emergency.code != 0 && report_.phase == DrivePhase::kRunning) fail(DriveFailure::kEmergency);
}

// --- phases ---

void Cia402Drive::begin() noexcept {
  report_.phase = DrivePhase::kOrdering;
  report_.failure = DriveFailure::kNone;
  report_.abort_code = 0;
  setup_.begin();
  heartbeat_.forget();
  status_heard_.reset();
  motion_heard_.reset();
  silent_ = true;
  start_ordered_ = false;
  state_since_.reset();
  fault_resets_ = 0;
  fault_edge_.reset();
  said_.reset();
}

void Cia402Drive::fail(DriveFailure why) noexcept {
  report_.phase = DrivePhase::kFailed;
  report_.failure = why;
}

void Cia402Drive::recover() noexcept {
  if (has_failed()) begin();
}

void Cia402Drive::tick(Time now) noexcept {
  silent_ = !status_heard_ || now - *status_heard_ > timeouts_.pdo ||  //
            !motion_heard_ || now - *motion_heard_ > timeouts_.pdo;
  if (!has_failed() && heartbeat_.is_missing(now)) fail(DriveFailure::kGone);
  follow_state(now);
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
    case DrivePhase::kRunning:
      run(now);
      break;
    case DrivePhase::kFailed:
      // One that can still hear is told to stand.
      if (!silent_ && report_.state == State::kOperationEnabled) {
        say(cia402::code_of(Command::kEnableOperation) | cia402::control_bit::kHalt, offered_, now);
      }
      break;
  }
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
  const bool in_mode = mode_ == cia402::kProfilePosition;
  if (!silent_ && report_.state == State::kOperationEnabled && in_mode) {
    start_running(now);
    return;
  }
  if (now - *state_since_ > timeouts_.state) {
    fail(report_.state == State::kFault ? DriveFailure::kDriveFault : DriveFailure::kStateTimedOut);
    return;
  }
  // Nothing is switched on before it is known where the head is.
  if (silent_) return;
  const std::uint16_t word =
      report_.state == State::kFault ? reset_fault(now) : cia402::code_of(next_command(now));
  if (!has_failed()) say(word, clamped(position_), now);
}

Command Cia402Drive::next_command(Time now) const noexcept {
  const bool in_mode = mode_ == cia402::kProfilePosition;
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

void Cia402Drive::start_running(Time now) noexcept {
  report_.phase = DrivePhase::kRunning;
  stay();
  accepted_ = offered_ = wanted_;
  unanswered_ = 0;
  handshake_ = Handshake::kWithdrawing;  // an acknowledgement left over must go first
  handshake_since_ = now;
}

void Cia402Drive::stay() noexcept {
  wanted_ = clamped(position_);
  settling_ = true;
}

void Cia402Drive::run(Time now) noexcept {
  if (report_.state == State::kFault || report_.state == State::kFaultReactionActive) {
    fail(DriveFailure::kDriveFault);
    return;
  }
  if (report_.state != State::kOperationEnabled) {
    report_.phase = DrivePhase::kEnabling;  // it quick-stopped or was switched off: up again, without a jump
    return;
  }
  shake_hands(now);
  if (has_failed()) return;
  std::uint16_t word = cia402::code_of(Command::kEnableOperation);
  if (handshake_ == Handshake::kOffered)
    word |= cia402::control_bit::kNewSetPoint | cia402::control_bit::kChangeAtOnce;
  if (held_) word |= cia402::control_bit::kHalt;
  say(word, offered_, now);
}

// --- set-points ---

void Cia402Drive::shake_hands(Time now) noexcept {
  const bool acknowledged = (statusword_ & cia402::status_bit::kSetPointAcknowledged) != 0;
  if (handshake_ == Handshake::kOffered) {
    await_acknowledgement(now);
  } else if (handshake_ == Handshake::kWithdrawing && !acknowledged) {
    handshake_ = Handshake::kIdle;
  } else if (handshake_ == Handshake::kWithdrawing && now - handshake_since_ > timeouts_.set_point) {
    fail(DriveFailure::kSetPointTimedOut);
  }
  const bool news = settling_ || wanted_ != accepted_;
  if (handshake_ == Handshake::kIdle && news && !acknowledged && !held_) {
    // Staying means where it is now, not where it was when it was told to.
    if (settling_) wanted_ = clamped(position_);
    offered_ = wanted_;
    handshake_ = Handshake::kOffered;
    handshake_since_ = now;
  }
}

void Cia402Drive::await_acknowledgement(Time now) noexcept {
  const bool acknowledged = (statusword_ & cia402::status_bit::kSetPointAcknowledged) != 0;
  if (!acknowledged && now - handshake_since_ <= timeouts_.set_point) return;
  handshake_ = Handshake::kWithdrawing;
  handshake_since_ = now;
  if (acknowledged) {
    accepted_ = offered_;
    settling_ = false;
    unanswered_ = 0;
  } else if (++unanswered_ >= kOffers) {
    fail(DriveFailure::kSetPointTimedOut);
  }
}

void Cia402Drive::aim(std::int32_t target) noexcept {
  if (is_ready()) wanted_ = clamped(target);
}

void Cia402Drive::hold(bool hold) noexcept {
  if (held_ && !hold) stay();
  held_ = hold;
}

bool Cia402Drive::is_moving() const noexcept {
  const bool reached = (statusword_ & cia402::status_bit::kTargetReached) != 0;
  return report_.phase == DrivePhase::kRunning && (settling_ || wanted_ != accepted_ || !reached);
}

std::int32_t Cia402Drive::clamped(std::int32_t target) const noexcept {
  return std::clamp(target, numbers_.lower, numbers_.upper);
}

void Cia402Drive::say(std::uint16_t controlword, std::int32_t target, Time now) noexcept {
  const DriveCommand command{
      .controlword = controlword, .mode = cia402::kProfilePosition, .target_deg = 0.001 * target};
  // A target alone is no news: the drive takes it only with bit 4 rising.
  const bool changed = !said_ || said_->controlword != controlword;
  if (!changed && now - said_at_ < DriveCommand::kCycle) return;
  if (!master_.send(command.pack(cia402::kRpdo1Base + node_))) return;
  said_ = command;
  said_at_ = now;
}

}  // namespace headway::drivers
