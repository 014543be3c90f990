// What is shown of a frame arrives as it was, in the messages that viewers know.
#include "operator/telemetry.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/recording/cdr.h"
#include "tests/runtime/mission_bench.h"

namespace headway::remote {
namespace {

/// A robot that looks down on a box, and shows it.
struct Shown {
  explicit Shown(TelemetryConfig config = {}) : telemetry(with_resolution(config, bench)) {}
  static TelemetryConfig with_resolution(TelemetryConfig config, const runtime::Bench& bench) {
    config.resolution = bench.mapper.voxels().resolution();
    return config;
  }
  void frame() {
    bench.frames(1);
    const runtime::FrameStamp stamp{bench.now, ++number};
    const Eigen::Isometry3d map_from_view = runtime::from_above(bench.eye, 4.5);
    const vision::RangeView view = runtime::look(bench.boxes, map_from_view);
    const Eigen::Isometry3d chest = bench.chest();
    telemetry.see({stamp,
                   view,
                   picture.pixels.empty() ? nullptr : &picture,
                   map_from_view,
                   chest,
                   bench.mapper,
                   bench.mission,
                   bench.bus,
                   bench.order,
                   {},
                   {}});
  }
  /// With everything wanted.
  void look() {
    Wanted all;
    all.fill(true);
    telemetry.look(all);
  }
  template <class Message>
  Message newest(Channel channel) {
    const Newest now = telemetry.newest(channel);
    if (!now.cdr) throw std::runtime_error("no message");
    return recording::from_cdr<Message>(*now.cdr);
  }

