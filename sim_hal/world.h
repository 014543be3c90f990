// What the simulated world is made of: a plain value, read from a file or built in code.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/pose2.h"
#include "hal/time.h"
#include "sim_hal/solid.h"

namespace headway::sim {

/// How a surface looks. Noise and checker are functions of the point in the object's own frame.
struct Texture {
  enum class Kind { kNoise, kChecker, kPlain };

  std::string name;
  Kind kind = Kind::kNoise;
  double brightness = 0.5;  ///< mean share of the light given back, 0..1
  double contrast =
      0.8;               ///< noise: about two standard deviations over the mean; checker: the full step. 0..1
  double grain = 0.006;  ///< noise: size of the finest grain; checker: edge of a field [m]
  int octaves = 5;       ///< noise: grains of grain, 2 grain, 4 grain ... m
};

/// A thing that stands still.
struct Thing {
  std::string name;
  Solid solid;
  int texture = 0;  ///< index into World::textures
};

/// When a moving thing sets off.
struct Trigger {
  enum class Kind {
    kAtTime,
    kRobotWithin,
    kRobotWalked,
    kRobotSees,  ///< the robot is under way and near, has the place in sight, and could not touch the thing
                 ///< soon
  };

  Kind kind = Kind::kAtTime;
  double value = 0;            ///< [s] of simulated time, or [m]
  Eigen::Vector2d near{0, 0};  ///< kRobotWithin, kRobotSees: the place the robot comes near to [m]
  double warning = 0;  ///< kRobotSees: the robot needs longer than this to touch the thing that set off [s]
};

/// A pose at a time after setting off.
struct TimedPose {
  Duration after{};
  Pose2 pose;
};

/// A thing that moves along a path once triggered and then stays.
struct MovingThing {
  Thing thing;  ///< its solid's pose is that of path.front()
  Trigger starts;
  std::vector<TimedPose> path;  ///< first at 0 s, times strictly rising

  /// Where it is that long after setting off: straight lines between the path's poses, yaw the short way.
  Pose2 pose_at(Duration after) const;
};

struct Goal2 {
  Eigen::Vector2d position{0, 0};
  std::optional<double> yaw;  ///< [rad]
};

/// The floor is the rectangle at z = 0 in which the world lies.
struct Floor {
  Eigen::Vector2d centre{0, 0}, size{20, 20};  ///< [m]
  int texture = 0;
};

struct World {
  std::string name = "world";
  std::uint64_t seed = 1;                    ///< of textures and noise
  Pose2 start;                               ///< of the robot's base
  std::optional<Goal2> goal;                 ///< where to go unless told otherwise
  std::vector<Texture> textures{Texture{}};  ///< never empty; the first is what has no texture named
  Floor floor;
  std::vector<Thing> things;
  std::vector<MovingThing> moving;
  Eigen::Vector3d light{0, 0, 2.6};  ///< of a lamp [m]
  double ambient = 0.55;             ///< share of the light that comes from everywhere, 0..1

  /// All solids as they are before anything moves: things, then moving things (the order of Scene's indices).
  std::vector<Solid> solids() const;
};

/// The first thing standing still whose outline holds a place on the floor and that is in the way of a robot:
/// part of it lies between the heights `low` and `high` [m]. Null when there is none.
const Thing* obstacle_at(const World& world, const Eigen::Vector2d& place, double low, double high);

/// Builders that both the files and random worlds use. Each adds things that share a name and a texture.

/// Four walls of 0.1 m around the inside rectangle, and the floor under it.
void add_room(World& world, const Eigen::Vector2d& centre, const Eigen::Vector2d& size, double height,
              int texture);
/// A wall along a line on the floor.
void add_wall(World& world, const std::string& name, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
              double height, double thickness, int texture);
/// A table: a top of 4 cm on four legs, or on two solid panels at its ends.
void add_table(World& world, const std::string& name, const Pose2& pose, const Eigen::Vector3d& size,
               bool panels, int texture);
/// Shelves: two sides, a back (at its own -x) and `boards` boards.
void add_shelves(World& world, const std::string& name, const Pose2& pose, const Eigen::Vector3d& size,
                 int boards, int texture);

/// A path along poses at constant speed [m/s]; where only the yaw changes it turns at `turning` [rad/s].
std::vector<TimedPose> path_at_speed(const std::vector<Pose2>& poses, double speed, double turning = 0.5);

}  // namespace headway::sim
