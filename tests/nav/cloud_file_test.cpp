#include "nav/cloud_file.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "synthetic_room.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Matrix3d, Eigen::Vector3d;

/// A reader of its own, for little-endian machines.
struct Vertex {
  float x, y, z;
  std::uint8_t red, green, blue;
  float cov[6];
};

std::vector<Vertex> read_ply(const std::filesystem::path& file) {
  static_assert(std::endian::native == std::endian::little);
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::string end = "end_header\n";
  const std::size_t start = text.find(end) + end.size();
  std::istringstream header(text.substr(0, start));
  std::string line;
  std::size_t count = 0;
  std::string properties;
  while (std::getline(header, line)) {
    if (line.starts_with("element vertex ")) count = std::stoul(line.substr(15));
    if (line.starts_with("property ")) properties += line.substr(9) + ";";
  }
  EXPECT_EQ(
      properties,
      "float x;float y;float z;uchar red;uchar green;uchar blue;float cov_xx;float cov_xy;float cov_xz;float "
      "cov_yy;float cov_yz;float cov_zz;");
  constexpr std::size_t kBytes = 39;
  EXPECT_EQ(text.size(), start + kBytes * count);
  std::vector<Vertex> vertices(count);
  for (std::size_t i = 0; i < count; ++i) {
    const char* p = text.data() + start + i * kBytes;
    std::memcpy(&vertices[i].x, p, 12);
    std::memcpy(&vertices[i].red, p + 12, 3);
    std::memcpy(vertices[i].cov, p + 15, 24);
  }
  return vertices;
}

TEST(CloudFile, HoldsThePointsOfTheViewInTheMapFrame) {
  const auto room = SyntheticRoom::furnished();
  const Isometry3d pose = camera_pose({-1, 0.2, 1.4}, 0.3, 0.2);
  const auto view = look(room, camera_of(40, 60, 0.6), pose);
  CloudFile cloud;
  cloud.add(view, pose);
  const TemporaryFolder folder;
  cloud.write(folder / "cloud.ply");
  const auto vertices = read_ply(folder / "cloud.ply");
  ASSERT_EQ(vertices.size(), cloud.size());
  ASSERT_EQ(vertices.size(), 2400U);
  for (const Vertex& v : vertices) {
    EXPECT_NEAR(room.clearance(
                    Vector3d(static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z))),
                0, 1e-4);
  }
}

// Oracle: the spread of points drawn around the measurement, turned into the map.
TEST(CloudFile, TurnsTheCovarianceIntoTheMapFrame) {
  const Isometry3d pose = camera_pose({1, 2, 3}, 0.8, 0.4);
  vision::RangeView view{{1, 1, 300, -40, -25}, 0.5, 5, {2.5F}, {0.04F}};
  CloudFile cloud;
  cloud.add(view, pose);
  std::mt19937_64 random(3);
  Matrix3d sum = Matrix3d::Zero();
  Vector3d mean = pose * view.camera.point(0, 0, 2.5);
  constexpr int kDraws = 200000;
  for (int k = 0; k < kDraws; ++k) {
    const double u = uniform(random) - 0.5, v = uniform(random) - 0.5, z = 2.5 + 0.04 * normal(random);
    const Vector3d p = pose * view.camera.point(u, v, z);
    sum += (p - mean) * (p - mean).transpose();
  }
  sum /= kDraws;
  const CloudPoint& p = cloud.points().front();
  Matrix3d written;
  written << p.xx, p.xy, p.xz, p.xy, p.yy, p.yz, p.xz, p.yz, p.zz;
  EXPECT_LT((written - sum).norm(), 0.02 * sum.norm());
}

TEST(CloudFile, LeavesOutWhatIsNotMeasuredAndShowsUncertaintyFromBlueToRed) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  vision::RangeView view{{5, 1, 300, 2, 0}, 0.5, 5, {1, kNan, 2, 9, 0.1F}, {1e-4F, kNan, 0.5F, 0.1F, 0.1F}};
  CloudFile cloud;
  cloud.add(view, Isometry3d::Identity());
  const TemporaryFolder folder;
  cloud.write(folder / "cloud.ply");
  const auto vertices = read_ply(folder / "cloud.ply");
  ASSERT_EQ(vertices.size(), 2U);
  EXPECT_GT(vertices[0].blue, 100);
  EXPECT_EQ(vertices[0].red, 0);
  EXPECT_GT(vertices[1].red, 100);
  EXPECT_EQ(vertices[1].blue, 0);
}

TEST(CloudFile, ThinsOutOnRequestAndRefusesAFolderThatIsNotThere) {
  const auto view = look(SyntheticRoom{}, camera_of(40, 60, 0.6), camera_pose({0, 0, 1}, 0, 0));
  CloudFile cloud({.every = 4});
  cloud.add(view, Isometry3d::Identity());
  EXPECT_EQ(cloud.size(), 150U);
  EXPECT_THROW(cloud.write("/nonexistent/cloud.ply"), InputError);
}

}  // namespace
}  // namespace headway::nav
