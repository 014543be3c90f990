#include "runtime/gaze.h"

#include <algorithm>
#include <cmath>

namespace headway::runtime {

namespace {
constexpr double kThere = 0.009;  // half a degree: the head is where it should be
}

bool Tour::look(const hal::HeadAngles& angles) {
  if (done()) return false;
  const hal::HeadAngles& want = direction();
  if (std::abs(angles.pan - want.pan) > kThere || std::abs(angles.tilt - want.tilt) > kThere) return false;
  if (++frames_here_ < frames_each_) return false;
  frames_here_ = 0;
  ++at_;
  return true;
}

hal::HeadAngles limited(const hal::HeadAngles& a, const hal::HeadLimits& limits) {
  return {std::clamp(a.pan, limits.lower.pan, limits.upper.pan),
          std::clamp(a.tilt, limits.lower.tilt, limits.upper.tilt)};
}

hal::HeadAngles look_at(const Eigen::Vector3d& point, const Eigen::Isometry3d& map_from_chest,
                        const hal::HeadKinematics& neck, const hal::HeadLimits& limits) {
  return limited(neck.look_at(map_from_chest.inverse() * point), limits);
}

}  // namespace headway::runtime
