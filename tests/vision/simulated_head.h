// A head that moves as HRP-2's drives move it, a board before it that stands still, and what camera and bus
// report of both: the truth of a head calibration.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "hal/angle.h"
#include "hal/head_kinematics.h"
#include "sim_hal/trapezoid.h"
#include "vision/head_calibration.h"

namespace headway::vision::test {

/// The neck as designed (config/hrp2/robot.yaml).
inline hal::HeadKinematics designed_neck() {
  hal::HeadKinematics neck;
  neck.chest_from_pan.translation() << 0, 0, 0.33;
  neck.pan_from_tilt.translation() << 0, 0, 0.03;
  neck.tilt_from_camera.linear() = hal::body_from_optical(10 * kDegree);
  neck.tilt_from_camera.translation() << 0.035, 0.072, 0.045;
  return neck;
}

/// By how much the true head differs from the designed one.
struct PlantedErrors {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of the camera in the tilt link [m]
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();   ///< of the camera, about the tilt link's axes [rad]
  hal::HeadAngles zero;                             ///< true less reported angles [rad]
  double time_offset = 0;                           ///< bus stamp less camera stamp [s]
};

/// How the head is moved and watched.
struct Session {
  double pan_span = 18 * kDegree, tilt_span = 22 * kDegree;  ///< targets lie that far to both sides
  bool while_moving = true;                                  ///< else images are taken only at rest
  std::size_t images = 150;
  double noise = 0.25;  ///< of a corner's coordinate [px]
};

/// One joint: the drive's trapezoid, and the joint that follows it with 8 ms lag.
class SimulatedJoint {
 public:
  explicit SimulatedJoint(double angle) : profile_(angle), angle_(angle) {}
  void command(double target) {
    profile_ = sim::Trapezoid::move(profile_.at(since_), target, 60 * kDegree, 240 * kDegree, 240 * kDegree);
    since_ = 0;
  }
  void advance(double dt) {
    since_ += dt;
    angle_ += (profile_.at(since_).position - angle_) * dt / 0.008;
  }
  double angle() const { return angle_; }

 private:
  sim::Trapezoid profile_;
  double since_ = 0, angle_;
};

class SimulatedHead {
 public:
  SimulatedHead(const PlantedErrors& errors, std::uint32_t seed) : errors_(errors), random_(seed) {
    camera.width = 340, camera.height = 480;
    camera.fx = camera.fy = 573.91, camera.cx = 169.5, camera.cy = 239.5;
    camera.k1 = -0.08, camera.k2 = 0.02, camera.p1 = 0.0004, camera.p2 = -0.0003;
    // Upright before the robot, a little askew: x to the right, y down.
    chest_from_board.linear() =
        hal::body_from_optical() * (Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ()))
                                       .toRotationMatrix();
    chest_from_board.translation() << 1.6, 0.35, 0.38;
  }

  /// Of a board with markers a part is enough, so that the head may turn far.
  Board board{12, 8, 0.05, BoardMarkers{"4X4_100", 0.036}};
  CameraIntrinsics camera;
  Eigen::Isometry3d chest_from_board = Eigen::Isometry3d::Identity();

  /// Written out joint by joint, apart from hal::HeadKinematics. True angles.
  Eigen::Isometry3d chest_from_camera(double pan, double tilt) const {
    const hal::HeadKinematics d = designed_neck();
    Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
    t.translate(d.chest_from_pan.translation());
    t.rotate(Eigen::AngleAxisd(pan, Eigen::Vector3d::UnitZ()));
    t.translate(d.pan_from_tilt.translation());
    t.rotate(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()));
    t.translate(d.tilt_from_camera.translation() + errors_.shift);
    if (errors_.turn.norm() > 0) t.rotate(Eigen::AngleAxisd(errors_.turn.norm(), errors_.turn.normalized()));
    t.rotate(d.tilt_from_camera.linear());
    return t;
  }

  /// The record of one session; `take(stamp, camera_from_board)` is called for each image in its stead, if
  /// given.
  template <class Take>
  HeadCalibrationInput record(const Session& session, const Take& take) {
    HeadCalibrationInput input;
    input.board = board, input.camera = camera, input.neck = designed_neck();
    const double middle_tilt = middle_of_board().tilt, middle_pan = middle_of_board().pan;
    SimulatedJoint pan(middle_pan), tilt(middle_tilt);
    const auto in = [&](double span) { return std::uniform_real_distribution<double>(-span, span)(random_); };
    double next_move = 0.5, next_image = session.while_moving ? 0.61 : 1.8;
    int step = 0;
    for (double t = 0; input.views.size() < session.images || t < next_image + 0.3; t += 1e-3, ++step) {
      if (t >= next_move) {
        pan.command(middle_pan + in(session.pan_span));
        tilt.command(middle_tilt + in(session.tilt_span));
        next_move = t + (session.while_moving ? 1.0 : 1.5);
      }
      pan.advance(1e-3), tilt.advance(1e-3);
      if (step % 20 == 0)
        input.samples.push_back({at_seconds(t + 1e-3), reported(pan.angle(), tilt.angle())});
      if (t < next_image || input.views.size() >= session.images) continue;
      // A move takes 1 s at most, then the head rests.
      next_image = session.while_moving ? t + 0.137 : next_move + 1.3;
      const Time stamp = at_seconds(t + 1e-3 - errors_.time_offset);
      take(input, stamp, chest_from_camera(pan.angle(), tilt.angle()).inverse() * chest_from_board);
    }
    return input;
  }

  /// Corners projected with noise; images that show too little of the board are passed over.
  HeadCalibrationInput record(const Session& session) {
    return record(session,
                  [&](HeadCalibrationInput& input, Time stamp, const Eigen::Isometry3d& camera_from_board) {
                    BoardView view = seen(camera_from_board, session.noise);
                    if (!view.empty()) input.views.push_back({stamp, std::move(view)});
                  });
  }

  /// Corner 0 as somebody measures it.
  MeasuredCorner measured_corner(double sigma) {
    std::normal_distribution<double> error(0, sigma);
    const Eigen::Vector3d off(error(random_), error(random_), error(random_));
    return {chest_from_board.translation() + off, sigma};
  }

 private:
  hal::HeadAngles middle_of_board() const {
    return designed_neck().look_at(chest_from_board * (0.5 * board.corner(board.corners() - 1)));
  }
  /// In steps of 0.001 deg, as on the wire.
  hal::HeadAngles reported(double pan, double tilt) const {
    const auto wire = [](double angle) { return std::round(angle / (0.001 * kDegree)) * 0.001 * kDegree; };
    return {wire(pan - errors_.zero.pan), wire(tilt - errors_.zero.tilt)};
  }
  BoardView seen(const Eigen::Isometry3d& camera_from_board, double noise) {
    std::normal_distribution<double> error(0, noise);
    BoardView view;
    for (int i = 0; i < board.corners(); ++i) {
      const Eigen::Vector2d pixel = camera.project(camera_from_board * board.corner(i));
      const bool inside =
          pixel.x() >= 3 && pixel.y() >= 3 && pixel.x() <= camera.width - 4 && pixel.y() <= camera.height - 4;
      if (!inside) continue;
      view.ids.push_back(i);
      view.pixels.emplace_back(pixel.x() + error(random_), pixel.y() + error(random_));
    }
    return shows_enough(board, view) ? view : BoardView{};
  }

  PlantedErrors errors_;
  std::mt19937 random_;
};

}  // namespace headway::vision::test
