// Rigs as calibrations find them: a little askew, a little distorted.
#pragma once

#include <algorithm>

#include <rapidcheck/gtest.h>

#include "vision/rig.h"

namespace headway::vision::test {

inline double between(double lowest, double highest) {
  return lowest + (highest - lowest) * *rc::gen::inRange(0, 1000001) * 1e-6;
}

inline LensModel any_lens() {
  return *rc::gen::element(LensModel::kRadialTangential, LensModel::kRational, LensModel::kEquidistant);
}

/// Equidistant ones see up to 100 deg off their axis, the others up to 40.
inline CameraIntrinsics random_camera(int width, int height, LensModel lens = LensModel::kRadialTangential) {
  CameraIntrinsics c;
  c.lens = lens;
  c.width = width, c.height = height;
  c.fx = width * (lens == LensModel::kEquidistant ? between(0.42, 0.6) : between(0.9, 2));
  c.fy = c.fx * between(0.98, 1.02);
  c.cx = width * between(0.45, 0.55), c.cy = height * between(0.45, 0.55);
  if (lens == LensModel::kEquidistant) {
    c.k1 = between(-0.02, 0.02), c.k2 = between(-0.002, 0.002);
    c.k3 = between(-0.0003, 0.0003), c.k4 = between(-0.00003, 0.00003);
    return c;
  }
  c.k1 = between(-0.12, 0.1), c.k2 = between(-0.02, 0.03);
  c.p1 = between(-0.001, 0.001), c.p2 = between(-0.001, 0.001);
  if (lens == LensModel::kRational) {
    c.k3 = between(-0.02, 0.02);
    c.k4 = between(-0.1, 0.1), c.k5 = between(-0.02, 0.02), c.k6 = between(-0.01, 0.01);
  }
  return c;
}

/// A usable rig with small images, so that its tables are made quickly.
inline StereoRig random_rig(LensModel lens = LensModel::kRadialTangential, int width = 96, int height = 72) {
  StereoRig rig;
  rig.name = "random";
  rig.left = random_camera(width, height, lens);
  rig.right = random_camera(width, height, lens);
  rig.right.fx = rig.left.fx * between(0.99, 1.01), rig.right.fy = rig.right.fx;
  const double baseline = between(0.05, 0.3), turn = 0.05;
  const Eigen::Vector3d axis(between(-turn, turn), between(-turn, turn), between(-turn, turn));
  if (axis.norm() > 0)
    rig.right_from_left.linear() = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  const Eigen::Vector3d right(baseline, baseline * between(-0.1, 0.1), baseline * between(-0.1, 0.1));
  rig.right_from_left.translation() = -(rig.right_from_left.linear() * right);
  rig.nearest = std::max(0.05, 1.5 * rig.left.fx * baseline / width);
  rig.farthest = 20;
  return rig;
}

}  // namespace headway::vision::test
