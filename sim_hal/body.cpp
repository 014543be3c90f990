#include "sim_hal/body.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/error.h"

namespace headway::sim {
namespace {

using Eigen::Vector2d;
using nav::Support;

constexpr double kGravity = 9.81;

void require(bool ok, const std::string& what) {
  if (!ok) throw InputError("body: " + what);
}

double smooth(double s) { return s * s * s * (10 + s * (6 * s - 15)); }

/// `to`, or the point on the way there that is `limit` away from `from`.
Vector2d within(const Vector2d& from, const Vector2d& to, double limit) {
  const double distance = (to - from).norm();
  return distance <= limit ? to : Vector2d(from + (to - from) * (limit / distance));
}

}  // namespace

void BodyConfig::validate() const {
  require(com_height > 0.05 && com_height < 10, "com_height must lie between 0.05 and 10 m");
  require(lag >= 0 && lag < 0.5, "lag must lie between 0 and 0.5 s");
  require(landing_sigma >= 0 && landing_sigma < 0.1, "landing_sigma must lie between 0 and 0.1 m");
  require(landing_yaw_sigma >= 0 && landing_yaw_sigma < 0.2,
          "landing_yaw_sigma must lie between 0 and 0.2 rad");
  require(stride_scale > 0.5 && stride_scale < 1.5, "stride_scale must lie between 0.5 and 1.5");
  require(std::abs(yaw_per_step) < 0.2, "yaw_per_step must lie within 0.2 rad");
  require(reach > 0.1 && swing_speed > 0.1, "reach and swing_speed must be at least 0.1");
  require(correction_time > 0 && correction_time <= 0.7, "correction_time must lie between 0 and 0.7 s");
  require(sole_length > 0 && sole_width > 0, "soles must have a size");
  require(tip_distance >= 0 && tip_time >= Duration{}, "tip_distance and tip_time must not be negative");
  chest.validate();
}

Body::Body(const BodyConfig& config, const nav::WalkingSample& start)
    : config_((config.validate(), config)),
      random_(config.seed),
      left_(start.left),
      right_(start.right),
      before_{start.left.pose, start.left.pose},
      after_(before_),
      wanted_(start.com),
      com_(start.com),
      com_before_(start.com),
      com_before_that_(start.com),
      zmp_(start.com),
      yaw_(start.yaw),
      polygon_before_(polygon()) {
  margin_ = smallest_margin_ = polygon_before_.margin(zmp_);
}

/// Standard normal by Box and Muller: the same on every machine, unlike std::normal_distribution.
double Body::normal() {
  const auto uniform = [this] { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; };
  const double radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * std::numbers::pi * uniform());
}

void Body::tick(const nav::WalkingSample& command, double period) {
  if (fallen_) return;
  follow_feet(command, period);
  follow_com(command, period);
  judge_balance(period);
}

/// The body is carried by the foot that landed last. It goes over to where that foot really stands within the
/// correction time, smoothly: a jump would be a blow to the ZMP.
Pose2 Body::mapped(const Pose2& believed) const {
  return interpolate(before_(believed), after_(believed), smooth(correction_));
}

void Body::follow_feet(const nav::WalkingSample& command, double period) {
  correction_ = std::min(1.0, correction_ + period / config_.correction_time);
  const Support before = support_;
  support_ = command.support;
  if (support_ == Support::kBoth && before == Support::kBoth) return;
  const hal::Foot swinging =
      (before == Support::kBoth ? support_ : before) == Support::kLeft ? hal::Foot::kRight : hal::Foot::kLeft;
  if (before == Support::kBoth) {
    lifted_ = foot(swinging).pose;
    swing_time_ = 0;
  }
  swing_time_ += period;
  if (support_ == Support::kBoth) return land(swinging, command);
  foot_ref(swinging) = {mapped(command.at(swinging).pose), command.at(swinging).z};
}

Pose2 Body::true_landing(hal::Foot foot_down, const nav::WalkingSample& command) {
  const Pose2& stands = foot(other(foot_down)).pose;
  Pose2 step = command.at(other(foot_down)).pose.inverse() * command.at(foot_down).pose;
  step.x = step.x * config_.stride_scale + config_.landing_sigma * normal();
  step.y += config_.landing_sigma * normal();
  step.yaw += config_.yaw_per_step + config_.landing_yaw_sigma * normal();
  Pose2 landing = stands * step;
  Vector2d place = within(lifted_.position(), landing.position(), config_.swing_speed * swing_time_);
  place = within(stands.position(), place, config_.reach);
  return {place.x(), place.y(), landing.yaw};
}

void Body::land(hal::Foot foot_down, const nav::WalkingSample& command) {
  const Pose2 believed = command.at(foot_down).pose;
  const Vector2d middle = (lifted_.position() + foot(other(foot_down)).pose.position()) / 2;
  before_ = {mapped(believed), believed};
  after_ = {true_landing(foot_down, command), believed};
  correction_ = 0;
  foot_ref(foot_down) = {after_.truth, command.at(foot_down).z};
  path_walked_ += (stance().base().position() - middle).norm();
}

/// First-order lag behind a command that moves evenly during the period.
void Body::follow_com(const nav::WalkingSample& command, double period) {
  const Pose2 wanted = mapped({command.com.x(), command.com.y(), command.yaw});
  com_before_that_ = com_before_;
  com_before_ = com_;
  if (config_.lag <= 0) {
    com_ = wanted.position();
  } else {
    const Vector2d trail = (wanted.position() - wanted_) / period * config_.lag;
    com_ = wanted.position() - trail + (com_ - wanted_ + trail) * std::exp(-period / config_.lag);
  }
  wanted_ = wanted.position();
  yaw_ = wanted.yaw;
}

/// The cart's true ZMP, p = c - z_c/g c'', and whether the soles are under it. The second difference belongs
/// to the tick before.
void Body::judge_balance(double period) {
  acceleration_ = (com_ - 2 * com_before_ + com_before_that_) / (period * period);
  zmp_ = com_before_ - config_.com_height / kGravity * acceleration_;
  margin_ = polygon_before_.margin(zmp_);
  smallest_margin_ = std::min(smallest_margin_, margin_);
  outside_for_ = margin_ < 0 ? outside_for_ + period : 0;
  fallen_ = margin_ < -config_.tip_distance || outside_for_ >= to_seconds(config_.tip_time) - 1e-9;
  polygon_before_ = polygon();
}

nav::SupportPolygon Body::polygon() const {
  const double length = config_.sole_length, width = config_.sole_width;
  switch (support_) {
    case Support::kLeft:
      return {left_.pose, length, width};
    case Support::kRight:
      return {right_.pose, length, width};
    default:
      return {left_.pose, right_.pose, length, width};
  }
}

Eigen::Isometry3d Body::map_from_chest() const {
  return chest_pose(config_.chest, com_, acceleration_, yaw_);
}

}  // namespace headway::sim
