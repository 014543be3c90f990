#include "app/reaction_check.h"

#include <algorithm>
#include <array>

namespace headway::app {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr int kStride = 4;           // pixels between rays
constexpr int kLeast = 4;            // rays that show a thing
constexpr std::size_t kKept = 16;    // exposures whose picture may still be worked on
constexpr double kSamePlace = 0.02;  // moved less, a thing is where it was [m]

}  // namespace

ReactionCheck::ReactionCheck(const nav::BodyOutline& outline, const nav::FloorMapConfig& heights,
                             const sim::Onlooker& onlooker)
    : outline_(outline), heights_(heights), onlooker_(onlooker) {
  outline_.safety_margin /= 2;
}

void ReactionCheck::expose(Time exposure, const sim::Scene& scene, const vision::PinholeCamera& camera,
                           SightRange range, const Eigen::Isometry3d& map_from_view, const Vector2d& robot) {
  const sim::World& world = scene.world();
  const sim::WorldState& state = scene.state();
  const auto still = static_cast<int>(world.things.size());
  if (std::none_of(state.set_off.begin(), state.set_off.end(), [](const auto& t) { return t.has_value(); }))
    return;
  Shown shown{exposure, {}};
  std::vector<int> rays(world.moving.size(), 0);
  for (int v = kStride / 2; v < camera.height; v += kStride)
    for (int u = kStride / 2; u < camera.width; u += kStride) {
      const Vector3d ray = camera.point(u, v, 1);
      const sim::RayHit hit =
          scene.cast(map_from_view.translation(), map_from_view.linear() * ray, range.farthest);
      if (hit.surface < still || static_cast<double>(hit.distance) < range.nearest) continue;
      const auto thing = static_cast<std::size_t>(hit.surface - still);
      const Vector3d p = map_from_view * (static_cast<double>(hit.distance) * ray);
      if (!state.set_off[thing]) continue;
      ++rays[thing];
      if (p.z() > heights_.floor_tolerance && p.z() < heights_.body_height)
        shown.points.push_back(p.head<2>());
    }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool known =
        std::any_of(sightings_.begin(), sightings_.end(), [&](const Sighting& s) { return s.thing == i; });
    if (known || rays[i] < kLeast) continue;
    const sim::MovingThing& thing = world.moving[i];
    const Duration since = state.now - *state.set_off[i];
    const bool moved =
        (thing.pose_at(since).position() - thing.thing.solid.pose.position()).norm() > kSamePlace;
    if (moved)
      sightings_.push_back(
          {i, *state.set_off[i], exposure, sim::soonest_touch(thing, since, robot, onlooker_)});
  }
  shown_.push_back(std::move(shown));
  if (shown_.size() > kKept) shown_.pop_front();
}

int ReactionCheck::on_steps(const std::vector<Vector2d>& points, std::span<const Pose2> bases) const {
  return static_cast<int>(std::count_if(points.begin(), points.end(), [&](const Vector2d& p) {
    return std::any_of(bases.begin(), bases.end(), [&](const Pose2& base) {
      return nav::distance_to_square(outline_, base, p, 0) < outline_.clearance();
    });
  }));
}

void ReactionCheck::decide(Time exposure, const runtime::Mission& mission, const nav::Committed& committed,
                           const runtime::MotionOrder& order) {
  const auto shown =
      std::find_if(shown_.begin(), shown_.end(), [&](const Shown& s) { return s.exposure == exposure; });
  if (!open_ && shown != shown_.end() && !walked_.bases.empty() && !committed.at_rest &&
      walked_.session == committed.session && walked_.first_index <= committed.next_index) {
    const std::size_t done =
        std::min<std::size_t>(committed.next_index - walked_.first_index, walked_.bases.size());
    if (on_steps(shown->points, std::span(walked_.bases).subspan(done)) >= kLeast)
      open_ = Open{{exposure, {}, false, 0}, shown->points, false};
  }
  decided_ = Steps{committed.session, committed.next_index, {}};
  const bool walks = order.walk == runtime::MotionOrder::Walk::kPlan && mission.walk();
  if (walks) {
    const runtime::CurrentWalk& walk = *mission.walk();
    const auto done = static_cast<std::ptrdiff_t>(committed.next_index - walk.first_index);
    decided_->bases.assign(walk.walk.bases.begin() + done, walk.walk.bases.end());
  }
  if (!open_ || open_->answered) return;
  ++open_->so_far.frames;
  open_->so_far.stopped = !walks;
  open_->answered = on_steps(open_->points, decided_->bases) < kLeast;
}

void ReactionCheck::handed(Time now, const runtime::BusLoop& bus) {
  const runtime::BusLoopCounters& counters = bus.counters();
  const bool took = counters.plans_taken > last_.plans_taken;
  const bool stands = bus.committed().stopping || bus.committed().at_rest;
  last_ = counters;
  if (decided_ && (took || (decided_->bases.empty() && stands))) {
    walked_ = *std::move(decided_);
    decided_.reset();
    if (open_ && open_->answered) {
      open_->so_far.handed = now;
      reactions_.push_back(open_->so_far);
      open_.reset();
    }
  } else if (open_ && !open_->answered && stands) {
    open_.reset();  // it stood before it had to answer
  }
}

}  // namespace headway::app
