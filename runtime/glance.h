// When the head looks up from the way: who watches the floor sees nothing that tells where on it he is.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "hal/head.h"
#include "hal/time.h"

namespace headway::runtime {

struct GlanceConfig {
  // Standard deviations of the robot's place from which it looks up; it has seen enough at half of them.
  double shift = 0.03;              ///< [m]
  double turn = 0.010;              ///< [rad]
  double tilt = 0;                  ///< of the head that looks at walls [rad], positive down
  double pan = 0.7;                 ///< at most to either side [rad]
  Duration longest = seconds(1.6);  ///< whatever it sees
  Duration apart = seconds(2.0);    ///< from the end of a glance to the next

  /// Throws InputError when a value is out of bounds.
  void validate() const;
};

/// Decides when to look up, whither, and for how long.
class Glance {
 public:
  /// Throws InputError as GlanceConfig::validate.
  explicit Glance(const GlanceConfig& config = {}) : config_(config) { config.validate(); }

  /// Where to look in place of `look`, with the robot's place known to `covariance` (x, y [m], yaw [rad]) and
  /// its heading [rad].
  hal::HeadAngles direct(const hal::HeadAngles& look, const Eigen::Matrix3d& covariance, double heading,
                         Time now);
  /// The head is needed elsewhere.
  void end(Time now);

 private:
  bool unsure(const Eigen::Matrix3d& covariance, double share) const;
  double pan_to(const Eigen::Matrix2d& place, double heading) const;

  GlanceConfig config_;
  std::optional<Time> begun_, ended_;
  bool aside_ = false;  ///< where the place is least known, not on the way
  bool back_ = false;   ///< to the other side than the last time
  double pan_ = 0;
};

}  // namespace headway::runtime
