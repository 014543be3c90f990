// How fast vision is, against the plain way of doing the same, in one run on one core. Highway is held to
// AVX2, so that the figures of two machines can be compared; the report's machine says what was used.
#include <Eigen/SVD>
#include <random>
#include <vector>

#include <opencv2/core/utility.hpp>

#include "bench/cpu_time.h"
#include "bench/figures.h"
#include "bench/hold_to_avx2.h"
#include "vision/dense_covariance.h"
#include "vision/paper_covariance.h"
#include "vision/visible_rows.h"

namespace headway {
namespace {

using bench::LeastTime;
using vision::ProjectionMatrix;

// HRP-2's lower pair: 33 deg wide, 0.144 m apart.
const vision::RectifiedRig kRig{{640, 480, 1080.301895, 319.5, 239.5}, 0.144, 0, 0.8, 6, 0.3};

double between(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

/// A point and its covariance by the paper's equations, one by one.
class OneByOne {
 public:
  explicit OneByOne(std::size_t count) : matches_(count) {
    const vision::PinholeCamera& c = kRig.camera;
    left_ << c.focal, 0, c.cx, 0, 0, c.focal, c.cy, 0, 0, 0, 1, 0;
    right_ = left_;
    right_(0, 3) = -c.focal * kRig.baseline;
    std::mt19937_64 random(1);
    for (Match& m : matches_) {
      m.in_left = {between(random, 100, 600), between(random, 0, 480)};
      m.in_right = m.in_left - Eigen::Vector2d(between(random, 20, 99), 0);
    }
  }
  void operator()() const {
    for (const Match& m : matches_) {
      const Eigen::Matrix4d a = vision::pixel_equations(left_, right_, m.in_left, m.in_right);
      const Eigen::Vector4d q = Eigen::JacobiSVD<Eigen::Matrix4d>(a, Eigen::ComputeFullV).matrixV().col(3);
      const Eigen::Matrix3d sigma =
          vision::with_paper_covariance(left_, right_, q, 0.09 * Eigen::Matrix4d::Identity())
              .euclidean_covariance();
      benchmark::DoNotOptimize(sigma.data());
    }
  }

 private:
  struct Match {
    Eigen::Vector2d in_left, in_right;
  };
  ProjectionMatrix left_, right_;
  std::vector<Match> matches_;
};

/// The same of all pixels of an image at once.
class AllAtOnce {
 public:
  AllAtOnce() {
    std::mt19937_64 random(2);
    disparity_.resize(kRig.camera.width, kRig.camera.height);
    const auto draw = [&](std::vector<float>& plane, double low, double high) {
      plane.resize(disparity_.values.size());
      for (float& value : plane) value = static_cast<float>(between(random, low, high));
    };
    draw(disparity_.values, 20, 99);
    draw(disparity_.sigma, 0.2, 0.6);
    draw(weight_, 0, 1);
  }
  std::size_t size() const { return weight_.size(); }
  void operator()() {
    vision::dense_points(disparity_, weight_, kRig, vision::PixelErrors::kPlaceAndDisparity, points_);
    benchmark::DoNotOptimize(points_[vision::DensePoints::kZZ].data());
  }

 private:
  vision::DisparityImage disparity_;
  std::vector<float> weight_;
  vision::DensePoints points_;
};

void covariance(benchmark::State& state) {
  constexpr int kRounds = 15, kImages = 5;
  constexpr std::size_t kMatches = 2000;
  const OneByOne one_by_one(kMatches);
  AllAtOnce all_at_once;
  LeastTime svd, dense;
  for (auto _ : state)
    for (int round = 0; round < kRounds; ++round) {
      svd.take(one_by_one);
      for (int image = 0; image < kImages; ++image) dense.take(all_at_once);
    }
  const double svd_ns = svd.seconds() / static_cast<double>(kMatches) * 1e9;
  const double dense_ns = dense.seconds() / static_cast<double>(all_at_once.size()) * 1e9;
  state.counters["cov_ns_per_point"] = dense_ns;
  state.counters["cov_ratio_svd"] = svd_ns / dense_ns;
}
BENCHMARK(covariance)->Iterations(1)->Unit(benchmark::kMillisecond);

/// What the pair sees from 0.4 to 5 m: six half-spaces.
std::vector<Eigen::Vector4d> seen_by_the_pair() {
  const vision::PinholeCamera& c = kRig.camera;
  const double right = c.width - 0.5 - c.cx, below = c.height - 0.5 - c.cy;
  return {{c.focal, 0, c.cx + 0.5, -c.focal * kRig.baseline},
          {-c.focal, 0, right, 0},
          {0, c.focal, c.cy + 0.5, 0},
          {0, -c.focal, below, 0},
          {0, 0, 1, -0.4},
          {0, 0, -1, 5}};
}

/// The voxels of a room of 6 x 6 x 2.5 m that the pair sees, standing in it and looking down and aside.
void visible_rows(benchmark::State& state) {
  const vision::VoxelGrid grid{Eigen::Vector3d::Zero(), 0.02, 300, 300, 125};
  Eigen::Isometry3d map_from_camera(Eigen::Translation3d(1, 3, 1.4));
  Eigen::Matrix3d map_from_optical;
  map_from_optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  map_from_camera.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) * map_from_optical *
                         Eigen::AngleAxisd(-0.35, Eigen::Vector3d::UnitX()));
  const std::vector<Eigen::Vector4d> rows = seen_by_the_pair();
  vision::VisibleRows visible;
  std::vector<std::uint8_t> inside(std::size_t{300} * 300 * 125);
  std::size_t in_rows = 0, pointwise = 0;
  LeastTime by_row, by_point;
  constexpr int kRounds = 7;
  for (auto _ : state)
    for (int round = 0; round < kRounds; ++round) {
      for (int again = 0; again < kRounds; ++again)
        by_row.take([&] { benchmark::DoNotOptimize(visible.find(rows, grid, map_from_camera).data()); });
      by_point.take([&] {
        std::uint8_t* voxel = inside.data();
        for (int k = 0; k < grid.nz; ++k)
          for (int j = 0; j < grid.ny; ++j) {
            const double y = grid.centre(1, j), z = grid.centre(2, k);
            for (int i = 0; i < grid.nx; ++i)
              *voxel++ = vision::contains(visible.in_map(), grid.centre(0, i), y, z);
          }
        benchmark::DoNotOptimize(inside.data());
      });
    }
  for (const vision::RowSpan& span : visible.find(rows, grid, map_from_camera))
    in_rows += static_cast<std::size_t>(span.last - span.first);
  for (const std::uint8_t voxel : inside) pointwise += voxel;
  if (in_rows == 0 || in_rows != pointwise) state.SkipWithError("rows and points see different voxels");
  state.counters["rows_ms"] = by_row.seconds() * 1e3;
  state.counters["rows_ratio_pointwise"] = by_point.seconds() / by_row.seconds();
  state.counters["rows_visible_share"] = static_cast<double>(in_rows) / static_cast<double>(inside.size());
}
BENCHMARK(visible_rows)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  headway::bench::fact("highway_target", headway::bench::hold_to_avx2());
  return headway::bench::run(argc, argv);
}
