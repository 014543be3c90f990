// The whole simulated robot: bus, head drives, control computer and the body that really walks. One call
// moves all of it by one period; what the vision computer may use of it is the bus (and the pictures that are
// taken of the scene), the rest is truth for judging runs.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/head_kinematics.h"
#include "hal/pose2.h"
#include "sim_hal/body.h"
#include "sim_hal/control_computer.h"
#include "sim_hal/fault_schedule.h"
#include "sim_hal/head_drive.h"
#include "sim_hal/sim_bus.h"

namespace headway::sim {

/// A box that is part of the robot, as it really is now.
struct BodyBox {
  std::string part;
  Eigen::Isometry3d map_from_box =
      Eigen::Isometry3d::Identity();  ///< the box is centred on its own frame, upright
  Eigen::Vector3d size{0, 0, 0};      ///< full lengths along x, y, z [m]
};

/// Outer measures of the robot's parts [m]; heights above the floor.
struct BodyShapeConfig {
  double torso_depth = 0.30, torso_width = 0.60, torso_low = 0.75, torso_high = 1.50;
  double legs_depth = 0.30, legs_width = 0.40, legs_low = 0.02, legs_high = 0.75;
  double head_depth = 0.25, head_width = 0.22, head_low = 1.50, head_high = 1.64;
  double foot_length = 0.2172, foot_width = 0.138, foot_low = 0.02,
         foot_high = 0.15;  ///< low: above its sole

  void validate() const;
};

struct RobotConfig {
  SimBusConfig bus{};
  HeadDriveConfig pan{.node = 0x11}, tilt{.node = 0x12};
  ControlComputerConfig control{};
  BodyConfig body{};
  BodyShapeConfig shape{};
  hal::HeadKinematics kinematics{};  ///< chest to left camera
  double feet_apart = 0.19;          ///< at the start [m]
  double frame_rate = 10;            ///< of the cameras [Hz]; 0: none
  Duration first_exposure{};         ///< after the robot is switched on
  FaultPlan faults{};
  std::uint64_t fault_seed = 1;  ///< draws the frames that a share of is hit

  void validate() const;
};

/// The first touch of the robot with its surroundings.
struct Collision {
  Time time{};
  std::string part;    ///< of the robot
  std::string object;  ///< of the world
};

class SimRobot {
 public:
  static constexpr Duration kPeriod = seconds(0.005);

  /// Takes a picture: called at each exposure with its exact time and the true pose at that time.
  using Exposure = std::function<void(Time, const Eigen::Isometry3d& map_from_camera)>;
  /// The name of what a box touches at a time, or nothing.
  using Touch = std::function<std::optional<std::string>(const BodyBox&, Time)>;

  /// Standing at `start` (map frame, between the feet), switched on at `begin`.
  SimRobot(const RobotConfig& config, const Pose2& start, Time begin = Time{});

  void on_exposure(Exposure take) { expose_ = std::move(take); }
  void on_touch(Touch touched) { touched_ = std::move(touched); }

  /// Moves everything to `now`, which lies one period after the last call's (the first: after `begin`).
  void step(Time now);

  /// The vision computer's place on the bus.
  hal::CanBus& bus() { return vision_end_; }

  // Truth.
  Eigen::Isometry3d map_from_chest() const { return chest_; }
  hal::HeadAngles head() const { return {pan_.angle(), tilt_.angle()}; }
  Eigen::Isometry3d map_from_camera() const;
  hal::Stance stance() const { return body_.stance(); }
  Pose2 map_from_base() const { return body_.stance().base(); }
  std::vector<BodyBox> shape() const;
  bool fallen() const { return body_.fallen(); }
  const std::optional<Collision>& collision() const { return collision_; }
  double path_walked() const { return body_.path_walked(); }
  Time now() const { return now_; }

  // Parts, for tests and faults.
  SimBus& can() { return can_; }
  SimBus::Endpoint& vision_end() { return vision_end_; }
  HeadDrive& pan_drive() { return pan_; }
  HeadDrive& tilt_drive() { return tilt_; }
  ControlComputer& control() { return control_; }
  const Body& body() const { return body_; }
  const FaultSchedule& faults() const { return faults_; }

 private:
  void take_pictures(Time before, const Eigen::Isometry3d& chest_before, const hal::HeadAngles& head_before);
  void check_touch();
  void prepare_faults();
  void apply_faults(Time now);
  void begin_or_end(const Fault& fault, bool on, bool any);
  bool hits(std::size_t index, FaultKind kind, const hal::CanFrame& frame);
  Duration lateness(const hal::CanFrame& frame);

  RobotConfig config_;
  Time begin_{}, now_{};
  std::int64_t exposures_ = 0;
  SimBus can_;
  SimBus::Endpoint &vision_end_, &pan_end_, &tilt_end_, &control_end_;
  HeadDrive pan_, tilt_;
  ControlComputer control_;
  Body body_;
  Eigen::Isometry3d chest_;
  Exposure expose_;
  Touch touched_;
  std::optional<Collision> collision_;
  FaultSchedule faults_;
  std::vector<bool> fault_on_;               ///< one per fault of the plan
  std::vector<std::uint64_t> frames_asked_;  ///< for how many frames each was asked whether it hits
};

}  // namespace headway::sim
