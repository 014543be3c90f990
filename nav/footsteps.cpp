#include "nav/footsteps.h"

#include <algorithm>
#include <cmath>

#include "nav/low_ahead.h"
#include "nav/path_legs.h"

namespace headway::nav {

namespace {

using Eigen::Vector2d;

constexpr double kCornerSlack = 0.02;        // a leg may end this far short of a corner [m]
constexpr double kGoalSlack = 0.005;         // the last one this far short of the goal [m]
constexpr double kSettleSlack = 0.01;        // off the goal by more than this costs steps of its own [m]
constexpr double kYawSlack = 1.5e-3;         // rounding of the wire [rad]
constexpr double kAlignedToStepOver = 0.03;  // off the leg's direction by no more [rad]
constexpr double kWellKnown = 1.2;           // what lies farther off than this may look other from near [m]
constexpr double kRounding = 1.5e-3;         // of the wire [m]
constexpr std::size_t kTooMany = 20000;

double side_of(hal::Foot foot) { return foot == hal::Foot::kLeft ? 1 : -1; }
double on_the_wire(double yaw) { return hal::quantised({{}, {0, 0, yaw}}).landing.yaw; }
Vector2d unit(double angle) { return {std::cos(angle), std::sin(angle)}; }
Vector2d left_of(double angle) { return {-std::sin(angle), std::cos(angle)}; }

/// Puts one foot before the other.
class Feet {
 public:
  /// `low`: the floor where some of it is low, else nothing.
  Feet(const hal::Stance& from, hal::Foot first, const FloorMap* low, const GaitLimits& gait)
      : gait_(gait),
        low_(low),
        start_(from.base().position()),
        yaw_(gait.yaw_on_the_wire()),
        stance_(from),
        swing_(first) {
    walk_.from = from;
  }

  Walk take() {
    for (std::size_t i = 0; low_ != nullptr && i < walk_.steps.size(); ++i) {
      const Pose2& sole = walk_.stances[i].at(walk_.steps[i].foot);
      walk_.treads_on_low |= well_known(sole) && is_on_low(*low_, gait_, sole);
    }
    return std::move(walk_);
  }
  bool too_many() const { return walk_.steps.size() >= kTooMany; }
  std::size_t count() const { return walk_.steps.size(); }
  const hal::Stance& stance() const { return stance_; }
  /// Carried by the foot that stands.
  Pose2 base() const {
    return stance_.at(hal::other(swing_)) * Pose2{0, -side_of(hal::other(swing_)) * half(), 0};
  }

  void walk(const Leg& leg, bool last) {
    turn_to(leg.yaw, leg.from, yaw_);
    if (leg.sideway) {
      go_sideways(leg, last ? kGoalSlack : kCornerSlack / 2);
    } else {
      go_forward(leg, last ? kGoalSlack : kCornerSlack);
    }
  }

  /// Turns on the spot until no more than `rest` is left.
  void turn_to(double yaw, const Vector2d& spot, double rest) {
    while (!too_many()) {
      const Pose2 b = base();
      const double error = wrap_angle(yaw - b.yaw);
      if (std::abs(error) <= rest) return;
      step({spot.x(), spot.y(), b.yaw + std::clamp(error, -yaw_, yaw_)});
    }
  }

  /// What is left to the goal, in a few short steps.
  void settle(const Vector2d& goal) {
    const double yaw = base().yaw;
    const Vector2d left = goal - base().position();
    if (left.dot(unit(yaw)) > kSettleSlack) go_forward({goal, goal, yaw, yaw, false}, kGoalSlack);
    const double aside = (goal - base().position()).dot(left_of(yaw));
    if (std::abs(aside) <= kSettleSlack) return;
    const double direction = yaw + std::copysign(std::numbers::pi / 2, aside);
    go_sideways({goal, goal, yaw, direction, true}, kGoalSlack);
  }

  void close() {
    while (!parallel() && !too_many()) step(base());
  }

  bool parallel() const {
    const hal::Stance closed = hal::Stance::parallel(base(), gait_.feet_apart);
    const Pose2 off = closed.at(swing_).inverse() * stance_.at(swing_);
    return off.position().norm() < 1e-6 && std::abs(off.yaw) < 1e-6;
  }

 private:
  double half() const { return gait_.feet_apart / 2; }
  bool well_known(const Pose2& sole) const { return (sole.position() - start_).norm() <= kWellKnown; }

  void go_forward(const Leg& leg, double slack) {
    const std::vector<LowStretch> stretches = low_on(leg);
    while (!too_many()) {
      const Pose2 b = base();
      const double error = wrap_angle(leg.yaw - b.yaw);
      const Vector2d left = leg.to - b.position();
      const double ahead = left.dot(unit(leg.yaw));
      if (ahead <= slack) return;
      const double turn = std::clamp(error, -yaw_, yaw_);
      const Stride stride = over(stretches, leg, ahead / std::ceil((ahead - slack) / gait_.forward));
      if (stride.impossible) {
        walk_.treads_on_low = true;
        return;
      }
      const bool aligned = std::abs(error) <= kAlignedToStepOver;
      const double length = stride.clear > 0 && !aligned ? 0 : stride.length;
      const Vector2d next =
          b.position() + length * unit(leg.yaw) + left.dot(left_of(leg.yaw)) * left_of(leg.yaw);
      step({next.x(), next.y(), b.yaw + turn}, aligned ? stride.clear : 0);
    }
  }

