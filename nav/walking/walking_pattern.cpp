#include "nav/walking/walking_pattern.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

void require(bool ok, const std::string& what) {
  if (!ok) throw InputError("walking: " + what);
}

/// From 0 to 1 with no velocity or acceleration at either end (minimum jerk).
double smooth(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

/// 0 at both ends with no velocity or acceleration there, 1 in the middle.
double arch(double s) { return 64 * std::pow(s * (1 - s), 3); }

int periods(double duration, double period) { return static_cast<int>(std::lround(duration / period)); }

}  // namespace

void WalkingConfig::validate() const {
  preview.validate();
  require(double_support >= 2 * preview.period, "double_support must last two periods or more");
  require(shortest_step > double_support + 0.1, "shortest_step must leave 0.1 s of single support");
  require(longest_step >= shortest_step, "longest_step must not be shorter than shortest_step");
  require(swing_height >= 0 && swing_height <= 0.3, "swing_height must lie between 0 and 0.3 m");
  require(settled_distance > 0 && settled_speed > 0, "settled_distance and settled_speed must be positive");
  require(preview.window <= 2 * shortest_step - double_support + 1e-9,
          "preview.window must not exceed two of the shortest steps less a double support, or steps not yet "
          "known would matter already");
}

WalkingPattern::WalkingPattern(const WalkingConfig& config, const hal::Stance& start)
    : config_((config.validate(), config)),
      control_(config.preview),
      double_ticks_(periods(config.double_support, config.preview.period)),
      window_ticks_(config.preview.ticks()),
      shift_ticks_(static_cast<int>(window_ticks_) + double_ticks_),
      known_by_(periods(config.known_after(), config.preview.period)),
      shortest_ticks_(periods(config.shortest_step, config.preview.period)) {
  window_.resize(2 * window_ticks_);
  stand_at(start);
}

void WalkingPattern::stand_at(const hal::Stance& start) noexcept {
  planned_ = start;
  planned_left_z_ = planned_right_z_ = 0;
  left_ = {start.left, 0};
  right_ = {start.right, 0};
  phase_ = Phase::kStanding;
  support_ = Support::kBoth;
  closed_ = writing_ = false;
  pushed_ = started_ = landed_ = 0;
  tick_in_step_ = 0;
  rest_ = start.base().position();
  std::fill(window_.begin(), window_.end(), rest_);
  control_.rest_at(rest_);
  sample_.zmp_reference = rest_;
  publish();
}

std::size_t WalkingPattern::queue_free() const noexcept {
  const std::size_t waiting = pushed_ - started_;
  return kQueue - std::min(kQueue, waiting);
}

bool WalkingPattern::push(const hal::Footstep& asked) noexcept {
  const double duration = to_seconds(asked.duration);
  if (closed_ || queue_free() == 0) return false;
  if (duration < config_.shortest_step - 1e-9 || duration > config_.longest_step + 1e-9) return false;
  if (pushed_ > 0 && step(pushed_ - 1).foot == asked.foot) return false;

  double& foot_z = asked.foot == hal::Foot::kLeft ? planned_left_z_ : planned_right_z_;
  Step& next = ring_[pushed_ % kRing];
  next.foot = asked.foot;
  next.lift = planned_.at(asked.foot);
  next.lift_z = foot_z;
  next.support = planned_.at(other(asked.foot));
  next.support_z = asked.foot == hal::Foot::kLeft ? planned_right_z_ : planned_left_z_;
  next.ticks = periods(duration, config_.preview.period);
  next.single_ticks = next.ticks - double_ticks_;
  planned_ = planned_.after(asked);
  foot_z = next.support_z + asked.dz;
  next.landing = planned_.at(asked.foot);
  next.landing_z = foot_z;
  next.clear = asked.clear;
  ++pushed_;
  return true;
}

void WalkingPattern::begin() noexcept {
  if (phase_ != Phase::kStanding || pushed_ == 0 || started_ > 0) return;
  phase_ = Phase::kWalking;
  started_ = 1;
  tick_in_step_ = -shift_ticks_;
  writing_ = true;
  write_step_ = 0;
  write_tick_ = 1 - double_ticks_;
}

void WalkingPattern::abort() noexcept {
  closed_ = true;
  const std::uint32_t kept = started_ == 0 ? 0 : needed(tick_in_step_);
  if (pushed_ <= kept) return;
  pushed_ = kept;
  plan_stance();
}

void WalkingPattern::reopen() noexcept {
  if (phase_ != Phase::kStanding || pushed_ != started_) return;
  pushed_ = started_ = 0;
  closed_ = false;
}

/// Where the feet end up with the steps that are left.
void WalkingPattern::plan_stance() noexcept {
  if (pushed_ == 0) {
    planned_ = {left_.pose, right_.pose};
    planned_left_z_ = left_.z;
    planned_right_z_ = right_.z;
    return;
  }
  const Step& last = step(pushed_ - 1);
  const bool left = last.foot == hal::Foot::kLeft;
  planned_.at(last.foot) = last.landing;
  planned_.at(other(last.foot)) = last.support;
  planned_left_z_ = left ? last.landing_z : last.support_z;
  planned_right_z_ = left ? last.support_z : last.landing_z;
}

