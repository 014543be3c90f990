// How the camera sits on the neck, where the joints' zeros are and how camera and bus clocks differ, from
// views of one board that stands still while the head moves.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "hal/head_kinematics.h"
#include "hal/time.h"
#include "vision/board.h"
#include "vision/calibration_covariance.h"
#include "vision/rig.h"

namespace headway::vision {

/// What the camera saw of the board, stamped by the camera.
struct HeadView {
  Time exposure{};
  BoardView board;
};

/// The joints' angles as the drives report them, stamped by the bus.
struct HeadSample {
  Time stamp{};
  hal::HeadAngles angles;  ///< [rad]
};

/// Where corner 0 of the board is in the chest frame, measured by hand.
struct MeasuredCorner {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< [m]
  double sigma = 0.002;                             ///< of each coordinate [m]
};

struct HeadCalibrationInput {
  Board board;
  CameraIntrinsics camera;
  hal::HeadKinematics neck;         ///< as designed: where the search starts, and what is held
  std::vector<HeadView> views;      ///< with the board in them; at least kFewestHeadViews
  std::vector<HeadSample> samples;  ///< in rising order, without gaps around the views
  std::optional<MeasuredCorner> corner;
};

inline constexpr std::size_t kFewestHeadViews = 4;
/// Camera and bus stamps may differ by no more; samples must cover each exposure that far to both sides.
inline constexpr Duration kWidestTimeOffset = seconds(0.2);
/// Samples farther apart are no history of the head's motion.
inline constexpr Duration kWidestSampleGap = seconds(0.1);

struct HeadCalibration {
  hal::HeadKinematics neck;  ///< with tilt_from_camera and zero as found
  Duration time_offset{};    ///< to add to the camera's stamps to have those of the bus
  Eigen::Isometry3d chest_from_board = Eigen::Isometry3d::Identity();
  double rms = 0;                            ///< distance of seen corners from projected ones [px]
  std::vector<double> view_rms;              ///< the same per view
  std::vector<hal::HeadAngles> view_angles;  ///< as reported, at the exposures [rad]
  std::vector<Estimate> estimates;  ///< camera.x, .y, .z, .turn_x, .turn_z, tilt_zero, time_offset, pan_zero
};

/// True when the samples allow to look up the head at an exposure, whatever the time offset.
bool samples_cover(const std::vector<HeadSample>& samples, Time exposure);

/// Least squares over the corners' distances in the images, with angles cubic between samples.
///
/// Two things no view of a board can tell, so they are held:
/// - A tilt zero acts like the camera turned about the tilt axis (y of the tilt link): Ry(tilt + zero) C =
///   Ry(tilt) (Ry(zero) C). The camera's turn about that axis stays as designed; all of it counts as tilt
///   zero.
/// - A pan zero acts like the board carried around the pan axis, Rz(pan + zero) = Rz(zero) Rz(pan), and where
/// the
///   board stands is unknown. So it stays as designed, unless `corner` says where in the chest frame one
///   corner of the board is: then it is found, as precisely as the corner is measured across the line of
///   sight.
///
/// Throws InputError when there is too little to go by, when no search settles, and when the head poses do
/// not determine a parameter to 0.25 deg, 10 mm or 10 ms; the message names the parameter and what views are
/// missing.
HeadCalibration calibrate_head(const HeadCalibrationInput& input);

}  // namespace headway::vision
