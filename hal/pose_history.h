// The last seconds of a moving quantity, so that an image can be paired with the pose at its exposure.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>

#include "hal/head.h"
#include "hal/time.h"

namespace headway::hal {

inline Eigen::Isometry3d interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double t) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = Eigen::Quaterniond(a.linear()).slerp(t, Eigen::Quaterniond(b.linear())).toRotationMatrix();
  out.translation() = a.translation() + t * (b.translation() - a.translation());
  return out;
}
inline HeadAngles interpolate(const HeadAngles& a, const HeadAngles& b, double t) {
  return {a.pan + t * (b.pan - a.pan), a.tilt + t * (b.tilt - a.tilt)};
}

/// A ring of stamped values. `at` interpolates between neighbours and never extrapolates.
template <class Value, std::size_t kCapacity>
class History {
 public:
  /// Adds a sample; one that is not newer than the newest is ignored (returns false).
  bool add(Time stamp, const Value& value) {
    if (size_ > 0 && stamp <= newest()) return false;
    ring_[next_] = {stamp, value};
    next_ = (next_ + 1) % kCapacity;
    if (size_ < kCapacity) ++size_;
    return true;
  }

  /// The value at `t`: nothing when `t` lies outside the samples, or in a gap wider than `max_gap`.
  std::optional<Value> at(Time t, Duration max_gap) const {
    for (std::size_t back = 0; back + 1 < size_; ++back) {
      const Sample& later = sample(back);
      const Sample& earlier = sample(back + 1);
      if (t > later.stamp) return std::nullopt;
      if (t < earlier.stamp) continue;
      const Duration gap = later.stamp - earlier.stamp;
      if (gap > max_gap) return std::nullopt;
      const double share =
          static_cast<double>((t - earlier.stamp).count()) / static_cast<double>(gap.count());
      return interpolate(earlier.value, later.value, share);
    }
    return std::nullopt;
  }

  bool empty() const { return size_ == 0; }
  Time newest() const { return sample(0).stamp; }

 private:
  struct Sample {
    Time stamp{};
    Value value{};
  };
  const Sample& sample(std::size_t back) const { return ring_[(next_ + kCapacity - 1 - back) % kCapacity]; }

  std::array<Sample, kCapacity> ring_{};
  std::size_t next_ = 0, size_ = 0;
};

/// Two seconds of bus cycles at 200 Hz.
using ChestHistory = History<Eigen::Isometry3d, 400>;
using HeadHistory = History<HeadAngles, 400>;

}  // namespace headway::hal
