// What rises from the floor by less than the voxels tell, and still trips a robot: thresholds, ducts, boards.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "nav/floor_map.h"
#include "vision/range_view.h"

namespace headway::nav {

struct RaisedFloorConfig {
  /// What rises more than this above z = 0 trips the robot [m]; 0: nothing is looked for.
  double trip_height = 0.025;
  double low_height = 0;      ///< what rises no more than this is low [m]; 0: nothing is
  double highest = 0.15;      ///< what lies higher or as much lower is not looked at: voxels tell it [m]
  double tilt_sigma = 0.003;  ///< of the view's pose, as far as the levelling leaves it open [rad]
  double nearest = 0.5;       ///< what is nearer to the camera over the floor may be the robot's feet [m]

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// Each view has a vote for each cell of which it shows enough points whose height it knows well: whether
/// most of them rise. Noise and what stands beside a cell shift the mean of their heights, but seldom most of
/// them. One vote alone, for or against, does not change what several have agreed on.
class RaisedFloor {
 public:
  /// Throws InputError as RaisedFloorConfig::validate.
  explicit RaisedFloor(const FloorGrid& grid, const RaisedFloorConfig& config = {});

  /// Takes in a view; z = 0 of the map frame is the floor.
  void add(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera);

  /// The cell (of the grid) rises.
  bool raised(const Eigen::Vector2i& cell) const { return votes_[grid_.index(cell)] >= kRaised; }
  /// It rises, and no view of late has shown anything in it that is higher than low.
  bool low(const Eigen::Vector2i& cell) const { return raised(cell) && tall_[grid_.index(cell)] == 0; }
  /// Several views have shown it, and nothing in it rises.
  bool level(const Eigen::Vector2i& cell) const { return level_[grid_.index(cell)] >= kRaised; }
  /// The cells of which one of these became another in the view that was added last.
  const std::vector<Eigen::Vector2i>& changed() const { return changed_; }

 private:
  static constexpr std::uint8_t kRaised = 2, kMost = 3;  ///< votes

  struct Count {
    std::uint16_t points = 0, high = 0, tall = 0;
  };
  void count(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera);
  void count(const Eigen::Vector2i& cell, bool high, bool tall);
  void vote(const Eigen::Vector2i& cell, const Count& count);

  FloorGrid grid_;
  RaisedFloorConfig config_;
  std::vector<Count> counts_;        ///< of the view in hand; FloorGrid::index
  std::vector<std::uint8_t> votes_;  ///< for it less those against, 0 to kMost; FloorGrid::index
  std::vector<std::uint8_t> tall_;   ///< the same for what is higher than low
  std::vector<std::uint8_t> level_;  ///< views in a row in which next to nothing rises, 0 to kMost
  std::vector<Eigen::Vector2i> counted_, changed_;
};

}  // namespace headway::nav
