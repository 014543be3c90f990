// Where nothing closes every way but what came there, it is worth going to see whether it is still there.
#pragma once

#include <Eigen/Core>

#include "nav/doubted_obstacles.h"
#include "nav/floor_map.h"
#include "runtime/mapper.h"

namespace headway::runtime {

/// Steps never commit where the real map has obstacles; only ways are planned through what may have gone.
class SecondLook {
 public:
  /// At most so often for one goal.
  SecondLook(const nav::FloorGrid& grid, int most) : doubted_(grid), most_(most) {}

  /// There is a new goal.
  void forget();
  /// Takes in the map of the newest frame.
  void follow(const Mapper& mapper);
  /// Whether the robot is on its way to see.
  bool on() const { return on_; }
  /// The floor to plan on: while it is on, without what may have gone.
  const nav::FloorMap& floor(const Mapper& mapper) const { return on_ ? hoped_ : mapper.floor(); }

  /// What was not seen standing since `closed`, when the last way was closed, may have gone. False when it
  /// was tried too often, or in vain.
  bool begin(const Mapper& mapper, const Eigen::Vector2d& robot, Time closed);
  /// What was seen standing there since stands for good. Where the robot got nowhere it is not tried again.
  void end(const Mapper& mapper, const Eigen::Vector2d& robot);

 private:
  nav::DoubtedObstacles doubted_;
  int most_, times_ = 0;
  bool on_ = false;
  Eigen::Vector2d from_{0, 0};
  nav::FloorMap hoped_;
};

}  // namespace headway::runtime
