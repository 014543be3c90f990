#include "app/head_views_picture.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "app/drawing.h"
#include "hal/angle.h"

namespace headway::app {

namespace {

constexpr int kSide = 520, kLeft = 56, kBelow = 64, kAbove = 16;  // [px]

const Colour kGrid{232, 228, 225}, kRing{40, 90, 240};

/// A square window of angles [deg] around all views.
struct Window {
  double pan = 0, tilt = 0, half = 1;

  explicit Window(const std::vector<HeadViewMark>& views) {
    double low_pan = 1e9, high_pan = -1e9, low_tilt = 1e9, high_tilt = -1e9;
    for (const HeadViewMark& v : views) {
      low_pan = std::min(low_pan, v.angles.pan / kDegree),
      high_pan = std::max(high_pan, v.angles.pan / kDegree);
      low_tilt = std::min(low_tilt, v.angles.tilt / kDegree),
      high_tilt = std::max(high_tilt, v.angles.tilt / kDegree);
    }
    pan = (low_pan + high_pan) / 2, tilt = (low_tilt + high_tilt) / 2;
    half = 0.55 * std::max({high_pan - low_pan, high_tilt - low_tilt, 2.0});
  }
  int x(double pan_deg) const {
    return kLeft + static_cast<int>(std::lround(kSide * (pan + half - pan_deg) / (2 * half)));
  }
  int y(double tilt_deg) const {
    return kAbove + static_cast<int>(std::lround(kSide * (tilt_deg - tilt + half) / (2 * half)));
  }
};

void draw_axes(cv::Mat& picture, const Window& w) {
  const double step = tick_step(2 * w.half, 6);
  for (double a = std::ceil((w.pan - w.half) / step) * step; a <= w.pan + w.half; a += step) {
    cv::line(picture, {w.x(a), kAbove}, {w.x(a), kAbove + kSide}, scalar(kGrid));
    draw_text(picture, fmt::format("{:g}", std::round(a * 100) / 100), {w.x(a), kAbove + kSide + 18},
              colours::kInk, 10, Align::kCentre);
  }
  for (double a = std::ceil((w.tilt - w.half) / step) * step; a <= w.tilt + w.half; a += step) {
    cv::line(picture, {kLeft, w.y(a)}, {kLeft + kSide, w.y(a)}, scalar(kGrid));
    draw_text(picture, fmt::format("{:g}", std::round(a * 100) / 100), {kLeft - 8, w.y(a) + 5}, colours::kInk,
              10, Align::kRight);
  }
  cv::rectangle(picture, {kLeft, kAbove, kSide, kSide}, scalar(colours::kInk));
  draw_text(picture, "pan [deg], positive looks left", {kLeft + kSide / 2, kAbove + kSide + 40},
            colours::kInk, 11, Align::kCentre);
  draw_text(picture, "tilt [deg], positive looks down", {kLeft + 8, kAbove + 18}, colours::kInk, 11);
}

}  // namespace

cv::Mat head_views_picture(const std::vector<HeadViewMark>& views) {
  cv::Mat picture = canvas(kLeft + kSide + 16, kAbove + kSide + kBelow, colours::kPaper);
  const Window window(views);
  draw_axes(picture, window);
  double largest = 0.1;
  for (const HeadViewMark& v : views) largest = std::max(largest, v.error);
  for (const HeadViewMark& v : views) {
    const cv::Point at(window.x(v.angles.pan / kDegree), window.y(v.angles.tilt / kDegree));
    cv::circle(picture, at, 6, scalar(ramp_colour(Ramp::kViridis, v.error / largest)), cv::FILLED,
               cv::LINE_AA);
    if (v.stands_out) cv::circle(picture, at, 10, scalar(kRing), 2, cv::LINE_AA);
  }
  return with_legend(
      picture,
      fmt::format("{} views of the board: rms distance of its corners [px]; ringed: stands out",
                  views.size()),
      Ramp::kViridis, linear_ticks(0, largest));
}

}  // namespace headway::app
