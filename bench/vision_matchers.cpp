// How good and how quick the census matcher is beside OpenCV's semi-global one, on real pairs with truth.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/cpu_time.h"
#include "vision/census_matcher.h"
#include "vision/cv_image.h"

namespace headway::bench {

namespace {

namespace fs = std::filesystem;

/// A pair with its true disparities [px]; 0 is unknown.
struct Scene {
  std::string name;
  int disparities = 64;
  cv::Mat left, right, truth;
};

std::optional<Scene> scene(const std::string& name, int disparities, const fs::path& left,
                           const fs::path& right, const fs::path& truth, double truth_unit) {
  Scene s{name,
          disparities,
          cv::imread(left.string(), cv::IMREAD_GRAYSCALE),
          cv::imread(right.string(), cv::IMREAD_GRAYSCALE),
          {}};
  const cv::Mat units = cv::imread(truth.string(), cv::IMREAD_UNCHANGED);
  if (s.left.empty() || s.right.empty() || units.empty()) return std::nullopt;
  units.convertTo(s.truth, CV_32F, truth_unit);
  return s;
}

std::optional<Scene> of_data(const std::string& name) {
  const char* data = std::getenv("HEADWAY_DATA");
  const fs::path folder = fs::path(data ? data : "") / "stereo" / name;
  return scene(name, 64, folder / "left.png", folder / "right.png", folder / "gt16.png", 1.0 / 256);
}

std::optional<Scene> aloe() {
  const fs::path folder = "/usr/share/doc/opencv-doc/examples/data";
  return scene("aloe", 128, folder / "aloeL.jpg", folder / "aloeR.jpg", folder / "aloeGT.png", 1);
}

void resize(Scene& s, cv::Size size) {
  const double scale = static_cast<double>(size.width) / s.left.cols;
  cv::resize(s.left, s.left, size, 0, 0, cv::INTER_AREA);
  cv::resize(s.right, s.right, size, 0, 0, cv::INTER_AREA);
  cv::resize(s.truth, s.truth, size, 0, 0, cv::INTER_NEAREST);
  s.truth *= scale;
}

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  if (auto s = of_data("motorcycle")) resize(*s, {640, 480}), all.push_back(std::move(*s));
  if (auto s = aloe()) resize(*s, s->left.size() / 2), all.push_back(std::move(*s));
  if (auto s = of_data("tsukuba")) all.push_back(std::move(*s));
  return all;
}

hal::GrayImage plain(const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  return {whole.cols, whole.rows, {whole.data, whole.data + whole.total()}};
}

cv::Ptr<cv::StereoSGBM> sgbm(int disparities) {
  return cv::StereoSGBM::create(0, disparities, 3, 72, 288, 1, 31, 10, 100, 2,
                                cv::StereoSGBM::MODE_SGBM_3WAY);
}

cv::Mat half_a_row_lower(const cv::Mat& image) {
  cv::Mat out;
  const cv::Matx23d shift(1, 0, 0, 0, 1, 0.5);
  cv::warpAffine(image, out, shift, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return out;
}

vision::DisparityImage by_sgbm(const Scene& s, const cv::Mat& right) {
  cv::Mat found;
  sgbm(s.disparities)->compute(s.left, right, found);
  vision::DisparityImage out;
  out.resize(found.cols, found.rows);
  for (int v = 0; v < found.rows; ++v)
    for (int u = 0; u < found.cols; ++u)
      if (const auto d = found.at<std::int16_t>(v, u); d >= 0)
        out.values[out.index(u, v)] = static_cast<float>(d) / 16;
  return out;
}

vision::DisparityImage by_census(const Scene& s, const cv::Mat& right) {
  vision::CensusMatcher matcher({0, s.disparities});
  vision::DisparityImage out;
  matcher.match(plain(s.left), plain(right), out);
  return out;
}

/// The columns that OpenCV searches in full; the same for both.
template <class Use>
void for_each_known(const Scene& s, const vision::DisparityImage& found, const Use& use) {
  for (int v = 0; v < s.truth.rows; ++v)
    for (int u = s.disparities; u < s.truth.cols; ++u)
      if (const float truth = s.truth.at<float>(v, u); truth > 0)
        use(found.index(u, v), std::abs(found.values[found.index(u, v)] - truth));
}

double bad2h(const Scene& s, const vision::DisparityImage& found) {
  double known = 0, bad = 0;
  for_each_known(s, found, [&](std::size_t, float error) { ++known, bad += !(error <= 2); });
  return 100 * bad / known;
}

/// How often, of a wrong match and a right one, the wrong one is the more ambiguous; ties count half.
double auc(const Scene& s, const vision::DisparityImage& found) {
  std::vector<float> right, wrong;
  for_each_known(s, found, [&](std::size_t i, float error) {
    if (!std::isnan(error)) (error > 2 ? wrong : right).push_back(found.ambiguity[i]);
  });
  std::sort(right.begin(), right.end());
  double above = 0;
  for (const float a : wrong) {
    const auto [first, last] = std::equal_range(right.begin(), right.end(), a);
    above += static_cast<double>(first - right.begin()) + 0.5 * static_cast<double>(last - first);
  }
  return above / static_cast<double>(right.size()) / static_cast<double>(wrong.size());
}

/// matcher_cpu_ratio_3way, _128 and _192: processor time of the census matcher over that of StereoSGBM
/// (MODE_SGBM_3WAY) at 64, 128 and 192 disparities, 640 x 480, one thread, taking turns. Both leave out the
/// columns that OpenCV leaves out.
void matcher_time(benchmark::State& state) {
  auto pair = of_data("motorcycle");
  if (!pair) return state.SkipWithError("stereo/motorcycle is missing in HEADWAY_DATA");
  resize(*pair, {640, 480});
  const hal::GrayImage left = plain(pair->left), right = plain(pair->right);
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
        their_time.take([&] { theirs->compute(pair->left, pair->right, found); });
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
/// how well the ambiguity predicts errors of more than 2 px.
void matcher_errors(benchmark::State& state) {
  const std::vector<Scene> all = scenes();
  if (all.size() < 3)
    return state.SkipWithError("pairs are missing: HEADWAY_DATA's stereo, or Debian's opencv-doc");
  for (auto _ : state)
    for (const Scene& s : all)
      for (const bool shifted : {false, true}) {
        const cv::Mat right = shifted ? half_a_row_lower(s.right) : s.right;
        const vision::DisparityImage ours = by_census(s, right);
        const std::string key = s.name + (shifted ? "_shift" : "");
        state.counters["matcher_bad2h_" + key] = bad2h(s, ours);
        state.counters["sgbm_bad2h_" + key] = bad2h(s, by_sgbm(s, right));
        if (!shifted) state.counters["matcher_auc_" + s.name] = auc(s, ours);
      }
}
BENCHMARK(matcher_errors)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace headway::bench
