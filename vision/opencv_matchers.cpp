#include "vision/opencv_matchers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>

#include "hal/error.h"
#include "vision/cv_image.h"

namespace headway::vision {

namespace {

constexpr int kScale = cv::StereoMatcher::DISP_SCALE;  // fixed-point disparities: 16 to the pixel

void require(bool good, const char* key, int value, const char* expected) {
  if (!good) throw InputError(fmt::format("matcher: {}: {}, expected {}", key, value, expected));
}

void check(DisparityRange range) {
  require(range.count > 0 && range.count % 16 == 0 && range.count <= 2048, "disparities", range.count,
          "a multiple of 16 up to 2048");
  require(std::abs(range.lowest) <= 2048, "lowest disparity", range.lowest, "-2048 to 2048");
}

cv::Ptr<cv::StereoMatcher> sgbm(DisparityRange range, const SgbmConfig& c) {
  check(range);
  require(c.block >= 1 && c.block <= 11 && c.block % 2 == 1, "block", c.block, "an odd number from 1 to 11");
  require(c.p1 > 0 && c.p1 < 10000, "p1", c.p1, "1 to 9999");
  require(c.p2 > c.p1 && c.p2 < 10000, "p2", c.p2, "more than p1, up to 9999");
  require(c.prefilter_cap >= 1 && c.prefilter_cap <= 63, "prefilter_cap", c.prefilter_cap, "1 to 63");
  require(c.uniqueness >= 0 && c.uniqueness <= 100, "uniqueness", c.uniqueness, "0 to 100");
  return cv::StereoSGBM::create(range.lowest, range.count, c.block, c.p1, c.p2, c.left_right_difference,
                                c.prefilter_cap, c.uniqueness, c.speckle_size, c.speckle_range,
                                cv::StereoSGBM::MODE_SGBM_3WAY);
}

cv::Ptr<cv::StereoMatcher> bm(DisparityRange range, const BmConfig& c) {
  check(range);
  require(c.block >= 5 && c.block <= 51 && c.block % 2 == 1, "block", c.block, "an odd number from 5 to 51");
  require(c.prefilter_cap >= 1 && c.prefilter_cap <= 63, "prefilter_cap", c.prefilter_cap, "1 to 63");
  require(c.texture >= 0, "texture", c.texture, "0 or more");
  require(c.uniqueness >= 0 && c.uniqueness <= 100, "uniqueness", c.uniqueness, "0 to 100");
  const cv::Ptr<cv::StereoBM> bm = cv::StereoBM::create(range.count, c.block);
  bm->setMinDisparity(range.lowest);
  bm->setPreFilterCap(c.prefilter_cap);
  bm->setTextureThreshold(c.texture);
  bm->setUniquenessRatio(c.uniqueness);
  bm->setDisp12MaxDiff(c.left_right_difference);
  bm->setSpeckleWindowSize(c.speckle_size);
  bm->setSpeckleRange(c.speckle_range * kScale);  // StereoBM takes it in its fixed-point units
  return bm;
}

}  // namespace

struct OpencvMatcher::State {
  cv::Ptr<cv::StereoMatcher> matcher;
  cv::Mat left, right, found;  // with borders
};

OpencvMatcher::OpencvMatcher(DisparityRange range, std::unique_ptr<State> state)
    : range_(range), state_(std::move(state)) {}

OpencvMatcher::~OpencvMatcher() = default;

SgbmMatcher::SgbmMatcher(DisparityRange range, const SgbmConfig& config)
    : OpencvMatcher(range, std::make_unique<State>(State{sgbm(range, config), {}, {}, {}})) {}

BmMatcher::BmMatcher(DisparityRange range, const BmConfig& config)
    : OpencvMatcher(range, std::make_unique<State>(State{bm(range, config), {}, {}, {}})) {}

void OpencvMatcher::match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) {
  out.resize(left.width, left.height);
  if (!complete(left) || !complete(right) || left.width != right.width || left.height != right.height) return;

  // OpenCV leaves out every column whose search would cross the border, though most of their partners lie
  // inside: with a border as wide as the search it fills them, and partners in the border are dropped below.
  const int before = std::max(0, range_.lowest + range_.count), after = std::max(0, -range_.lowest);
  State& s = *state_;
  cv::copyMakeBorder(as_mat(left), s.left, 0, 0, before, after, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(as_mat(right), s.right, 0, 0, before, after, cv::BORDER_REPLICATE);
  s.matcher->compute(s.left, s.right, s.found);

  const int lowest = range_.lowest * kScale;
  for (int v = 0; v < out.height; ++v) {
    const auto* row = s.found.ptr<std::int16_t>(v) + before;
    for (int u = 0; u < out.width; ++u) {
      if (row[u] < lowest) continue;  // OpenCV's mark for "none"
      const float d = static_cast<float>(row[u]) / kScale;
      const float partner = static_cast<float>(u) - d;
      if (partner >= 0 && partner <= static_cast<float>(out.width - 1)) out.values[out.index(u, v)] = d;
    }
  }
}

}  // namespace headway::vision
