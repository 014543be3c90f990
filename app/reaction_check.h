// How soon the robot answers to what moves: when the cameras first show a thing that has set off, when it
// could be touched at the earliest, and how long the steps that it stands on take to be changed.
#pragma once

#include <Eigen/Geometry>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "app/pair_sight.h"
#include "nav/body_outline.h"
#include "nav/floor_map.h"
#include "runtime/bus_loop.h"
#include "runtime/mission.h"
#include "sim_hal/movers.h"
#include "sim_hal/scene.h"

namespace headway::app {

/// Judged by the truth: a raster of rays is cast at each exposure, and tells which moving things the picture
/// shows, and where. A picture shows a thing with four rays that meet it where both cameras see it, and shows
/// it on the steps when four of them end in the room that FloorGate::clear() asks for around the steps that
/// were handed over and can still change. From then on, what they met moves on with its thing. Steps are
/// where the robot plans them in its map, hence so are the things: as seen from where it believes to look
/// from.
class ReactionCheck {
 public:
  struct Sighting {
    std::size_t thing = 0;  ///< index into World::moving
    Time set_off{}, seen{};
    double warning = 0;  ///< from seen until the robot could touch it at the earliest [s]
  };
  struct Reaction {
    Time shown{};   ///< exposure of the first picture that shows a thing on the steps
    Time handed{};  ///< when steps that keep clear of what it showed, or a stop, are taken by the step stack
    bool stopped = false;  ///< it was a stop
    bool left = false;     ///< it left the steps by itself, as the picture exposed at `handed` shows
    int frames = 0;        ///< pictures worked on until then, that one included
  };

  ReactionCheck(const nav::BodyOutline& outline, const nav::FloorMapConfig& heights,
                const sim::Onlooker& onlooker);

  /// At an exposure, with the true pose of the view and the true place of the robot.
  void expose(Time exposure, const sim::Scene& scene, const PairSight& sight,
              const Eigen::Isometry3d& map_from_view, const Eigen::Vector2d& robot);
  /// When the picture of that exposure has been worked on, with the pose that its view was believed to have.
  void decide(Time exposure, const Eigen::Isometry3d& map_from_view, const runtime::Mission& mission,
              const nav::Committed& committed, const runtime::MotionOrder& order);
  /// After each bus cycle.
  void handed(Time now, const runtime::BusLoop& bus);

  const std::vector<Sighting>& sightings() const { return sightings_; }
  const std::vector<Reaction>& reactions() const { return reactions_; }

 private:
  /// A point of a moving thing.
  struct Part {
    std::size_t thing = 0;
    Eigen::Vector3d at;  ///< seen from the thing's pose
  };
  struct Picture {
    Time exposure{};
    Eigen::Isometry3d map_from_view;  ///< the true one
    std::vector<Pose2> things;        ///< where they were, as World::moving
    std::vector<Part> parts;          ///< shown of those that have set off
  };
  /// The steps that can still change, of a plan.
  struct Steps {
    std::uint8_t session = 0;
    std::uint32_t first_index = 0;
    std::vector<Pose2> bases;
    /// Those from this number on.
    std::span<const Pose2> from(std::uint32_t index) const;
  };
  struct Open {
    Reaction so_far;
    std::uint32_t first_index = 0;  ///< of the steps that could change
    std::vector<Part> parts;
    bool answered = false;
  };

  const Picture* picture_of(Time exposure) const;
  bool may_change(const nav::Committed& committed) const;
  bool on_steps(const std::vector<Part>& parts, const Picture& now, const Eigen::Isometry3d& map_from_view,
                std::span<const Pose2> bases) const;
  void close();

  nav::BodyOutline outline_;
  nav::FloorMapConfig heights_;
  const sim::Onlooker& onlooker_;
  std::deque<Picture> pictures_;
  std::vector<Sighting> sightings_;
  std::vector<Reaction> reactions_;
  Steps walked_;                  ///< handed over
  std::optional<Steps> decided_;  ///< not handed over yet
  std::optional<Open> open_;
  runtime::BusLoopCounters last_{};
};

}  // namespace headway::app
