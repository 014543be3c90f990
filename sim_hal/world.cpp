#include "sim_hal/world.h"

#include <algorithm>
#include <cmath>

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d;

namespace {

// Adds boxes given in the frame of a piece of furniture that stands at `pose` on the floor.
class Joiner {
 public:
  Joiner(World& world, std::string name, const Pose2& pose, int texture)
      : world_(world), name_(std::move(name)), pose_(pose), texture_(texture) {}

  void add(const Vector3d& centre, const Vector3d& size) {
    world_.things.push_back({name_, Solid::box(centre, size).moved(pose_), texture_});
  }

 private:
  World& world_;
  std::string name_;
  Pose2 pose_;
  int texture_;
};

}  // namespace

Pose2 MovingThing::pose_at(Duration after) const {
  if (path.empty()) return thing.solid.pose;
  const auto next =
      std::find_if(path.begin(), path.end(), [&](const TimedPose& p) { return p.after > after; });
  if (next == path.begin()) return path.front().pose;
  if (next == path.end()) return path.back().pose;
  const TimedPose& last = *(next - 1);
  return interpolate(last.pose, next->pose,
                     to_seconds(after - last.after) / to_seconds(next->after - last.after));
}

std::vector<Solid> World::solids() const {
  std::vector<Solid> all;
  all.reserve(things.size() + moving.size());
  for (const Thing& t : things) all.push_back(t.solid);
  for (const MovingThing& m : moving) {
    all.push_back(m.thing.solid);
    all.back().pose = m.pose_at(Duration{});
  }
  return all;
}

const Thing* obstacle_at(const World& world, const Eigen::Vector2d& place, double low, double high) {
  for (const Thing& thing : world.things) {
    const Solid& s = thing.solid;
    if (s.top > low && s.bottom < high && s.contains({place.x(), place.y(), s.centre_height()}))
      return &thing;
  }
  return nullptr;
}

void add_room(World& world, const Vector2d& centre, const Vector2d& size, double height, int texture) {
  constexpr double kThick = 0.1;
  const double x = (size.x() + kThick) / 2, y = (size.y() + kThick) / 2;
  Joiner room(world, "room", {centre.x(), centre.y(), 0}, texture);
  room.add({x, 0, height / 2}, {kThick, size.y() + 2 * kThick, height});
  room.add({-x, 0, height / 2}, {kThick, size.y() + 2 * kThick, height});
  room.add({0, y, height / 2}, {size.x(), kThick, height});
  room.add({0, -y, height / 2}, {size.x(), kThick, height});
}

void add_wall(World& world, const std::string& name, const Vector2d& from, const Vector2d& to, double height,
              double thickness, int texture) {
  const Vector2d along = to - from, middle = (from + to) / 2;
  Joiner(world, name, {middle.x(), middle.y(), std::atan2(along.y(), along.x())}, texture)
      .add({0, 0, height / 2}, {along.norm(), thickness, height});
}

void add_table(World& world, const std::string& name, const Pose2& pose, const Vector3d& size, bool panels,
               int texture) {
  constexpr double kTop = 0.04, kLeg = 0.06, kPanel = 0.04;
  Joiner table(world, name, pose, texture);
  const double under = size.z() - kTop;
  table.add({0, 0, under + kTop / 2}, {size.x(), size.y(), kTop});
  for (const double end : {-1.0, 1.0}) {
    if (panels) {
      table.add({end * (size.x() - kPanel) / 2, 0, under / 2}, {kPanel, size.y(), under});
      continue;
    }
    for (const double side : {-1.0, 1.0})
      table.add({end * (size.x() - kLeg) / 2, side * (size.y() - kLeg) / 2, under / 2}, {kLeg, kLeg, under});
  }
}

void add_shelves(World& world, const std::string& name, const Pose2& pose, const Vector3d& size, int boards,
                 int texture) {
  constexpr double kBoard = 0.03;
  Joiner shelves(world, name, pose, texture);
  for (const double side : {-1.0, 1.0})
    shelves.add({0, side * (size.y() - kBoard) / 2, size.z() / 2}, {size.x(), kBoard, size.z()});
  const double between_sides = size.y() - 2 * kBoard;
  shelves.add({-(size.x() - kBoard) / 2, 0, size.z() / 2}, {kBoard, between_sides, size.z()});
  for (int i = 0; i < boards; ++i) {
    const double share = boards == 1 ? 0 : static_cast<double>(i) / (boards - 1);
    shelves.add({kBoard / 2, 0, kBoard / 2 + share * (size.z() - kBoard)},
                {size.x() - kBoard, between_sides, kBoard});
  }
}

std::vector<TimedPose> path_at_speed(const std::vector<Pose2>& poses, double speed, double turning) {
  std::vector<TimedPose> path;
  double time = 0;
  for (const Pose2& pose : poses) {
    if (!path.empty()) {
      const Pose2& last = path.back().pose;
      const double way = (pose.position() - last.position()).norm();
      const double step = way > 0 ? way / speed : std::abs(wrap_angle(pose.yaw - last.yaw)) / turning;
      if (seconds(time + step) <= path.back().after) continue;  // the same place again
      time += step;
    }
    path.push_back({seconds(time), pose});
  }
  return path;
}

}  // namespace headway::sim
