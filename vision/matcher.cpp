#include "vision/matcher.h"

#include <algorithm>
#include <cmath>

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

void check(DisparityRange range, const SgbmConfig& c) {
  require(range.count > 0 && range.count % 16 == 0 && range.count <= 2048, "disparities", range.count,
          "a multiple of 16 up to 2048");
  require(std::abs(range.lowest) <= 2048, "lowest disparity", range.lowest, "-2048 to 2048");
  require(c.block >= 1 && c.block <= 11 && c.block % 2 == 1, "block", c.block, "an odd number from 1 to 11");
  require(c.p1 > 0 && c.p1 < 10000, "p1", c.p1, "1 to 9999");
  require(c.p2 > c.p1 && c.p2 < 10000, "p2", c.p2, "more than p1, up to 9999");
  require(c.prefilter_cap >= 1 && c.prefilter_cap <= 63, "prefilter_cap", c.prefilter_cap, "1 to 63");
  require(c.uniqueness >= 0 && c.uniqueness <= 100, "uniqueness", c.uniqueness, "0 to 100");
}

}  // namespace

struct SgbmMatcher::State {
  cv::Ptr<cv::StereoSGBM> sgbm;
  cv::Mat left, right, found;  // with borders
};

SgbmMatcher::SgbmMatcher(DisparityRange range, const SgbmConfig& c)
    : range_(range), state_(std::make_unique<State>()) {
  check(range, c);
  state_->sgbm = cv::StereoSGBM::create(range.lowest, range.count, c.block, c.p1, c.p2,
                                        c.left_right_difference, c.prefilter_cap, c.uniqueness,
                                        c.speckle_size, c.speckle_range, cv::StereoSGBM::MODE_SGBM_3WAY);
}

SgbmMatcher::~SgbmMatcher() = default;

void SgbmMatcher::match(const hal::GrayImage& left, const hal::GrayImage& right, DisparityImage& out) {
  out.resize(left.width, left.height);
  if (!complete(left) || !complete(right) || left.width != right.width || left.height != right.height) return;

  // OpenCV leaves out every column whose search would cross the border, though most of their partners lie
  // inside: with a border as wide as the search it fills them, and partners in the border are dropped below.
  const int before = std::max(0, range_.lowest + range_.count), after = std::max(0, -range_.lowest);
  State& s = *state_;
  cv::copyMakeBorder(as_mat(left), s.left, 0, 0, before, after, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(as_mat(right), s.right, 0, 0, before, after, cv::BORDER_REPLICATE);
  s.sgbm->compute(s.left, s.right, s.found);

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
