#include "app/resolution_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "app/plot.h"

namespace headway::app {

namespace {

constexpr double kTop = 0.86;

}  // namespace

ResolutionScale::ResolutionScale(double lowest, double highest)
    : lowest_(lowest), highest_(std::max(highest, 1.01 * lowest)) {}

ResolutionScale::ResolutionScale(const vision::Characteristics& rig)
    : lowest_(std::numeric_limits<double>::infinity()), highest_(0) {
  for (const vision::SightAt& s : rig.sights) {
    lowest_ = std::min(lowest_, s.on_axis);
    highest_ = std::max({highest_, s.on_axis, s.worst});
  }
  highest_ = std::max(highest_, 1.01 * lowest_);
}

Colour ResolutionScale::colour(double resolution) const {
  return ramp_colour(Ramp::kInferno, kTop * std::log(resolution / lowest_) / std::log(highest_ / lowest_));
}

cv::Mat ResolutionScale::bar(int height) const {
  constexpr int kWidth = 118, kMargin = 40;
  cv::Mat out = canvas(kWidth, height, colours::kPaper);
  const cv::Rect bar(14, kMargin, 18, height - 2 * kMargin);
  for (int y = 0; y < bar.height; ++y)
    out(cv::Rect(bar.x, bar.y + y, bar.width, 1)) =
        ramp_colour(Ramp::kInferno, kTop * (1 - y / (bar.height - 1.0)));
  for (const Tick& tick : logarithmic_length_ticks(lowest_, highest_)) {
    const int y = bar.y + static_cast<int>(std::lround((1 - tick.share) * (bar.height - 1)));
    out(cv::Rect(bar.x + bar.width, y, 4, 1)) = colours::kInk;
    draw_text(out, tick.label, {bar.x + bar.width + 8, y + 4}, colours::kInk, 9);
  }
  draw_text(out, "resolution", {bar.x, kMargin - 14}, colours::kInk, 9);
  return out;
}

cv::Mat ResolutionScale::beside(std::vector<cv::Mat> pictures) const {
  int height = 0;
  for (const cv::Mat& p : pictures) height = std::max(height, p.rows);
  pictures.push_back(bar(height));
  for (cv::Mat& p : pictures) {
    const int above = (height - p.rows) / 2;
    const Colour paper = colours::kPaper;
    cv::Mat padded;
    cv::copyMakeBorder(p, padded, above, height - p.rows - above, 0, 0, cv::BORDER_CONSTANT,
                       cv::Scalar(paper[0], paper[1], paper[2]));
    p = padded;
  }
  cv::Mat out;
  cv::hconcat(pictures, out);
  return out;
}

}  // namespace headway::app
