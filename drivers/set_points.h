// What the ways to tell a running drive where to go have in common. Positions are in 0.001 degree.
#pragma once

#include <algorithm>
#include <cstdint>

namespace headway::drivers {

/// Between which a drive may be told to go.
struct PositionLimits {
  std::int32_t lower = 0, upper = 0;
  std::int32_t clamped(std::int32_t target) const noexcept { return std::clamp(target, lower, upper); }
};

/// What a drive has last said of itself.
struct DriveSight {
  std::uint16_t statusword = 0;
  std::int32_t position = 0;
  bool silent = false;  ///< that is no longer how it is
};

}  // namespace headway::drivers
