// How fast vision is, against the plain way of doing the same, in one run on one core. Highway is held to
// AVX2, so that the figures of two machines can be compared; the report's machine says what was used.
#include <random>
#include <vector>

#include <hwy/targets.h>
#include <opencv2/core/utility.hpp>

#include "bench/cpu_time.h"
#include "bench/figures.h"
#include "vision/paper_covariance.h"

namespace headway {
namespace {

using bench::LeastTime;
using vision::ProjectionMatrix;

// HRP-2's lower pair: 33 deg wide, 0.144 m apart.
const vision::RectifiedRig kRig{{640, 480, 1080.301895, 319.5, 239.5}, 0.144, 0, 0.8, 6, 0.3};

struct Match {
  Eigen::Vector2d in_left, in_right;
};

std::vector<Match> some_matches(std::size_t count) {
  std::mt19937_64 random(1);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  std::vector<Match> matches(count);
  for (Match& m : matches) {
    m.in_left = {between(100, 600), between(0, 480)};
    m.in_right = m.in_left - Eigen::Vector2d(between(20, 99), 0);
  }
  return matches;
}

/// One point's covariance as the paper computes it.
void covariance(benchmark::State& state) {
  const vision::PinholeCamera& c = kRig.camera;
  ProjectionMatrix left, right;
  left << c.focal, 0, c.cx, 0, 0, c.focal, c.cy, 0, 0, 0, 1, 0;
  right = left;
  right(0, 3) = -c.focal * kRig.baseline;
  const std::vector<Match> matches = some_matches(20000);
  LeastTime by_svd;
  for (auto _ : state)
    for (int round = 0; round < 5; ++round)
      by_svd.take([&] {
        for (const Match& m : matches)
          benchmark::DoNotOptimize(
              vision::triangulate_as_the_paper(left, right, m.in_left, m.in_right, 0.5)->covariance.data());
      });
  state.counters["cov_svd_ns_per_point"] = by_svd.seconds() / static_cast<double>(matches.size()) * 1e9;
}
BENCHMARK(covariance)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Highway's AVX2 kernels, or the best that this processor has below it. Returns the name.
const char* hold_to_avx2() {
  constexpr std::int64_t kBeyond = HWY_AVX3 | HWY_AVX3_DL;
  hwy::DisableTargets(kBeyond);
  const std::int64_t left = hwy::SupportedTargets();
  hwy::GetChosenTarget().Update(left);
  return hwy::TargetName(left & -left);  // the lowest bit is the best target
}

}  // namespace
}  // namespace headway

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  headway::bench::fact("highway_target", headway::hold_to_avx2());
  return headway::bench::run(argc, argv);
}
