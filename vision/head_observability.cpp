#include "vision/head_observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::vision {

namespace {

constexpr double kTakesPart = 0.3;  // of a unit vector: what contributes less is not to be named
constexpr double kWideSpan = 10 * kDegree, kFastSpeed = 5 * kDegree;  // below these, that is what is missing

}  // namespace

std::vector<std::string> undetermined(const Eigen::MatrixXd& information, const Eigen::VectorXd& useful,
                                      const std::vector<std::string>& names) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(useful.asDiagonal() * information *
                                                              useful.asDiagonal());
  std::vector<std::string> out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    bool weak = false;
    for (Eigen::Index k = 0; k < useful.size(); ++k) {
      const double share = std::abs(solver.eigenvectors()(static_cast<Eigen::Index>(i), k));
      weak = weak || (!(solver.eigenvalues()(k) >= 1) && !(share <= kTakesPart));
    }
    if (weak) out.push_back(names[i]);
  }
  return out;
}

void HeadMotion::add(const hal::HeadAngles& angles, double speed) {
  lowest_ = {std::min(lowest_.pan, angles.pan), std::min(lowest_.tilt, angles.tilt)};
  highest_ = {std::max(highest_.pan, angles.pan), std::max(highest_.tilt, angles.tilt)};
  fastest_ = std::max(fastest_, speed);
}

std::string HeadMotion::advice() const {
  const double pan = highest_.pan - lowest_.pan, tilt = highest_.tilt - lowest_.tilt;
  std::vector<std::string> missing;
  if (pan < kWideSpan)
    missing.push_back(
        fmt::format("at pan angles 20 deg apart and more (these span {:.1f} deg)", pan / kDegree));
  if (tilt < kWideSpan)
    missing.push_back(
        fmt::format("at tilt angles 20 deg apart and more (these span {:.1f} deg)", tilt / kDegree));
  if (fastest_ < kFastSpeed)
    missing.push_back(
        fmt::format("while the head moves at 10 deg/s and more (here it moves at most {:.1f} deg/s)",
                    fastest_ / kDegree));
  if (missing.empty()) return "expected more views, the board nearer, and head angles farther apart";
  return fmt::format("expected views {}", fmt::join(missing, ", and "));
}

}  // namespace headway::vision
