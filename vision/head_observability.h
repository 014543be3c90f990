// Whether head poses determine what a head calibration wants to know; and if not, what views are missing.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "hal/head.h"

namespace headway::vision {

/// The parameters that take part in a direction along which the standard deviation exceeds the useful one
/// (all in units of `useful`): found from the eigenvectors of the information matrix. None: all are
/// determined. Where the information holds what is not finite, none is.
std::vector<std::string> undetermined(const Eigen::MatrixXd& information, const Eigen::VectorXd& useful,
                                      const std::vector<std::string>& names);

/// Where the head was at the exposures, and how fast it moved.
class HeadMotion {
 public:
  void add(const hal::HeadAngles& angles, double speed);  ///< [rad], [rad/s]
  /// What to do about parameters that are not determined, for a message.
  std::string advice() const;

 private:
  hal::HeadAngles lowest_{1e9, 1e9}, highest_{-1e9, -1e9};
  double fastest_ = 0;
};

}  // namespace headway::vision
