#include "drivers/cia402_head.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "hal/error.h"

namespace headway::drivers {
namespace {

using hal::HeadAngles;
using hal::HeadHealth;

constexpr double kMilliDegrees = 180e3 / std::numbers::pi;  ///< per radian

/// Limits are rounded inwards, but for what is lost in writing degrees as radians.
constexpr double kSlack = 0.05;

std::int32_t to_milli_degrees(double radians) noexcept {
  return static_cast<std::int32_t>(std::lround(std::clamp(radians * kMilliDegrees, -1e9, 1e9)));
}
double to_radians(std::int32_t milli_degrees) noexcept { return milli_degrees / kMilliDegrees; }

std::uint32_t unsigned_milli(double radians) noexcept {
  return static_cast<std::uint32_t>(to_milli_degrees(radians));
}

std::optional<HomingNumbers> numbers_of(const HomingConfig& c) {
  if (c.policy == HomingConfig::Policy::kNone) return std::nullopt;
  return HomingNumbers{.may_move = c.policy == HomingConfig::Policy::kMove,
                       .method = static_cast<std::int8_t>(c.method),
                       .search_speed = unsigned_milli(c.search_speed),
                       .zero_speed = unsigned_milli(c.zero_speed),
                       .acceleration = unsigned_milli(c.acceleration),
                       .longest = c.longest};
}

DriveNumbers numbers_of(const HeadConfig& c, double lower, double upper) {
  return {.lower = static_cast<std::int32_t>(std::ceil(lower * kMilliDegrees - kSlack)),
          .upper = static_cast<std::int32_t>(std::floor(upper * kMilliDegrees + kSlack)),
          .velocity = unsigned_milli(c.limits.velocity),
          .acceleration = unsigned_milli(c.limits.acceleration),
          .quick_stop = unsigned_milli(c.quick_stop_deceleration),
          .following_window = unsigned_milli(c.following_error),
          .following_timeout_ms =
              static_cast<std::uint16_t>(c.following_error_time / std::chrono::milliseconds(1)),
          .cyclic = c.set_points == SetPointMode::kCyclic,
          .may_come_inside = c.may_come_inside && c.set_points == SetPointMode::kProfile,
          .homing = numbers_of(c.homing)};
}

bool is_ours(std::uint8_t node) { return node == 0x11 || node == 0x12; }

const HeadConfig& validated(const HeadConfig& config) {
  config.validate();
  return config;
}

void require(bool fulfilled, const char* what) {
  if (!fulfilled) throw InputError(std::string("head: ") + what);
}

}  // namespace

void HeadConfig::validate() const {
  const double turn = 2 * std::numbers::pi;
  const auto ordered = [&](double lo, double hi) { return lo >= -turn && lo < hi && hi <= turn; };
  require(is_ours(pan_node) && is_ours(tilt_node) && pan_node != tilt_node,
          "the nodes of pan and tilt, expected 0x11 and 0x12 as in config/can/headway.dbc");
  require(ordered(limits.lower.pan, limits.upper.pan),
          "limits of pan, expected lower < upper within one turn");
  require(ordered(limits.lower.tilt, limits.upper.tilt),
          "limits of tilt, expected lower < upper within one turn");
  require(limits.velocity > 1e-3 && limits.velocity < 100, "velocity, expected 0.001..100 rad/s");
  require(limits.acceleration > 1e-3 && limits.acceleration < 1000,
          "acceleration, expected 0.001..1000 rad/s^2");
  require(quick_stop_deceleration > 1e-3 && quick_stop_deceleration < 1000,
          "quick-stop deceleration, expected 0.001..1000 rad/s^2");
  require(following_error > 1e-4 && following_error < turn,
          "following error, expected 0.0001 rad to one turn");
  require(following_error_time > Duration::zero() && following_error_time < std::chrono::seconds(60),
          "following error time, expected up to 60 s");
  if (homing.policy != HomingConfig::Policy::kMove) return;
  require(homing.method != 0 && homing.method >= -128 && homing.method <= 127,
          "homing method, expected one of the drive's manual, -128..127 and not 0");
  require(homing.search_speed > 1e-4 && homing.search_speed <= limits.velocity,
          "homing's search speed, expected 0.0001 rad/s to the head's velocity");
  require(homing.zero_speed > 1e-4 && homing.zero_speed <= limits.velocity,
          "homing's zero speed, expected 0.0001 rad/s to the head's velocity");
  require(homing.acceleration > 1e-3 && homing.acceleration < 1000,
          "homing's acceleration, expected 0.001..1000 rad/s^2");
  require(homing.longest > Duration::zero() && homing.longest <= std::chrono::minutes(10),
          "homing's longest time, expected up to 10 minutes");
}

Cia402Head::Cia402Head(hal::CanBus& bus, const HeadConfig& config)
    : master_(bus),
      pan_(master_, validated(config).pan_node,
           numbers_of(config, config.limits.lower.pan, config.limits.upper.pan), config.timeouts),
      tilt_(master_, config.tilt_node, numbers_of(config, config.limits.lower.tilt, config.limits.upper.tilt),
            config.timeouts) {}

void Cia402Head::receive(const hal::CanFrame& frame) noexcept {
  pan_.receive(frame);
  tilt_.receive(frame);
}

void Cia402Head::tick(Time now) noexcept {
  master_.tick(now);
  const bool fault = pan_.has_failed() || tilt_.has_failed();
  pan_.hold(fault);
  tilt_.hold(fault);
  pan_.tick(now);
  tilt_.tick(now);
  pair_positions();
  state_.health = judge();
  state_.target = {to_radians(pan_.accepted()), to_radians(tilt_.accepted())};
  state_.moving = pan_.is_moving() || tilt_.is_moving();
}

void Cia402Head::command(const HeadAngles& target) noexcept {
  if (state_.health != HeadHealth::kReady || !std::isfinite(target.pan) || !std::isfinite(target.tilt))
    return;
  pan_.aim(to_milli_degrees(target.pan));
  tilt_.aim(to_milli_degrees(target.tilt));
  state_.moving = pan_.is_moving() || tilt_.is_moving();
}

void Cia402Head::recover() noexcept {
  pan_.recover();
  tilt_.recover();
}

void Cia402Head::leave() noexcept {
  pan_.leave();
  tilt_.leave();
}

HeadHealth Cia402Head::judge() const noexcept {
  const auto unhomed = [](const Cia402Drive& drive) {
    return drive.has_failed() && drive.report().failure == DriveFailure::kNotHomed;
  };
  const bool pan_fails = pan_.has_failed() && !unhomed(pan_),
             tilt_fails = tilt_.has_failed() && !unhomed(tilt_);
  if (pan_fails || tilt_fails) return HeadHealth::kFault;
  if (unhomed(pan_) || unhomed(tilt_)) return HeadHealth::kNotHomed;
  if (!pan_.is_ready() || !tilt_.is_ready()) return HeadHealth::kStarting;
  if (pan_.is_silent() || tilt_.is_silent()) return HeadHealth::kDegraded;
  return HeadHealth::kReady;
}

void Cia402Head::pair_positions() noexcept {
  const auto pan = pan_.position_stamp(), tilt = tilt_.position_stamp();
  // Both drives sample at one SYNC; the frame that came first is nearest to it.
  if (!pan || !tilt || std::chrono::abs(*pan - *tilt) > hal::bus::Sync::kCycle / 2) return;
  state_.position = {to_radians(pan_.position()), to_radians(tilt_.position())};
  state_.velocity = {to_radians(pan_.velocity()), to_radians(tilt_.velocity())};
  state_.stamp = std::min(*pan, *tilt);
}

}  // namespace headway::drivers
