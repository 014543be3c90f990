// A robot as a file (config/hrp2/robot.yaml): everything that the parts of the program must know of it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

#include "drivers/cia402_head.h"
#include "drivers/pixel_format.h"
#include "hal/head_kinematics.h"
#include "nav/levelling.h"
#include "runtime/live_loops.h"
#include "runtime/localisation.h"
#include "runtime/mapper.h"
#include "runtime/mission.h"
#include "sim_hal/body.h"
#include "vision/rig.h"
#include "vision/stereo.h"

namespace headway::app {

struct SimulationConfig {
  double frame_rate = 10;                 ///< [Hz]
  Eigen::Vector2i depth_image{170, 240};  ///< width, height in range mode [px]
  /// What a whole view errs in range mode, in place of localisation's: there is no matcher that errs alike.
  double depth_shift_sigma = 0.008;  ///< [m]
  double depth_turn_sigma = 0.0087;  ///< [rad]
  runtime::StageTimes charge;        ///< per frame
  sim::BodyConfig body;              ///< what the true robot does otherwise than it is told
  double tilt_error = 0;             ///< of the head: true tilt, down, less the one reported [rad]
};

/// What `headway run` opens; of it the simulator needs only how the head is led.
struct HardwareConfig {
  std::string place;        ///< where it stands: "robot.yaml:12", or the file's name where it is absent
  std::string bus;          ///< see can_transport.h
  std::string left, right;  ///< the cameras' device files
  drivers::PixelFormat format = drivers::PixelFormat::kGrey;
  double rate = 15;                                                    ///< of the cameras [Hz]
  std::optional<double> exposure;                                      ///< [s]; none: as the cameras choose
  std::optional<int> gain;                                             ///< in the cameras' own numbers
  std::optional<int> white_balance;                                    ///< [K]; none: as the cameras choose
  drivers::SetPointMode set_points = drivers::SetPointMode::kProfile;  ///< of the head's drives
  drivers::HomingConfig homing;                                        ///< of the head's drives
};

/// How `headway run` records.
struct RecordingConfig {
  std::string black_box;                                ///< folder, or "off"; empty: the program chooses
  std::size_t black_box_bytes = std::size_t{64} << 20;  ///< three quarters of it for pictures
  std::uint64_t file_bytes = std::uint64_t{1} << 30;    ///< of a recording, until the next file begins
};

struct Robot {
  std::string name;
  std::filesystem::path file, rig_path;  ///< what it was read from
  HardwareConfig hardware;
  RecordingConfig recording;
  vision::StereoRig rig;
  vision::VisionConfig vision;
  Duration camera_time_offset{};  ///< added to the camera's stamps, to come to the bus's time
  double chest_height = 1.0;      ///< [m]
  double map_margin = 1.0;        ///< around the floor in use [m]
  Eigen::Vector2d map_height{-0.4, 2.4};
  runtime::MapperConfig mapper;  ///< `voxels` gets its box when the floor in use is known
  nav::LevellingConfig levelling;
  runtime::LocalisationConfig localisation;
  runtime::MissionConfig mission;
  nav::StepStackConfig steps;
  runtime::LiveConfig loops;  ///< on a real clock
  SimulationConfig simulation;
};

/// config/hrp2/robot.yaml of what was installed with the program or of the tree that it was built in,
/// wherever it is called from; that below the present folder only where there is neither.
std::filesystem::path default_robot_file();

/// Lets the robot step over what rises no more than that [m]. Throws InputError where it cannot: its
/// footsteps are not its own, such steps do not fit its gait, or what rises so little is not looked for.
void step_over(double height, Robot& robot);

/// Throws InputError `file:line: key: what, expected what`.
/// `rig`: in place of the one that the file names.
Robot read_robot(const std::filesystem::path& file, const std::optional<std::filesystem::path>& rig = {});

}  // namespace headway::app
