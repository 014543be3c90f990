// Rigs as calibrations find them: a little askew, a little distorted.
#pragma once

#include <rapidcheck/gtest.h>

#include "vision/rig.h"

namespace headway::vision::test {

inline double between(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1000001) * 1e-6;
}

inline CameraIntrinsics random_camera(int width, int height) {
  CameraIntrinsics c;
  c.width = width, c.height = height;
  c.fx = width * between(0.9, 2);
  c.fy = c.fx * between(0.98, 1.02);
  c.cx = width * between(0.45, 0.55), c.cy = height * between(0.45, 0.55);
  c.k1 = between(-0.12, 0.1), c.k2 = between(-0.02, 0.03);
  c.p1 = between(-0.001, 0.001), c.p2 = between(-0.001, 0.001);
  return c;
}

/// A usable rig with small images, so that its tables are made quickly.
inline StereoRig random_rig(int width = 96, int height = 72) {
  StereoRig rig;
  rig.name = "random";
  rig.left = random_camera(width, height);
  rig.right = random_camera(width, height);
  rig.right.fx = rig.left.fx * between(0.99, 1.01), rig.right.fy = rig.right.fx;
  const double baseline = between(0.05, 0.3), turn = 0.05;
  const Eigen::Vector3d axis(between(-turn, turn), between(-turn, turn), between(-turn, turn));
  if (axis.norm() > 0)
    rig.right_from_left.linear() = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  const Eigen::Vector3d right(baseline, baseline * between(-0.1, 0.1), baseline * between(-0.1, 0.1));
  rig.right_from_left.translation() = -(rig.right_from_left.linear() * right);
  rig.nearest = 1.5 * rig.left.fx * baseline / width;
  rig.farthest = 20;
  return rig;
}

}  // namespace headway::vision::test
