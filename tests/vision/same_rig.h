// Whether two cameras are the same, to the last bit.
#pragma once

#include <tuple>

#include "vision/rig.h"

namespace headway::vision::test {

inline bool same(const CameraIntrinsics& a, const CameraIntrinsics& b) {
  const auto values = [](const CameraIntrinsics& c) {
    return std::tuple(c.width, c.height, c.fx, c.fy, c.cx, c.cy, c.lens, c.k1, c.k2, c.p1, c.p2, c.k3, c.k4,
                      c.k5, c.k6);
  };
  return values(a) == values(b);
}

}  // namespace headway::vision::test
