// Where the head looks: at a list of directions one after the other, or at a place on the floor.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "hal/head_kinematics.h"

namespace headway::runtime {

/// Directions to be looked at in turn. Each counts as seen after enough frames were exposed while the head
/// was there.
class Tour {
 public:
  Tour() = default;
  Tour(std::vector<hal::HeadAngles> directions, int frames_each)
      : directions_(std::move(directions)), frames_each_(frames_each) {}

  bool done() const { return at_ >= directions_.size(); }
  const hal::HeadAngles& direction() const { return directions_[at_]; }
  std::size_t seen() const { return at_; }
  std::size_t size() const { return directions_.size(); }
  /// Tells of a frame that was exposed with the head at `angles`. True when that completes a direction.
  bool look(const hal::HeadAngles& angles);

 private:
  std::vector<hal::HeadAngles> directions_;
  int frames_each_ = 1, frames_here_ = 0;
  std::size_t at_ = 0;
};

hal::HeadAngles limited(const hal::HeadAngles& angles, const hal::HeadLimits& limits);

/// The direction, within the limits, in which the camera's axis comes nearest to a point of the map frame.
hal::HeadAngles look_at(const Eigen::Vector3d& point, const Eigen::Isometry3d& map_from_chest,
                        const hal::HeadKinematics& neck, const hal::HeadLimits& limits);

}  // namespace headway::runtime
