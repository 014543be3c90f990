// What really happens when the control computer walks: a cart of its own, with another height, a lag, feet
// that do not land quite where they should and legs that cannot reach everywhere. It falls when its true ZMP
// leaves the soles. World frame = odometry frame at the start.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <random>

#include "hal/footstep.h"
#include "nav/walking/support_polygon.h"
#include "nav/walking/walking_pattern.h"
#include "sim_hal/chest.h"

namespace headway::sim {

struct BodyConfig {
  double com_height = 0.830;           ///< the true one; the pattern plans with 0.814 [m]
  double lag = 0.010;                  ///< first-order, of the CoM behind its command [s]
  double landing_sigma = 0.0015;       ///< of each landing, x and y [m]
  double landing_yaw_sigma = 0.00175;  ///< [rad]
  double stride_scale = 1.0;           ///< true length of a stride over the one commanded (drift)
  double yaw_per_step = 0.0;           ///< turned too far to the left with each step [rad] (drift)
  double reach = 0.34;                 ///< greatest distance between sole centres [m]
  double swing_speed = 0.85;           ///< greatest mean speed of the swinging foot over the floor [m/s]
  double correction_time = 0.65;       ///< within which the body moves on to where the foot really landed [s]
  double sole_length = 0.2172, sole_width = 0.138;  ///< [m], centred on the foot frame
  double tip_distance = 0.002;                      ///< the ZMP may be outside by this much ...
  Duration tip_time = seconds(0.01);                ///< ... for less than this long: an edge gives a little
  ChestConfig chest{};
  std::uint64_t seed = 1;

  void validate() const;
};

class Body {
 public:
  Body(const BodyConfig& config, const nav::WalkingSample& start);

  /// One period on. `period` [s] between calls; `command` is what the pattern asks for at the end of it.
  void tick(const nav::WalkingSample& command, double period);

  bool fallen() const { return fallen_; }
  /// How far the true ZMP is inside the support polygon, one period ago [m]; negative outside.
  double zmp_margin() const { return margin_; }
  double smallest_margin() const { return smallest_margin_; }
  Eigen::Vector2d zmp() const { return zmp_; }
  Eigen::Vector2d com() const { return com_; }
  const nav::FootPose& foot(hal::Foot f) const { return f == hal::Foot::kLeft ? left_ : right_; }
  hal::Stance stance() const { return {left_.pose, right_.pose}; }
  double yaw() const { return yaw_; }
  Eigen::Isometry3d map_from_chest() const;
  /// Length of the way of the point between the feet [m].
  double path_walked() const { return path_walked_; }

 private:
  /// A rigid motion of the floor: where the true robot is when the believed one is at a pose.
  struct Planar {
    Pose2 truth, believed;
    Pose2 operator()(const Pose2& p) const { return truth * (believed.inverse() * p); }
  };
  Pose2 mapped(const Pose2& believed) const;
  void follow_feet(const nav::WalkingSample& command, double period);
  void land(hal::Foot foot, const nav::WalkingSample& command);
  Pose2 true_landing(hal::Foot foot, const nav::WalkingSample& command);
  void follow_com(const nav::WalkingSample& command, double period);
  void judge_balance(double period);
  nav::SupportPolygon polygon() const;
  nav::FootPose& foot_ref(hal::Foot f) { return f == hal::Foot::kLeft ? left_ : right_; }
  double normal();

  BodyConfig config_;
  std::mt19937_64 random_;
  nav::FootPose left_, right_;
  nav::Support support_ = nav::Support::kBoth;
  Pose2 lifted_;           ///< the swinging foot when it left the floor
  double swing_time_ = 0;  ///< since then [s]

  Planar before_, after_;  ///< the body goes over from one to the other ...
  double correction_ = 1;  ///< ... and is this far [0, 1]

  Eigen::Vector2d wanted_, com_, com_before_, com_before_that_;
  Eigen::Vector2d zmp_, acceleration_{0, 0};
  double yaw_ = 0;
  nav::SupportPolygon polygon_before_;
  double margin_ = 0, smallest_margin_ = 0, outside_for_ = 0;
  bool fallen_ = false;
  double path_walked_ = 0;
};

}  // namespace headway::sim
