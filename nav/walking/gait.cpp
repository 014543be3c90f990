#include "nav/walking/gait.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "hal/error.h"

namespace headway::nav {

namespace {

constexpr double kWireYaw = 2e-3;  // hal::quantised

void expect(bool good, const std::string& key, double value, const std::string& expected) {
  if (!good) throw InputError("gait: " + key + ": is " + std::to_string(value) + ", expected " + expected);
}

}  // namespace

double GaitLimits::yaw_on_the_wire() const { return kWireYaw * std::floor(yaw / kWireYaw + 1e-6); }

double GaitLimits::turn_seconds(double angle) const {
  return std::abs(angle) / yaw * to_seconds(step_duration);
}

double GaitLimits::forward_seconds(double metres) const {
  return metres / forward * to_seconds(step_duration);
}

double GaitLimits::sideway_seconds(double metres) const {
  return metres / outward * 2 * to_seconds(step_duration);
}

void GaitLimits::validate() const {
  expect(feet_apart > sole_width && feet_apart <= 0.5, "feet_apart", feet_apart,
         "more than sole_width, to 0.5 m");
  expect(forward >= 0.02 && forward <= 0.5, "forward", forward, "0.02 to 0.5 m");
  expect(forward_on_arc >= 0.01 && forward_on_arc <= forward, "forward_on_arc", forward_on_arc,
         "0.01 m to forward");
  expect(arc_begins >= 0 && arc_begins <= yaw, "arc_begins", arc_begins, "0 to yaw");
  expect(backward >= feet_apart * std::sin(yaw) / 2 && backward <= 0.2, "backward", backward,
         "what turning in place asks for (half of feet_apart * sin(yaw)) to 0.2 m");
  expect(outward >= 0.01 && outward <= 0.3, "outward", outward, "0.01 to 0.3 m");
  expect(inward >= feet_apart * (1 - std::cos(yaw)) / 2 && feet_apart - inward > sole_width, "inward", inward,
         "what turning in place asks for, and soles that never touch");
  expect(yaw >= 0.01 && yaw <= 0.5, "yaw", yaw, "0.01 to 0.5 rad");
  expect(step_duration >= seconds(0.25) && step_duration <= seconds(1.55), "step_duration",
         to_seconds(step_duration), "0.25 to 1.55 s");
  expect(sole_length > 0 && sole_length <= 0.5, "sole_length", sole_length, "0 to 0.5 m");
  expect(zmp_margin >= 0 && 2 * zmp_margin < std::min(sole_length, sole_width), "zmp_margin", zmp_margin,
         "0 m to less than half of the sole");
  expect(sole_width > 0 && sole_width <= 0.3, "sole_width", sole_width, "0 to 0.3 m");
  expect(over.height >= 0 && over.height <= 0.14, "step_over: height", over.height, "0 to 0.14 m");
  if (over.height <= 0) return;  // no such steps
  expect(over.forward >= forward && over.forward <= 0.5, "step_over: forward", over.forward,
         "gait.forward to 0.5 m");
  expect(over.margin >= 0 && over.margin <= 0.1, "step_over: margin", over.margin, "0 to 0.1 m");
  expect(over.duration >= step_duration && over.duration <= seconds(1.55), "step_over: seconds",
         to_seconds(over.duration), "step_seconds to 1.55 s");
  expect(over.cost >= 0 && over.cost <= 100, "step_over: cost_seconds", over.cost, "0 to 100 s");
}

WalkingConfig walking_config(const GaitLimits& limits) {
  WalkingConfig walking;
  const double step = 0.05 * std::floor(to_seconds(limits.step_duration) / 0.05 + 1e-6);  // as on the wire
  walking.shortest_step = std::min(walking.shortest_step, step);
  walking.preview.window =
      std::min(walking.preview.window, 2 * walking.shortest_step - walking.double_support);
  return walking;
}

Pose2 gait_base(const hal::Stance& stance, std::optional<hal::Foot> last_foot, const GaitLimits& gait) {
  if (!last_foot) return stance.base();
  const double side = *last_foot == hal::Foot::kLeft ? 1 : -1;
  return stance.at(*last_foot) * Pose2{0, -side * gait.feet_apart / 2, 0};
}

bool within_limits(const hal::Footstep& step, const GaitLimits& limits) {
  constexpr double kSlack = 1e-4;
  const double side = step.foot == hal::Foot::kLeft ? step.landing.y : -step.landing.y;
  const double turn = std::abs(step.landing.yaw);
  const double ahead = step.clear > 0             ? limits.over.forward
                       : turn > limits.arc_begins ? limits.forward_on_arc
                                                  : limits.forward;
  return step.clear <= hal::quantised({{}, {}, 0, {}, limits.over.height}).clear &&
         step.landing.x <= ahead + kSlack && step.landing.x >= -limits.backward - kSlack &&
         side <= limits.feet_apart + limits.outward + kSlack &&
         side >= limits.feet_apart - limits.inward - kSlack && turn <= limits.yaw + kSlack;
}

}  // namespace headway::nav
