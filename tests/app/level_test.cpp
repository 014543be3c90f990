#include "app/level.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/head_kinematics.h"

namespace headway::app {
namespace {

/// What a camera at 1.4 m sees of a room: floor, a wall 4 m ahead, one 2 m to the left, a table at 0.7 m.
struct Room {
  Eigen::Isometry3d room_from_camera = Eigen::Isometry3d::Identity();
  vision::RangeView view;
};

double ray_depth(const Eigen::Vector3d& eye, const Eigen::Vector3d& d) {
  double nearest = 1e9;
  const auto meet = [&](int axis, double at, auto inside) {
    const double t = (at - eye[axis]) / d[axis];
    const Eigen::Vector3d p = eye + t * d;
    if (t > 0.05 && t < nearest && inside(p)) nearest = t;
  };
  const auto all = [](const Eigen::Vector3d&) { return true; };
  meet(2, 0.0, all);
  meet(0, 4.0, all);
  meet(1, 2.0, all);
  meet(2, 0.7, [](const Eigen::Vector3d& p) { return p.x() > 2 && p.x() < 3 && p.y() > -1 && p.y() < 0; });
  return nearest;
}

Room see_room(std::uint64_t seed, double noise) {
  Room room;
  room.room_from_camera.linear() =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix() * hal::body_from_optical(0.45);
  room.room_from_camera.translation() << 0, 0, 1.4;
  vision::RangeView& view = room.view;
  view.camera = {320, 240, 260, 159.5, 119.5};
  view.near = 0.4, view.far = 8;
  std::mt19937_64 random(seed);
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const Eigen::Vector3d d = room.room_from_camera.linear() * view.camera.point(u, v, 1);
      const double z = ray_depth(room.room_from_camera.translation(), d);
      double gauss = -6;
      for (int i = 0; i < 12; ++i) gauss += static_cast<double>(random() >> 11) * 0x1p-53;
      view.depth.push_back(static_cast<float>(z + noise * z * z * gauss));
      view.sigma_depth.push_back(static_cast<float>(noise * z * z));
    }
  }
  return room;
}

TEST(Level, IsFoundFromTheSurfacesThoughTheGuessIsOff) {
  double squares = 0, cases = 0;
  rc::check([&](std::uint64_t seed) {
    const Room room = see_room(seed, 0.004);
    // The world of the poses is turned by any rotation against the room.
    std::mt19937_64 random(seed);
    const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 * 2 - 1; };
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond(uniform(), uniform(), uniform(), uniform() + 1e-3).normalized();
    Eigen::Isometry3d world_from_camera = Eigen::Isometry3d::Identity();
    world_from_camera.linear() = turn * room.room_from_camera.linear();
    world_from_camera.translation() = turn * room.room_from_camera.translation() + Eigen::Vector3d(1, 2, 3);
    std::vector<Surfel> surfels;
    add_surfels(room.view, world_from_camera, 3000, surfels);
    RC_ASSERT(surfels.size() > 1000U);
    const Eigen::Vector3d truth = turn * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d up = estimate_up(surfels, -world_from_camera.linear().col(1));  // 26 degrees off
    const double off = std::acos(std::min(1.0, up.dot(truth)));
    RC_ASSERT(off < 0.02);  // 6 cm at 3 m: less than what still counts as floor
    squares += off * off, cases += 1;
    const FloorHeight floor = estimate_floor(surfels, up);
    const Eigen::Isometry3d map = map_from_world(up, floor.height, world_from_camera);
    const Eigen::Isometry3d map_from_camera = map * world_from_camera;
    RC_ASSERT(std::abs(map_from_camera.translation().z() - 1.4) < 0.03);
    RC_ASSERT(map_from_camera.translation().head<2>().norm() < 1e-9);
    RC_ASSERT(map_from_camera.linear().col(2).y() < 1e-9);  // it looks along x
    RC_ASSERT(map_from_camera.linear().col(2).x() > 0);
    RC_ASSERT((map.linear() * map.linear().transpose()).isIdentity(1e-9));
    RC_ASSERT(map.linear().determinant() > 0);
  });
  EXPECT_LT(std::sqrt(squares / cases), 0.005) << "of " << cases << " rooms, radians";
}

TEST(Level, SurfelsFaceTheCamera) {
  const Room room = see_room(1, 0.001);
  std::vector<Surfel> surfels;
  add_surfels(room.view, room.room_from_camera, 2000, surfels);
  for (const Surfel& s : surfels) {
    EXPECT_LT(s.normal.dot(s.point - room.room_from_camera.translation()), 0);
    EXPECT_NEAR(s.normal.norm(), 1, 1e-9);
  }
}

TEST(Level, StaysWithTheGuessWhenNothingWasSeen) {
  const Eigen::Vector3d guess = Eigen::Vector3d(0.1, -0.2, 3).normalized();
  EXPECT_TRUE(estimate_up({}, guess).isApprox(guess));
  EXPECT_FALSE(estimate_floor({}, guess).how.empty());
  EXPECT_EQ(estimate_floor({}, guess).height, 0);
}

TEST(Level, TakesTheLowestPointsWhenNoLevelSurfaceWasSeen) {
  std::vector<Surfel> wall;
  for (int i = 0; i < 1000; ++i) wall.push_back({{3, 0, i * 0.002 - 0.5}, {-1, 0, 0}});
  EXPECT_NEAR(estimate_floor(wall, Eigen::Vector3d::UnitZ()).height, -0.48, 0.03);
}

TEST(Level, OfACameraThatLooksStraightDownHasItsImagesTopAhead) {
  Eigen::Isometry3d camera = Eigen::Isometry3d::Identity();
  camera.linear() << 0, -1, 0, -1, 0, 0, 0, 0, -1;  // x right is -y, y down is -x, z down
  camera.translation() << 5, 6, 2;
  const Eigen::Isometry3d map = map_from_world(Eigen::Vector3d::UnitZ(), 0, camera);
  EXPECT_TRUE((map * camera).translation().isApprox(Eigen::Vector3d(0, 0, 2), 1e-9));
  EXPECT_TRUE((map.linear() * -camera.linear().col(1)).isApprox(Eigen::Vector3d::UnitX(), 1e-9));
}

}  // namespace
}  // namespace headway::app
