#include "runtime/glance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/error.h"
#include "hal/pose2.h"

namespace headway::runtime {

void GlanceConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("localisation: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("glance shift", shift, 0.001, 10);
  check("glance turn", turn, 0.001, 10);
  check("glance tilt", tilt, -1.6, 1.6);
  check("glance pan", pan, 0, 1.6);
  check("longest glance", to_seconds(longest), 0, 60);
  check("time between glances", to_seconds(apart), 0, 3600);
}

bool Glance::unsure(const Eigen::Matrix3d& covariance, double share) const {
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))) > share * config_.shift ||
         std::sqrt(covariance(2, 2)) > share * config_.turn;
}

/// Surfaces that tell of a place along a line stand across it: looks along the line that is known least, now
/// to its one end, now to the other, as far as the head turns.
double Glance::pan_to(const Eigen::Matrix2d& place, double heading) const {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(place);
  const Eigen::Vector2d line = axes.eigenvectors().col(1);
  const double left =
      wrap_angle(2 * (std::atan2(line.y(), line.x()) - heading)) / 2;  // within a quarter turn
  const double right = left > 0 ? left - std::numbers::pi : left + std::numbers::pi;
  return std::clamp(back_ ? right : left, -config_.pan, config_.pan);
}

hal::HeadAngles Glance::direct(const hal::HeadAngles& look, const Eigen::Matrix3d& covariance, double heading,
                               Time now) {
  if (begun_ && (now - *begun_ > config_.longest || !unsure(covariance, 0.5))) end(now);
  if (!begun_ && unsure(covariance, 1) && (!ended_ || now - *ended_ > config_.apart)) {
    begun_ = now;
    const Eigen::Matrix2d place = covariance.topLeftCorner<2, 2>();
    aside_ = std::sqrt(place.diagonal().maxCoeff()) > config_.shift;
    if (aside_) pan_ = pan_to(place, heading);
    if (aside_) back_ = !back_;
  }
  if (!begun_) return look;
  return {aside_ ? pan_ : look.pan, std::min(look.tilt, config_.tilt)};
}

void Glance::end(Time now) {
  if (begun_) ended_ = now;
  begun_.reset();
}

}  // namespace headway::runtime
