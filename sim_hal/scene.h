// The world as it is at one moment, ready to be looked at and bumped into.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim_hal/solid.h"
#include "sim_hal/world.h"

namespace headway::sim {

struct Onlooker;

/// What the moving things have done so far; with the world it determines everything.
struct WorldState {
  std::vector<std::optional<Time>> set_off;  ///< one per moving thing
  double walked = 0;                         ///< way of the robot [m]
  std::optional<Pose2> robot;                ///< last known pose
  Time now{};
};

constexpr int kFloorSurface = -1;
constexpr int kNoSurface = -2;

/// What a ray met.
struct RayHit {
  int surface = kNoSurface;  ///< index of the solid (things, then moving things), kFloorSurface or kNoSurface
  float distance = std::numeric_limits<float>::infinity();  ///< in lengths of the direction
  Eigen::Vector3f normal{0, 0, 0};                          ///< unit, in the map frame, facing the ray
  Eigen::Vector3f own_point{0, 0, 0};  ///< in the solid's own frame (floor: map frame) [m]

  bool met() const { return surface != kNoSurface; }
};

/// Sixteen rays from one origin.
struct RayPacket {
  static constexpr int kSize = 16;
  int count = kSize;                          ///< the first so many are cast
  std::array<float, kSize> dx{}, dy{}, dz{};  ///< directions, map frame
};

/// A part of the robot that met a solid of the world.
struct Contact {
  std::size_t part = 0;
  std::size_t solid = 0;
};

/// Single-threaded: casting is const and may be shared, moving may not.
class Scene {
 public:
  explicit Scene(World world);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  const World& world() const;
  /// All solids where they are now: things, then moving things.
  const std::vector<Solid>& solids() const;
  /// Texture of a surface; -1 for kNoSurface.
  int texture_of(int surface) const;
  /// "floor", "nothing", or the name of the thing.
  std::string name_of(int surface) const;

  const WorldState& state() const;
  /// Sets the moving things as they are in that state.
  void set_state(const WorldState& state);
  /// Lets time pass with the robot at that true pose: triggers moving things and moves them. Times must not
  /// fall. The onlooker, if any, is the robot.
  void advance(Time now, const Pose2& robot, const Onlooker* onlooker = nullptr);

  /// The first surface along origin + t * direction, t in (0, farthest]. Map frame.
  RayHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
              double farthest = std::numeric_limits<double>::infinity()) const;
  /// The same for a packet; much faster when the rays lie close together.
  void cast(const Eigen::Vector3f& origin, const RayPacket& rays,
            std::array<RayHit, RayPacket::kSize>& hits) const;
  /// Is the way from a to each of the points free of surfaces (its last `tolerance`, a share, not looked at)?
  bool sees(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance = 2e-3) const;
  /// Bit i tells whether point origin + (dx, dy, dz)[i] can be seen from the origin.
  std::uint32_t sees_points(const Eigen::Vector3f& origin, const RayPacket& to_points,
                            float tolerance = 2e-3F) const;

  /// The first contact of the robot's parts (solids in its base frame) with the world's solids. Exact; the
  /// floor does not count. Real-time safe.
  std::optional<Contact> collides(std::span<const Solid> parts, const Pose2& map_from_base) const noexcept;

  /// Truth for evaluation: is a point inside a solid, or below the floor?
  bool occupied(const Eigen::Vector3d& point) const;
  /// Truth for evaluation: distance to the first surface [m] along a direction of any length; infinity if
  /// none.
  double distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headway::sim
