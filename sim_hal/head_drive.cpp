#include "sim_hal/head_drive.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/error.h"

namespace headway::sim {
namespace {

constexpr double kRadians = std::numbers::pi / 180e3;  ///< of one wire unit, 0.001 deg

// Bits of the controlword (0x6040) in profile position mode.
constexpr unsigned kSwitchOn = 1U << 0, kVoltage = 1U << 1, kNoQuickStop = 1U << 2, kEnable = 1U << 3,
                   kNewSetPoint = 1U << 4, kAtOnce = 1U << 5, kRelative = 1U << 6, kFaultReset = 1U << 7,
                   kHalt = 1U << 8;

// Emergency codes and bits of the error register (0x1001).
constexpr std::uint16_t kFollowingErrorCode = 0x8611, kConnectionCode = 0x8130;
constexpr std::uint8_t kGenericError = 0x01, kCommunicationError = 0x10, kProfileError = 0x20;

}  // namespace

void HeadDriveConfig::validate() const {
  const auto require = [](bool ok, const char* what) {
    if (!ok) throw InputError(std::string("head_drive: ") + what);
  };
  require(node >= 1 && node <= 127, "node must lie between 1 and 127");
  require(std::abs(start_angle) < std::numbers::pi, "start_angle must lie within half a turn");
  require(lag >= 0 && lag <= 1, "lag must lie between 0 and 1 s");
  require(boot_time >= Duration{}, "boot_time must not be negative");
}

HeadDrive::HeadDrive(const HeadDriveConfig& config, hal::CanBus& bus, Time power_on)
    : config_((config.validate(), config)),
      bus_(bus),
      objects_(ObjectDictionary::head_drive(config.node)),
      now_(power_on),
      boots_at_(power_on + config.boot_time),
      profile_(config.start_angle / kRadians),
      demand_(config.start_angle / kRadians),
      actual_(demand_),
      datum_(config.homed ? 0 : actual_),
      homed_(config.homed) {}

double HeadDrive::angle() const { return actual_ * kRadians; }
double HeadDrive::velocity() const { return actual_velocity_ * kRadians; }

bool HeadDrive::has_torque() const {
  return power_ == PowerState::kOperationEnabled || power_ == PowerState::kQuickStopActive ||
         power_ == PowerState::kFaultReactionActive;
}

/// Cyclic synchronous position is what it is led by.
bool HeadDrive::is_cyclic() const {
  return power_ == PowerState::kOperationEnabled && objects_.get(0x6060) == 8;
}

bool HeadDrive::is_homing_mode() const {
  return power_ == PowerState::kOperationEnabled && objects_.get(0x6060) == 6;
}

bool HeadDrive::moving() const { return to_seconds(now_ - profile_start_) < profile_.duration(); }

void HeadDrive::move_to(Time now) noexcept {
  constexpr Duration kStep = std::chrono::milliseconds(1);
  while (now_ < now) {
    const Duration step = std::min(kStep, now - now_);
    now_ += step;
    move_joint(to_seconds(step));
    watch_following_error(to_seconds(step));
    watch_target(to_seconds(step));
    finish_homing();
    finish_stops();
  }
}

void HeadDrive::move_joint(double passed) noexcept {
  if (!has_torque()) {  // the brake holds
    demand_ = actual_;
    demand_velocity_ = actual_velocity_ = 0;
    return;
  }
  const double before = demand_;
  Trapezoid::State wanted = profile_.at(to_seconds(now_ - profile_start_));
  if (is_cyclic()) {
    // Evenly, so that it is there when the next target comes; without one it stays.
    const double period = static_cast<double>(objects_.get(0x60C2, 1)) * 1e-3;
    const double part = std::min(to_seconds(now_ - profile_start_) / period, 1.0);
    const double way = static_cast<double>(target_) - cyclic_from_;
    wanted = {cyclic_from_ + part * way, part < 1 ? way / period : 0};
  }
  demand_ = wanted.position;
  demand_velocity_ = wanted.velocity;
  if (stalled_) {
    actual_velocity_ = 0;
  } else if (config_.lag <= 0) {
    actual_ = demand_;
    actual_velocity_ = demand_velocity_;
  } else if (actual_ != demand_ || before != demand_) {
    // First-order lag behind a demand that moves evenly during the step.
    const double slope = (demand_ - before) / passed;
    const double behind = actual_ - before + slope * config_.lag;
    actual_ = demand_ - slope * config_.lag + behind * std::exp(-passed / config_.lag);
    actual_velocity_ = (demand_ - actual_) / config_.lag;
    if (std::abs(actual_ - demand_) < 1e-6 && slope == 0) actual_ = demand_, actual_velocity_ = 0;
  }
}

void HeadDrive::watch_following_error(double passed) noexcept {
  const auto window = static_cast<double>(objects_.get(0x6065));
  const bool far = has_torque() && window < 0xffffffff && std::abs(demand_ - actual_) > window;
  far_for_ = far ? far_for_ + passed : 0;
  const bool powered = power_ == PowerState::kOperationEnabled || power_ == PowerState::kQuickStopActive;
  if (powered && far_for_ * 1e3 > static_cast<double>(objects_.get(0x6066))) {
    raise_fault(kFollowingErrorCode, kProfileError);
  }
}

void HeadDrive::watch_target(double passed) noexcept {
  const double window = static_cast<double>(objects_.get(0x6067));
  const bool near = std::abs(static_cast<double>(target_) - actual_) <= window;
  reached_for_ = near ? reached_for_ + passed : 0;
  if (power_ != PowerState::kOperationEnabled || halted_ || moving()) return;
  if (!next_target_) return;
  start_motion(*next_target_);
  next_target_.reset();
  acknowledged_ = (control_word_ & kNewSetPoint) != 0;
}

/// What a stop leads to once the joint stands.
void HeadDrive::finish_stops() noexcept {
  if (moving()) return;
  if (power_ == PowerState::kFaultReactionActive) enter(PowerState::kFault);
  if (power_ == PowerState::kQuickStopActive && objects_.get(0x605A) <= 2)
    enter(PowerState::kSwitchOnDisabled);
}

void HeadDrive::obey(std::uint16_t control_word) noexcept {
  const unsigned rising = control_word & ~static_cast<unsigned>(control_word_);
  if (power_ == PowerState::kFault && (rising & kFaultReset) != 0) {
    error_code_ = 0;
    error_register_ = master_lost_ ? kGenericError | kCommunicationError : 0;
    send_emergency(0);
    enter(PowerState::kSwitchOnDisabled);
  }
  if ((control_word & kFaultReset) == 0) change_power(control_word);
  if (is_cyclic())
    take_cyclic_target();
  else if (is_homing_mode())
    take_homing_order(control_word);
  else
    take_set_point(control_word);
  control_word_ = control_word;
}

/// CiA 402 transitions 2 to 12 and 16.
void HeadDrive::change_power(std::uint16_t word) noexcept {
  using enum PowerState;
  const bool on = power_ == kReadyToSwitchOn || power_ == kSwitchedOn || power_ == kOperationEnabled;
  if ((word & kVoltage) == 0) {
    if (on || power_ == kQuickStopActive) enter(kSwitchOnDisabled);  // 7, 9, 10, 12
  } else if ((word & kNoQuickStop) == 0) {
    quick_stop();  // 7, 10, 11
  } else if ((word & kSwitchOn) == 0) {
    if (on || power_ == kSwitchOnDisabled) enter(kReadyToSwitchOn);  // 2, 6, 8
  } else if ((word & kEnable) == 0) {
    if (power_ == kReadyToSwitchOn || power_ == kOperationEnabled) enter(kSwitchedOn);  // 3, 5
  } else if (on) {
    enter(kOperationEnabled);  // 4, or 3 and 4 at once
  } else if (power_ == kQuickStopActive && objects_.get(0x605A) >= 5) {
    enter(kOperationEnabled);  // 16
  }
}

void HeadDrive::enter(PowerState state) noexcept {
  if (state == power_) return;
  if (state == PowerState::kOperationEnabled && power_ != PowerState::kQuickStopActive) {
    profile_ = Trapezoid(actual_);
    profile_start_ = now_;
  }
  if (state == PowerState::kOperationEnabled) {
    target_ = std::llround(profile_.end());
    cyclic_from_ = static_cast<double>(target_);
    halted_ = false;
    far_for_ = 0;
  }
  power_ = state;
  next_target_.reset();
  acknowledged_ = homing_ = false;
}

void HeadDrive::quick_stop() noexcept {
  using enum PowerState;
  if (power_ == kReadyToSwitchOn || power_ == kSwitchedOn) return enter(kSwitchOnDisabled);
  if (power_ != kOperationEnabled) return;
  const std::int64_t option = objects_.get(0x605A);
  if (option == 0) return enter(kSwitchOnDisabled);
  stop_motion(option == 1 || option == 5 ? 0x6084 : 0x6085);
  enter(kQuickStopActive);
}

/// Bits 4 (new set-point), 5 (at once), 6 (relative) and 8 (halt) of profile position mode.
void HeadDrive::take_set_point(std::uint16_t word) noexcept {
  if (power_ != PowerState::kOperationEnabled) return;
  const unsigned rising = word & ~static_cast<unsigned>(control_word_);
  if ((word & kHalt) != 0 && !halted_) stop_motion(0x6084);
  if ((word & kHalt) == 0 && halted_) start_motion(std::llround(static_cast<double>(target_) - datum_));
  halted_ = (word & kHalt) != 0;

  if ((word & kNewSetPoint) == 0 && !next_target_) acknowledged_ = false;
  if ((rising & kNewSetPoint) == 0 || acknowledged_ || objects_.get(0x6060) != 1) return;
  const std::int64_t target =
      objects_.get(0x607A) +
      ((word & kRelative) != 0 ? std::llround(static_cast<double>(target_) - datum_) : 0);
  if ((word & kAtOnce) != 0 || !moving()) {
    start_motion(target);
  } else {
    next_target_ = target;
  }
  acknowledged_ = true;
}

/// Bit 4 starts and keeps it going. Method 37 takes the place where it stands for zero; the others go to a
/// switch, which is at the true zero.
void HeadDrive::take_homing_order(std::uint16_t word) noexcept {
  const unsigned rising = word & ~static_cast<unsigned>(control_word_);
  const bool goes = (word & kNewSetPoint) != 0 && (word & kHalt) == 0;
  if (homing_ && !goes) {
    homing_ = false;
    stop_motion(0x609A);
  }
  if ((rising & kNewSetPoint) == 0 || !goes) return;
  homed_ = false;
  homing_ = true;
  if (objects_.get(0x6098) == 37) datum_ = actual_;
  target_ = std::llround(datum_);
  if (objects_.get(0x6098) != 37) target_ = 0;
  const auto number = [this](std::uint16_t index, std::uint8_t sub) {
    return static_cast<double>(objects_.get(index, sub));
  };
  profile_ = Trapezoid::move({demand_, demand_velocity_}, static_cast<double>(target_), number(0x6099, 1),
                             number(0x609A, 0), number(0x609A, 0));
  profile_start_ = now_;
}

void HeadDrive::finish_homing() noexcept {
  if (!homing_ || moving() || std::abs(static_cast<double>(target_) - actual_) > 1) return;
  datum_ = static_cast<double>(target_);
  homed_ = true;
  homing_ = false;
}

void HeadDrive::take_cyclic_target() noexcept {
  target_ = std::llround(static_cast<double>(limited(objects_.get(0x607A))) + datum_);
  cyclic_from_ = demand_;
  profile_ = Trapezoid(demand_);  // what other modes would go on from
  profile_start_ = now_;
}

/// Within the software position limits; bit 11 of the statusword tells when those were met.
std::int64_t HeadDrive::limited(std::int64_t target) noexcept {
  const std::int64_t low = objects_.get(0x607D, 1), high = objects_.get(0x607D, 2);
  const std::int64_t within = low < high ? std::clamp(target, low, high) : target;
  limited_ = within != target;
  return within;
}

void HeadDrive::start_motion(std::int64_t target) noexcept {
  target_ = std::llround(static_cast<double>(limited(target)) + datum_);
  reached_for_ = 0;
  const auto number = [this](std::uint16_t index) { return static_cast<double>(objects_.get(index)); };
  profile_ = Trapezoid::move({demand_, demand_velocity_}, static_cast<double>(target_), number(0x6081),
                             number(0x6083), number(0x6084));
  profile_start_ = now_;
}

void HeadDrive::stop_motion(std::uint16_t deceleration_object) noexcept {
  profile_ =
      Trapezoid::stop({demand_, demand_velocity_}, static_cast<double>(objects_.get(deceleration_object)));
  profile_start_ = now_;
}

/// Transitions 13 and 14.
void HeadDrive::raise_fault(std::uint16_t code, std::uint8_t error_bit) noexcept {
  using enum PowerState;
  if (power_ == kFault || power_ == kFaultReactionActive) return;
  error_code_ = code;
  error_register_ = static_cast<std::uint8_t>(error_register_ | kGenericError | error_bit);
  send_emergency(code);
  const std::int64_t option = objects_.get(0x605E);
  if (!has_torque() || option == 0) return enter(kFault);
  stop_motion(option == 1 ? 0x6084 : 0x6085);
  enter(kFaultReactionActive);
}

/// What object 0x6007 orders when the master cannot be heard any more.
void HeadDrive::abort_connection() noexcept {
  switch (objects_.get(0x6007)) {
    case 1:
      return raise_fault(kConnectionCode, kCommunicationError);
    case 2:
      return change_power(0);
    case 3:
      return quick_stop();
    default:
      return;
  }
}

std::uint16_t HeadDrive::status_word() const {
  using enum PowerState;
  unsigned word = 1U << 4 | 1U << 9;  // voltage enabled, remote
  switch (power_) {
    case kNotReadyToSwitchOn:
      break;
    case kSwitchOnDisabled:
      word |= 0x40;
      break;
    case kReadyToSwitchOn:
      word |= 0x21;
      break;
    case kSwitchedOn:
      word |= 0x23;
      break;
    case kOperationEnabled:
      word |= 0x27;
      break;
    case kQuickStopActive:
      word |= 0x07;
      break;
    case kFaultReactionActive:
      word |= 0x0f;
      break;
    case kFault:
      word |= 0x08;
      break;
  }
  const bool stopped = halted_ || power_ == kQuickStopActive;
  const bool reached = stopped ? !moving() && std::abs(actual_velocity_) < 10
                               : !moving() && reached_for_ * 1e3 >= static_cast<double>(objects_.get(0x6068));
  if (has_torque() && reached) word |= 1U << 10;
  if (limited_) word |= 1U << 11;
  const bool knows_home = is_homing_mode() && homed_;
  if (acknowledged_ || is_cyclic() || knows_home) word |= 1U << 12;  // or: it follows, it is homed
  if (has_torque() && std::abs(demand_ - actual_) > static_cast<double>(objects_.get(0x6065)))
    word |= 1U << 13;
  return static_cast<std::uint16_t>(word);
}

}  // namespace headway::sim