  struct Stride {
    double length, clear = 0;
    bool impossible = false;
  };

  std::vector<LowStretch> low_on(const Leg& leg) const {
    if (low_ == nullptr) return {};
    const double from = base().position().dot(unit(leg.yaw)), to = leg.to.dot(unit(leg.yaw));
    const double known = start_.dot(unit(leg.yaw)) + kWellKnown;
    return low_ahead(*low_, leg.to, leg.yaw, from - gait_.over.forward,
                     std::min(to + gait_.over.forward, known), gait_);
  }

  /// A stride that treads on nothing low: as long as asked for, or up to what is low, or over it.
  Stride over(const std::vector<LowStretch>& stretches, const Leg& leg, double length) const {
    const double standing = base().position().dot(unit(leg.yaw)),
                 swinging = stance_.at(swing_).position().dot(unit(leg.yaw));
    for (const LowStretch& low : stretches) {
      if (swinging >= low.end - kRounding || standing + length <= low.begin + kRounding) continue;
      const double least = low.end - standing, before = low.begin - standing;
      const double next = &low == &stretches.back() ? length : (&low + 1)->begin - standing;
      const double beyond = std::max(least, std::min(length, next));
      if (beyond <= gait_.over.forward) return {beyond, gait_.over.height};
      if (before < -gait_.backward || swinging >= low.begin - kRounding) return {0, 0, true};
      return {before};
    }
    return {length};
  }

  void go_sideways(const Leg& leg, double slack) {
    const double side = std::sin(leg.direction - leg.yaw) > 0 ? 1 : -1;
    while (!too_many()) {
      const Pose2 b = base();
      const Vector2d left = leg.to - b.position();
      const double aside = side * left.dot(left_of(leg.yaw));
      if (aside <= slack) return;
      const double turn = std::clamp(wrap_angle(leg.yaw - b.yaw), -yaw_, yaw_);
      Vector2d next = b.position();
      if (side_of(swing_) == side) {
        const double share = 1 / std::ceil((aside - slack) / gait_.outward);
        const double ahead = std::clamp(left.dot(unit(leg.yaw)) * share, 0.0, gait_.forward_on_arc);
        next += side * aside * share * left_of(leg.yaw) + ahead * unit(leg.yaw);
      }
      step({next.x(), next.y(), b.yaw + turn});
    }
  }

  /// Swings the free foot to where it would carry `next`, as far as the limits let it; high where something
  /// low lies between, asked for or not.
  void step(const Pose2& next, double clear = 0) {
    const hal::Foot standing = hal::other(swing_);
    const Pose2 foot = next * Pose2{0, side_of(swing_) * half(), 0};
    Pose2 landing = stance_.at(standing).inverse() * foot;
    landing.yaw = on_the_wire(std::clamp(landing.yaw, -yaw_, yaw_));  // which may make it an arc
    const double most = clear > 0                                  ? gait_.over.forward
                        : std::abs(landing.yaw) > gait_.arc_begins ? gait_.forward_on_arc
                                                                   : gait_.forward;
    landing.x = std::clamp(landing.x, -gait_.backward, most);
    const double apart = side_of(swing_) * landing.y;
    landing.y = side_of(swing_) *
                std::clamp(apart, gait_.feet_apart - gait_.inward, gait_.feet_apart + gait_.outward);
    const Pose2 to = stance_.at(standing) * landing;
    if (low_ != nullptr && well_known(to) && passes_low(*low_, gait_, stance_.at(swing_), to))
      clear = gait_.over.height;
    const Duration duration = clear > 0 ? gait_.over.duration : gait_.step_duration;
    const hal::Footstep taken = hal::quantised({swing_, landing, 0, duration, clear});
    stance_ = stance_.after(taken);
    swing_ = standing;
    walk_.add(taken, stance_, base());
  }

  GaitLimits gait_;
  const FloorMap* low_;
  Vector2d start_;
  double yaw_;
  hal::Stance stance_;
  hal::Foot swing_;
  Walk walk_;
};

}  // namespace

Walk place_feet(const Path& path, const hal::Stance& from, std::optional<hal::Foot> last_foot,
                const FloorMap& floor, const GaitLimits& gait) {
  const std::vector<Leg> legs = legs_of(path, floor.grid);
  const FloorMap* low = any_low(floor) ? &floor : nullptr;
  const auto beginning_with = [&](hal::Foot first) {
    Feet feet(from, first, low, gait);
    for (std::size_t i = 0; i < legs.size(); ++i) feet.walk(legs[i], i + 1 == legs.size());
    if (!path.states.empty()) feet.settle(path.end);
    if (path.end_yaw) feet.turn_to(*path.end_yaw, feet.base().position(), kYawSlack);
    feet.close();
    return feet.take();
  };
  if (last_foot) return beginning_with(hal::other(*last_foot));
  // The fewest steps, whichever foot begins; the left one where it makes no difference.
  Walk left = beginning_with(hal::Foot::kLeft), right = beginning_with(hal::Foot::kRight);
  if (left.treads_on_low != right.treads_on_low) return left.treads_on_low ? right : left;
  return right.steps.size() < left.steps.size() ? right : left;
}

}  // namespace headway::nav
