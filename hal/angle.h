// Angles are radians inside; degrees only in files and on screens.
#pragma once

#include <numbers>

namespace headway {

inline constexpr double kDegree = std::numbers::pi / 180;  ///< [rad]

}  // namespace headway
