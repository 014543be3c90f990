// How good and how quick the census matcher is beside OpenCV's semi-global one, on pairs with truth.
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>

#include "bench/cpu_time.h"
#include "tests/true_pairs/true_pairs.h"
#include "vision/census_matcher.h"
#include "vision/cv_image.h"
#include "vision/disparity_sigma.h"
#include "vision/doubt.h"
#include "vision/evaluation.h"
#include "vision/match_weight.h"

namespace headway::bench {

namespace {

cv::Ptr<cv::StereoSGBM> sgbm(int disparities) {
  return cv::StereoSGBM::create(0, disparities, 3, 72, 288, 1, 31, 10, 100, 2,
                                cv::StereoSGBM::MODE_SGBM_3WAY);
}

vision::DisparityImage by_sgbm(const TruePair& pair, const hal::GrayImage& right) {
  cv::Mat found;
  sgbm(pair.disparities)->compute(vision::as_mat(pair.left), vision::as_mat(right), found);
  vision::DisparityImage out;
  out.resize(found.cols, found.rows);
  for (int v = 0; v < found.rows; ++v)
    for (int u = 0; u < found.cols; ++u)
      if (const auto d = found.at<std::int16_t>(v, u); d >= 0)
        out.values[out.index(u, v)] = static_cast<float>(d) / 16;
  return out;
}

vision::DisparityImage by_census(const TruePair& pair, const hal::GrayImage& right) {
  vision::CensusMatcher matcher({0, pair.disparities});
  vision::DisparityImage out;
  matcher.match(pair.left, right, out);
  return out;
}

/// matcher_cpu_ratio_3way, _128 and _192: processor time of the census matcher over that of StereoSGBM
/// (MODE_SGBM_3WAY) at 64, 128 and 192 disparities, 640 x 480, one thread, taking turns. Both leave out the
/// columns that OpenCV leaves out.
void matcher_time(benchmark::State& state) {
  const std::vector<TruePair> real = real_pairs();
  if (real.empty() || real.front().name != "motorcycle")
    return state.SkipWithError("stereo/motorcycle is missing in HEADWAY_DATA");
  const hal::GrayImage &left = real.front().left, &right = real.front().right;
  for (auto _ : state)
    for (const int disparities : {64, 128, 192}) {
      constexpr int kRounds = 15;
      const auto theirs = sgbm(disparities);
      vision::CensusConfig config;
      config.borders = false;
      vision::CensusMatcher ours({0, disparities}, config);
      LeastTime their_time, our_time;
      cv::Mat found;
      vision::DisparityImage out;
      for (int round = 0; round < kRounds; ++round) {
        their_time.take([&] { theirs->compute(vision::as_mat(left), vision::as_mat(right), found); });
        our_time.take([&] { ours.match(left, right, out); });
      }
      const std::string at = disparities == 64 ? "" : "_" + std::to_string(disparities);
      state.counters["matcher_cpu_ratio_3way" + at] = our_time.seconds() / their_time.seconds();
      state.counters["matcher_cpu_ms" + at] = 1e3 * our_time.seconds();
    }
}

BENCHMARK(matcher_time)->Iterations(1)->Unit(benchmark::kMillisecond);

/// matcher_bad2h_NAME and sgbm_bad2h_NAME: the percentage of pixels with a truth that are off by more than 2
/// px or not matched; ending in _shift, the same where the right image is half a row lower. matcher_auc_NAME:
/// how well the weight predicts errors of more than 2 px. Of the real pairs that the matcher was made
/// with, and of others that it was not.
void matcher_errors(benchmark::State& state) {
  std::vector<TruePair> all = real_pairs();
  const std::vector<TruePair> held_out = held_out_pairs();
  if (all.size() < 3)
    return state.SkipWithError("pairs are missing: HEADWAY_DATA's stereo, or Debian's opencv-doc");
  all.insert(all.end(), held_out.begin(), held_out.end());
  for (auto _ : state)
    for (const TruePair& pair : all)
      for (const bool shifted : {false, true}) {
        const hal::GrayImage& right = shifted ? pair.right_askew : pair.right;
        vision::DisparityImage found = by_census(pair, right);
        estimate_doubt({}, found);
        estimate_sigma({}, found);
        estimate_weight({}, found);
        const vision::MatchQuality ours = compare(found, pair.truth);
        const std::string key = pair.name + (shifted ? "_shift" : "");
        state.counters["matcher_bad2h_" + key] = 100 * ours.wrong_or_missing();
        state.counters["sgbm_bad2h_" + key] =
            100 * compare(by_sgbm(pair, right), pair.truth).wrong_or_missing();
        if (shifted) continue;
        state.counters["matcher_auc_" + pair.name] = ours.weight_auc;
        state.counters["coverage_3_sigma_" + pair.name] = ours.coverage_3_sigma;
      }
}
BENCHMARK(matcher_errors)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway::bench