/// The window is about to reach the end of the step before, where the weight goes either on to this one or to
/// rest.
std::uint32_t WalkingPattern::needed(int tick) const noexcept {
  if (started_ == 0) return 1;
  if (tick >= known_by_) return started_ + 2;
  return started_ > 1 || tick >= known_by_ - shortest_ticks_ ? started_ + 1 : 1;
}

void WalkingPattern::advance_feet() noexcept {
  if (phase_ != Phase::kWalking) return;
  ++tick_in_step_;
  const Step& now = step(started_ - 1);
  if (tick_in_step_ > 0 && tick_in_step_ < now.single_ticks) {
    const double share = static_cast<double>(tick_in_step_) / now.single_ticks;
    now.clear > 0 ? swing_over(share) : swing(share);
  } else if (tick_in_step_ == now.single_ticks) {
    land();
  } else if (tick_in_step_ == now.ticks) {
    known(started_) ? void(++started_) : void(phase_ = Phase::kSettling);
    tick_in_step_ = 0;
  }
  if (phase_ == Phase::kWalking && pushed_ < needed(tick_in_step_)) closed_ = true;
}

void WalkingPattern::swing(double share) noexcept {
  const Step& now = step(started_ - 1);
  FootPose& foot = now.foot == hal::Foot::kLeft ? left_ : right_;
  foot.pose = interpolate(now.lift, now.landing, smooth(share));
  foot.z = now.lift_z + smooth(share) * (now.landing_z - now.lift_z) + config_.swing_height * arch(share);
  support_ = now.foot == hal::Foot::kLeft ? Support::kRight : Support::kLeft;
}

/// Straight up, over, and straight down: by the time that the sole has gone on by a hundredth of its way it
/// is above what it is to clear.
void WalkingPattern::swing_over(double share) noexcept {
  constexpr double kRise = 0.3, kWait = 0.15;  // of the swing
  const Step& now = step(started_ - 1);
  FootPose& foot = now.foot == hal::Foot::kLeft ? left_ : right_;
  foot.pose =
      interpolate(now.lift, now.landing, smooth(std::clamp((share - kWait) / (1 - 2 * kWait), 0.0, 1.0)));
  const double top = std::max({now.lift_z, now.landing_z, now.support_z}) + now.clear + config_.clearance;
  const double from = share < 0.5 ? now.lift_z : now.landing_z;
  foot.z = from + (top - from) * smooth(std::min(1.0, std::min(share, 1 - share) / kRise));
  support_ = now.foot == hal::Foot::kLeft ? Support::kRight : Support::kLeft;
}

void WalkingPattern::land() noexcept {
  const Step& now = step(started_ - 1);
  (now.foot == hal::Foot::kLeft ? left_ : right_) = {now.landing, now.landing_z};
  support_ = Support::kBoth;
  ++landed_;
}

Eigen::Vector2d WalkingPattern::middle_after(std::uint32_t index) const noexcept {
  return (step(index).support.position() + step(index).landing.position()) / 2;
}

/// The ZMP reference one tick further than the last one written.
Eigen::Vector2d WalkingPattern::next_reference() noexcept {
  if (!writing_) return rest_;
  const Step& s = step(write_step_);
  const Eigen::Vector2d sole = s.support.position();
  const int tick = write_tick_++;
  const auto on_the_way = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, int done) {
    return Eigen::Vector2d(from + (to - from) * done / double_ticks_);
  };
  if (tick <= 0) return on_the_way(rest_, sole, std::max(0, tick + double_ticks_));
  if (tick <= s.single_ticks) return sole;

  const bool goes_on = known(write_step_ + 1);
  if (!goes_on) rest_ = middle_after(write_step_);
  const Eigen::Vector2d reference =
      on_the_way(sole, goes_on ? s.landing.position() : rest_, tick - s.single_ticks);
  if (tick == s.ticks) {
    ++write_step_;
    write_tick_ = 1;
    writing_ = goes_on;
  }
  return reference;
}

void WalkingPattern::write_ahead() noexcept {
  const Eigen::Vector2d reference = next_reference();
  window_[oldest_] = window_[oldest_ + window_ticks_] = reference;
  oldest_ = (oldest_ + 1) % window_ticks_;
}

void WalkingPattern::settle() noexcept {
  if (phase_ != Phase::kSettling) return;
  if ((control_.com() - rest_).norm() > config_.settled_distance) return;
  if (control_.velocity().norm() > config_.settled_speed) return;
  phase_ = Phase::kStanding;
}

const WalkingSample& WalkingPattern::tick() noexcept {
  const std::span<const Eigen::Vector2d> ahead(&window_[oldest_], window_ticks_);
  sample_.zmp_reference = ahead[0];
  control_.tick(ahead);
  advance_feet();
  write_ahead();
  settle();
  publish();
  return sample_;
}

void WalkingPattern::publish() noexcept {
  sample_.com = control_.com();
  sample_.com_velocity = control_.velocity();
  sample_.com_acceleration = control_.acceleration();
  sample_.zmp = control_.zmp();
  sample_.left = left_;
  sample_.right = right_;
  sample_.yaw = hal::Stance{left_.pose, right_.pose}.base().yaw;
  sample_.support = support_;
  sample_.landed = landed_;
}

Duration WalkingPattern::phase_remaining() const noexcept {
  if (phase_ != Phase::kWalking) return {};
  return seconds((step(started_ - 1).ticks - tick_in_step_) * config_.preview.period);
}

}  // namespace headway::nav
