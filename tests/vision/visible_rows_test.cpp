#include "vision/visible_rows.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_rig.h"
#include "tests/every_target.h"

namespace headway::vision {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::Vector4d;
using test::between;

using Rows = std::vector<Vector4d>;

int whole(int lowest, int highest) { return *rc::gen::inRange(lowest, highest + 1); }

// On a lattice of eighths, where sums and products are exact and planes go through centres of voxels.
double eighths(int reach) { return whole(-reach, reach) / 8.0; }

VoxelGrid some_grid() {
  VoxelGrid grid;
  const bool lattice = *rc::gen::arbitrary<bool>();
  grid.resolution = lattice ? 0.25 : between(0.01, 0.5);
  grid.origin = lattice ? Vector3d(eighths(16), eighths(16), eighths(16))
                        : Vector3d(between(-3, 3), between(-3, 3), between(-3, 3));
  grid.nx = whole(0, 40), grid.ny = whole(0, 20), grid.nz = whole(0, 6);
  return grid;
}

Vector3d some_centre(const VoxelGrid& grid) {
  return {grid.centre(0, whole(0, grid.nx)), grid.centre(1, whole(0, grid.ny)),
          grid.centre(2, whole(0, grid.nz))};
}

// A half-space whose plane goes through some voxel's centre, as exactly as its numbers allow.
Vector4d through_a_centre(const VoxelGrid& grid) {
  Vector3d normal(eighths(8), eighths(8), eighths(8));
  switch (whole(0, 4)) {
    case 0:
      normal = Vector3d::Unit(whole(0, 2)) * (whole(0, 1) ? 1 : -1);
      break;
    case 1:
      normal.x() = 0;
      break;
    case 2:
      normal.x() = std::ldexp(1.0, -whole(40, 60));
      break;  // all but along the rows
    case 3:
      normal = Vector3d(between(-1, 1), between(-1, 1), between(-1, 1));
      break;
    default:
      break;
  }
  Vector4d row;
  row << normal, -normal.dot(some_centre(grid));
  return row;
}

Vector4d some_half_space(const VoxelGrid& grid) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  switch (whole(0, 20)) {
    case 0:
      return {0, 0, 0, double(whole(-1, 1))};  // nothing, all, and the plane that is everywhere
    case 1:
      return {0, 0, 0, kNone};
    case 2:
      return {between(-1, 1) * 1e-300, 1e-300, 0, 0};
    default:
      return through_a_centre(grid);
  }
}

Rows some_polytope(const VoxelGrid& grid) {
  Rows rows;
  for (int i = whole(0, 7); i > 0; --i) rows.push_back(some_half_space(grid));
  if (!rows.empty() && whole(0, 3) == 0) rows.push_back(-rows.front());  // flat: a plane is all that is left
  if (!rows.empty() && whole(0, 3) == 0) rows.push_back(rows.front());
  return rows;
}

Isometry3d some_pose() {
  Isometry3d pose = Isometry3d::Identity();
  switch (whole(0, 2)) {
    case 0:
      break;
    case 1: {  // turned by right angles, moved on the lattice
      Eigen::Matrix3d turn;
      turn << 0, 0, 1, -1, 0, 0, 0, -1, 0;
      pose.linear() = turn;
      pose.translation() = Vector3d(eighths(8), eighths(8), eighths(8));
      break;
    }
    default:
      pose = Eigen::AngleAxisd(between(-3, 3),
                               Vector3d(between(0.1, 1), between(-1, 1), between(-1, 1)).normalized());
      pose.translation() = Vector3d(between(-1, 1), between(-1, 1), between(-1, 1));
  }
  return pose;
}

RC_GTEST_PROP(VisibleRows, HoldExactlyTheVoxelsThatTheTestOfAPointHolds, ()) {
  const VoxelGrid grid = some_grid();
  const Isometry3d map_from_camera = some_pose(), camera_from_map = map_from_camera.inverse();
  Rows rows = some_polytope(grid);
  for (Vector4d& row : rows) row = moved(row, camera_from_map);  // so that the ties are in the map
  headway::test::on_every_target([&](const char*) {
    VisibleRows visible;
    const auto spans = visible.find(rows, grid, map_from_camera);
    RC_ASSERT(spans.size() == static_cast<std::size_t>(grid.ny * grid.nz));
    for (int k = 0; k < grid.nz; ++k)
      for (int j = 0; j < grid.ny; ++j) {
        const RowSpan& span = spans[static_cast<std::size_t>(k * grid.ny + j)];
        RC_ASSERT(span.first < span.last || span == RowSpan());
        for (int i = 0; i < grid.nx; ++i)
          RC_ASSERT(contains(visible.in_map(), grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)) ==
                    (i >= span.first && i < span.last));
      }
  });
}

// What two cameras side by side see, from 0.3 to 4 m.
Rows some_field() {
  const double f = between(200, 600), baseline = between(0.03, 0.2), half_width = 160, half_height = 120;
  return {{f, 0, half_width, -f * baseline}, {-f, 0, half_width, 0}, {0, f, half_height, 0},
          {0, -f, half_height, 0},           {0, 0, 1, -0.3},        {0, 0, -1, 4}};
}