  runtime::Bench bench;
  hal::GrayImage picture;
  std::uint64_t number = 0;
  Telemetry telemetry;
};

TEST(Telemetry, PointsLieWhereTheyWereSeenWithTheirPrecision) {
  Shown shown;
  shown.bench.boxes = {runtime::box(1.5, 2.1, -0.3, 0.3, 1.0)};
  shown.look();
  shown.frame();
  shown.look();
  const auto cloud = shown.newest<ros::PointCloud2>(Channel::kPoints);
  ASSERT_EQ(cloud.point_step, 20U);
  ASSERT_GT(cloud.width, 5000U);
  ASSERT_LE(cloud.width, 20000U);
  ASSERT_EQ(cloud.data.size(), std::size_t{20} * cloud.width);
  EXPECT_EQ(cloud.fields_of_points.back().name, "sigma");
  for (std::uint32_t i = 0; i < cloud.width; ++i) {
    SeenPoint p;
    std::memcpy(&p, cloud.data.data() + std::size_t{20} * i, sizeof p);
    const bool on_box = p.z > 0.5F;
    EXPECT_NEAR(p.z, on_box ? 1.0F : 0.0F, 1e-4F) << i;
    EXPECT_GT(p.sigma, 0.002F);
    EXPECT_LT(p.sigma, 0.02F);
  }
}

TEST(Telemetry, SigmaIsTheLargestEigenvalueOfTheCovariance) {
  TelemetryConfig config;
  config.onlooker.most_points = 30000;
  Shown shown(config);
  shown.look();
  shown.frame();
  shown.look();
  const auto cloud = shown.newest<ros::PointCloud2>(Channel::kPoints);
  const Eigen::Isometry3d map_from_view = runtime::from_above(shown.bench.eye, 4.5);
  const vision::RangeView view = runtime::look(shown.bench.boxes, map_from_view);
  ASSERT_EQ(cloud.width, 200U * 150U);
  for (std::uint32_t i = 0; i < cloud.width; i += 997) {
    SeenPoint p;
    std::memcpy(&p, cloud.data.data() + std::size_t{20} * i, sizeof p);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(
        view.covariance(static_cast<int>(i % 200), static_cast<int>(i / 200)));
    EXPECT_NEAR(static_cast<double>(p.sigma), std::sqrt(solved.eigenvalues()[2]), 1e-6) << i;
  }
}

TEST(Telemetry, VoxelsAreThoseOfTheMap) {
  Shown shown;
  shown.bench.boxes = {runtime::box(1.5, 2.1, -0.3, 0.3, 1.0)};
  for (int i = 0; i < 12; ++i) {
    shown.frame();
    shown.look();
  }
  std::uint64_t version = 0;
  const auto bytes = shown.telemetry.voxels(version);
  ASSERT_TRUE(bytes);
  const auto told = recording::from_cdr<Voxels>(*bytes);
  EXPECT_TRUE(told.whole);
  const nav::VoxelMap& map = shown.bench.mapper.voxels();
  EXPECT_EQ(told.resolution, map.resolution());
  std::size_t occupied = 0;
  for (std::size_t b = 0; b < told.keys.size() / 3; ++b)
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          const Eigen::Vector3i voxel =
              8 * Eigen::Vector3i(told.keys[3 * b], told.keys[3 * b + 1], told.keys[3 * b + 2]) +
              Eigen::Vector3i(x, y, z) - map.first_key();
          const auto at = 64 * b + static_cast<std::size_t>(8 * z + y);
          const bool full = told.occupied[at] >> x & 1, unseen = told.unseen[at] >> x & 1;
          ASSERT_EQ(full, map.at(voxel) == nav::Voxel::kOccupied);
          ASSERT_EQ(unseen, map.at(voxel) == nav::Voxel::kUnseen);
          occupied += full;
        }
  std::size_t in_map = 0;
  for (std::size_t b = 0; b < map.brick_count(); ++b) in_map += map.summary(b).occupied;
  EXPECT_EQ(occupied, in_map);
  EXPECT_GT(in_map, 500U);
}

TEST(Telemetry, ShowsTheWayTheFeetAndWhichOfThemAreCommitted) {
  Shown shown;
  shown.bench.until_walking(runtime::kAhead);
  ASSERT_EQ(shown.bench.order.walk, runtime::Walk::kPlan);
  shown.bench.commit(3);
  shown.frame();
  shown.look();
  const auto feet = shown.newest<ros::MarkerArray>(Channel::kFootsteps);
  int committed = 0, planned = 0;
  ASSERT_FALSE(feet.markers.empty());
  EXPECT_EQ(feet.markers.front().action, ros::Marker::kDeleteAll);
  for (const ros::Marker& marker : feet.markers) {
    committed += marker.ns == "committed";
    planned += marker.ns == "planned";
  }
  EXPECT_EQ(committed, 3);
  EXPECT_GT(planned, 5);
  const auto way = shown.newest<ros::Path>(Channel::kPlan);
  ASSERT_FALSE(way.poses.empty());
  EXPECT_NEAR(way.poses.back().pose.position.x, 3, 0.2);
  EXPECT_EQ(way.header.frame_id, "map");
}

nav::FloorGrid six_metres() { return {.resolution = 0.05, .origin = {-3, -3}, .width = 120, .height = 120}; }

/// Whether the grid says that the body comes to a place.
bool swept(const ros::OccupancyGrid& grid, double x, double y) {
  const auto column = static_cast<int>(std::floor((x - grid.info.origin.position.x) / 0.05)),
             row = static_cast<int>(std::floor((y - grid.info.origin.position.y) / 0.05));
  const auto width = static_cast<int>(grid.info.width), height = static_cast<int>(grid.info.height);
  if (column < 0 || row < 0 || column >= width || row >= height) return false;
  return grid.data.at(static_cast<std::size_t>(row * width + column)) > 0;
}

TEST(Telemetry, ShowsTheFloorThatTheBodySweepsAlongThePreviewedWay) {
  TelemetryConfig config;
  config.grid = six_metres();
  Shown shown(config);
  shown.look();
  EXPECT_TRUE(shown.newest<ros::OccupancyGrid>(Channel::kPreviewBody).data.empty());
  shown.telemetry.preview({{-2, 0, 0}, {1, 0, 0}, {1, 0, 1.57}, {1, 1.5, 1.57}});
  shown.look();
  const auto body = shown.newest<ros::OccupancyGrid>(Channel::kPreviewBody);
  const double wide = config.outline.half_width + config.outline.clearance();
  for (double x = -2; x <= 1; x += 0.05) {
    EXPECT_TRUE(swept(body, x, wide - 0.03)) << x;
    EXPECT_TRUE(swept(body, x, -wide + 0.03)) << x;
  }
  for (double x = -2; x <= 0.3; x += 0.05) EXPECT_FALSE(swept(body, x, wide + 0.06)) << x;
  for (double y = 0; y <= 1.5; y += 0.05) EXPECT_TRUE(swept(body, 1 + wide - 0.03, y)) << y;
  EXPECT_FALSE(swept(body, 1, 2.1));
  EXPECT_LT(body.data.size(), six_metres().size()) << "only the part that holds it";
  shown.telemetry.preview({});
  shown.look();
  EXPECT_TRUE(shown.newest<ros::OccupancyGrid>(Channel::kPreviewBody).data.empty());
}

TEST(Telemetry, WhatTheBodySweepsStaysOnTheFloorInUse) {
  TelemetryConfig config;
  config.grid = six_metres();
  Shown shown(config);
  shown.telemetry.preview({{2.9, 2.9, 0}, {8, 8, 0}});
  shown.look();
  const auto body = shown.newest<ros::OccupancyGrid>(Channel::kPreviewBody);
  EXPECT_TRUE(swept(body, 2.9, 2.9));
  EXPECT_LE(body.info.origin.position.x + 0.05 * body.info.width, 3 + 1e-6);
  shown.telemetry.preview({{8, 8, 0}, {9, 9, 0}});
  shown.look();
  EXPECT_TRUE(shown.newest<ros::OccupancyGrid>(Channel::kPreviewBody).data.empty());
}

TEST(Telemetry, ShowsTheFloorThatTheBodySweepsAlongTheWayThatIsWalked) {
  TelemetryConfig config;
  config.grid = six_metres();
  config.grid.width = 200;
  Shown shown(config);
  shown.bench.until_walking(runtime::kAhead);
  shown.frame();
  shown.look();
  const auto body = shown.newest<ros::OccupancyGrid>(Channel::kPlanBody);
  for (const auto& pose : shown.newest<ros::Path>(Channel::kPlan).poses)
    EXPECT_TRUE(swept(body, pose.pose.position.x, pose.pose.position.y));
  const std::uint64_t number = shown.telemetry.newest(Channel::kPlanBody).number;
  shown.frame();
  shown.look();
  EXPECT_EQ(shown.telemetry.newest(Channel::kPlanBody).number, number) << "the same way is not sent again";
}

TEST(Telemetry, MakesNothingThatNobodyWants) {
  Shown shown;
  shown.telemetry.look({});
  shown.frame();
  shown.telemetry.look({});
  EXPECT_FALSE(shown.telemetry.newest(Channel::kPoints).cdr);
  EXPECT_FALSE(shown.telemetry.newest(Channel::kMap).cdr);
  shown.look();  // and what is wanted later is made of the newest there is
  EXPECT_TRUE(shown.telemetry.newest(Channel::kMap).cdr);
  EXPECT_TRUE(shown.telemetry.newest(Channel::kTf).cdr);
}

TEST(Telemetry, NumbersGrowByOneWithEachMessage) {
  Shown shown;
  shown.look();
  for (std::uint64_t i = 1; i <= 5; ++i) {
    shown.frame();
    shown.look();
    shown.look();
    EXPECT_EQ(shown.telemetry.newest(Channel::kTf).number, i);
  }
}

TEST(Telemetry, PicturesAreJpegOfTheirSize) {
  Shown shown;
  shown.picture = {200, 150, std::vector<std::uint8_t>(30000, 77)};
  shown.look();
  shown.frame();
  shown.look();
  const auto image = shown.newest<ros::CompressedImage>(Channel::kPicture);
  EXPECT_EQ(image.format, "jpeg");
  ASSERT_GT(image.data.size(), 100U);
  EXPECT_EQ(image.data[0], 0xFF);
  EXPECT_EQ(image.data[1], 0xD8);
}

TEST(Telemetry, TheFloorIsAFileForMapServers) {
  Shown shown;
  EXPECT_FALSE(shown.telemetry.file("map.pgm"));
  shown.frame();
  shown.look();
  const auto pgm = shown.telemetry.file("map.pgm"), yaml = shown.telemetry.file("map.yaml");
  ASSERT_TRUE(pgm && yaml);
  EXPECT_TRUE(pgm->starts_with("P5\n"));
  EXPECT_THAT(*yaml, testing::HasSubstr("image: map.pgm"));
  EXPECT_FALSE(shown.telemetry.file("../etc/passwd"));
}

}  // namespace
}  // namespace headway::remote
