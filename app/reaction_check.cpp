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

void ReactionCheck::expose(Time exposure, const sim::Scene& scene, const PairSight& sight,
                           const Eigen::Isometry3d& map_from_view, const Vector2d& robot) {
  const sim::World& world = scene.world();
  const sim::WorldState& state = scene.state();
  const auto still = static_cast<int>(world.things.size());
  if (std::none_of(state.set_off.begin(), state.set_off.end(), [](const auto& t) { return t.has_value(); }))
    return;
  Picture picture{exposure, map_from_view, sim::moving_poses(world, state), {}};
  std::vector<int> rays(world.moving.size(), 0);
  for (int v = kStride / 2; v < sight.camera.height; v += kStride)
    for (int u = kStride / 2; u < sight.camera.width; u += kStride) {
      const Vector3d ray = sight.camera.point(u, v, 1);
      const sim::RayHit hit =
          scene.cast(map_from_view.translation(), map_from_view.linear() * ray, sight.farthest);
      if (hit.surface < still) continue;
      const Vector3d seen = static_cast<double>(hit.distance) * ray, p = map_from_view * seen;
      const auto thing = static_cast<std::size_t>(hit.surface - still);
      if (!state.set_off[thing] || !sight.in_view(seen) || !sight.in_sight(scene, map_from_view, p)) continue;
      ++rays[thing];
      if (p.z() > heights_.floor_tolerance && p.z() < heights_.body_height)
        picture.parts.push_back({thing, picture.things[thing].lifted().inverse() * p});
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
  pictures_.push_back(std::move(picture));
  if (pictures_.size() > kKept) pictures_.pop_front();
}

std::span<const Pose2> ReactionCheck::Steps::from(std::uint32_t index) const {
  const std::size_t done = index > first_index ? index - first_index : 0;
  return std::span(bases).subspan(std::min(done, bases.size()));
}

const ReactionCheck::Picture* ReactionCheck::picture_of(Time exposure) const {
  const auto found = std::find_if(pictures_.begin(), pictures_.end(),
                                  [&](const Picture& p) { return p.exposure == exposure; });
  return found == pictures_.end() ? nullptr : &*found;
}

bool ReactionCheck::may_change(const nav::Committed& committed) const {
  return !walked_.bases.empty() && !committed.at_rest && walked_.session == committed.session &&
         walked_.first_index <= committed.next_index;
}

/// Whether parts, with their things where they are now, lie on steps.
bool ReactionCheck::on_steps(const std::vector<Part>& parts, const Picture& now,
                             const Eigen::Isometry3d& map_from_view, std::span<const Pose2> bases) const {
  const Eigen::Isometry3d believed = map_from_view * now.map_from_view.inverse();
  return std::count_if(parts.begin(), parts.end(), [&](const Part& part) {
           const Vector2d p = (believed * (now.things[part.thing].lifted() * part.at)).head<2>();
           return std::any_of(bases.begin(), bases.end(), [&](const Pose2& base) {
             return nav::distance_to_square(outline_, base, p, 0) < outline_.clearance();
           });
         }) >= kLeast;
}

void ReactionCheck::decide(Time exposure, const Eigen::Isometry3d& map_from_view,
                           const runtime::Mission& mission, const nav::Committed& committed,
                           const runtime::MotionOrder& order) {
  decided_ = Steps{committed.session, committed.next_index, {}};
  const bool walks = order.walk == runtime::MotionOrder::Walk::kPlan && mission.walk();
  if (walks) {
    const runtime::CurrentWalk& walk = *mission.walk();
    const auto done = static_cast<std::ptrdiff_t>(committed.next_index - walk.first_index);
    decided_->bases.assign(walk.walk.bases.begin() + done, walk.walk.bases.end());
  }
  const Picture* picture = picture_of(exposure);
  if (picture == nullptr) return;
  const auto on = [&](const std::vector<Part>& parts, std::span<const Pose2> bases) {
    return on_steps(parts, *picture, map_from_view, bases);
  };
  if (!open_ && may_change(committed) && on(picture->parts, walked_.from(committed.next_index)))
    open_ = Open{{.shown = exposure}, committed.next_index, picture->parts, false};
  if (!open_ || open_->answered) return;
  if (!on(open_->parts, walked_.from(open_->first_index))) {
    open_->so_far.handed = exposure;
    open_->so_far.left = true;
    close();
    return;
  }
  ++open_->so_far.frames;
  open_->so_far.stopped = !walks;
  open_->answered = !on(open_->parts, decided_->bases);
}

void ReactionCheck::close() {
  reactions_.push_back(open_->so_far);
  open_.reset();
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
      close();
    }
  } else if (open_ && !open_->answered && stands) {
    open_.reset();  // it stood before it had to answer
  }
}

}  // namespace headway::app
