// Both cameras of a pair must see a point: held against the depth image that the simulator makes of them.
#include "app/pair_sight.h"

#include <cmath>

#include <gtest/gtest.h>

#include "hal/clock.h"
#include "hal/head_kinematics.h"
#include "sim_hal/sim_depth_camera.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

TEST(PairSight, IsWhereTheSimulatedPairMeasuresDepth) {
  const sim::World world = sim::read_world(source_dir() / "config/worlds/lab.yaml");
  const sim::Scene scene(world);
  hal::ManualClock clock;
  sim::DepthCameraModel model;
  model.missing = model.missing_at_edges = model.outliers = model.disparity_sigma = 0;
  const vision::PinholeCamera camera{model.width, model.height, model.focal, model.cx, model.cy};
  const PairSight sight{camera, model.baseline, model.nearest, model.farthest};
  int by_both = 0, else_where = 0, unlike = 0;
  for (int look = 0; look < 6; ++look) {
    Isometry3d map_from_view = Isometry3d::Identity();
    map_from_view.linear() = Eigen::AngleAxisd(0.9 * look, Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(0.3, Vector3d::UnitY()) * hal::body_from_optical();
    map_from_view.translation() = world.start.lifted(1.4).translation();
    sim::SimDepthCamera depth(scene, clock, model);
    depth.expose(clock.now(), map_from_view);
    clock.advance(seconds(1));
    hal::DepthFrame frame;
    ASSERT_TRUE(depth.take_newest(frame));
    for (int v = 0; v < model.height; ++v)
      for (int u = 0; u < model.width; ++u) {
        const Vector3d ray = camera.point(u, v, 1);
        const sim::RayHit hit = scene.cast(map_from_view.translation(), map_from_view.linear() * ray);
        const Vector3d p = static_cast<double>(hit.distance) * ray;
        const bool both = sight.in_view(p) && sight.in_sight(scene, map_from_view, map_from_view * p);
        const std::size_t i =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(model.width) + static_cast<std::size_t>(u);
        unlike += both == std::isnan(frame.depth[i]);
        ++(both ? by_both : else_where);
      }
  }
  EXPECT_GT(by_both, 20000);
  EXPECT_GT(else_where, 2000);
  EXPECT_LT(unlike, 1e-3 * (by_both + else_where)) << "what rounding makes of rays that graze edges";
}

}  // namespace
}  // namespace headway::app