// Against the polytope where it was given, in the camera's frame.
RC_GTEST_PROP(VisibleRows, LieWhereTheCameraSeesThem, ()) {
  VoxelGrid grid = some_grid();
  const Isometry3d map_from_camera = some_pose(), camera_from_map = map_from_camera.inverse();
  const Rows rows = some_field();
  grid.origin =
      map_from_camera * Vector3d(0, 0, 2) - grid.resolution / 2 * Vector3d(grid.nx, grid.ny, grid.nz);
  VisibleRows visible;
  const auto spans = visible.find(rows, grid, map_from_camera);
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j)
      for (int i = 0; i < grid.nx; ++i) {
        const Vector3d p =
            camera_from_map * Vector3d(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
        double least = std::numeric_limits<double>::infinity();
        for (const Vector4d& row : rows) least = std::min(least, row.dot(p.homogeneous()));
        const RowSpan& span = spans[static_cast<std::size_t>(k * grid.ny + j)];
        if (std::abs(least) > 1e-9) RC_ASSERT((least > 0) == (i >= span.first && i < span.last));
      }
}

TEST(VisibleRows, TakeAPlaneOnTheLatticeAsInside) {
  const VoxelGrid grid{Vector3d(-0.25, -0.25, -0.25), 0.5, 8, 4, 4};  // centres at 0, 0.5, 1, ...
  VisibleRows visible;
  const Rows box{{1, 0, 0, -1}, {-1, 0, 0, 2.5}, {0, 1, 0, -0.5}, {0, 0, -1, 1}};
  const auto spans = visible.find(box, grid, Isometry3d::Identity());
  EXPECT_EQ(spans[0], (RowSpan{0, 0})) << "y 0 is outside";
  EXPECT_EQ(spans[1], (RowSpan{2, 6})) << "x 1 to 2.5, both ends on planes; y 0.5 on a plane";
  EXPECT_EQ(spans[2 * 4 + 3], (RowSpan{2, 6})) << "z 1 on a plane";
  EXPECT_EQ(spans[3 * 4 + 3], (RowSpan{0, 0})) << "z 1.5 is outside";
}

TEST(VisibleRows, OfNoHalfSpaceAreAllAndOfNoGridNone) {
  VisibleRows visible;
  const VoxelGrid grid{Vector3d::Zero(), 0.1, 5, 3, 2};
  for (const RowSpan& span : visible.find({}, grid, Isometry3d::Identity())) EXPECT_EQ(span, (RowSpan{0, 5}));
  EXPECT_TRUE(visible.find({}, VoxelGrid{}, Isometry3d::Identity()).empty());
  EXPECT_TRUE(visible.find({}, VoxelGrid{Vector3d::Zero(), 0.1, 5, -3, -2}, Isometry3d::Identity()).empty());
}

TEST(VisibleRows, KeepTheirMemory) {
  VisibleRows visible;
  const VoxelGrid grid{Vector3d::Zero(), 0.1, 5, 30, 20};
  const Rows rows{{1, 0, 0, 0}, {0, 1, 0, 0}};
  const auto first = visible.find(rows, grid, Isometry3d::Identity());
  const Vector4d* in_map = visible.in_map().data();
  visible.find(rows, VoxelGrid{Vector3d::Zero(), 0.1, 5, 10, 20}, Isometry3d::Identity());
  EXPECT_EQ(visible.find(rows, grid, Isometry3d::Identity()).data(), first.data());
  EXPECT_EQ(visible.in_map().data(), in_map);
}

RC_GTEST_PROP(Containment, OfManyPointsIsThatOfEach, ()) {
  const VoxelGrid grid = some_grid();
  std::vector<float> x, y, z;
  for (int i = whole(0, 40); i > 0; --i) {
    const Eigen::Vector3f p = some_centre(grid).cast<float>();
    x.push_back(p.x()), y.push_back(p.y());
    z.push_back(whole(0, 9) ? p.z() : std::numeric_limits<float>::quiet_NaN());
  }
  Rows rows = some_polytope(grid);
  for (Vector4d& row : rows) {  // each through a point, to the last bit
    if (x.empty()) break;
    const auto i = static_cast<std::size_t>(whole(0, static_cast<int>(x.size()) - 1));
    row[3] = -side({row[0], row[1], row[2], 0}, static_cast<double>(x[i]), static_cast<double>(y[i]),
                   static_cast<double>(z[i]));
  }
  headway::test::on_every_target([&](const char*) {
    std::vector<std::uint8_t> inside(x.size(), 7);
    contains(rows, x, y, z, inside);
    for (std::size_t i = 0; i < x.size(); ++i)
      RC_ASSERT((inside[i] == 1) == contains(rows, static_cast<double>(x[i]), static_cast<double>(y[i]),
                                             static_cast<double>(z[i])));
    RC_ASSERT(std::ranges::all_of(inside, [](std::uint8_t b) { return b <= 1; }));
  });
}

}  // namespace
}  // namespace headway::vision
