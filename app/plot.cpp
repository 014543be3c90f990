#include "app/plot.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace headway::app {

namespace {

using Eigen::Vector2d;

constexpr int kFraction = 4;  // bits below the pixel
const Colour kGrid{232, 230, 228};

std::vector<Tick> ticks_of(const PlotAxis& axis, int wanted) {
  if (!axis.logarithmic && axis.lowest <= axis.highest)
    return linear_ticks(axis.lowest, axis.highest, wanted);
  std::vector<Tick> ticks;
  if (!axis.logarithmic) {
    ticks = linear_ticks(axis.highest, axis.lowest, wanted);
    for (Tick& tick : ticks) tick.share = 1 - tick.share;
    return ticks;
  }
  const double range = std::log(axis.highest / axis.lowest);
  for (double decade = std::pow(10, std::floor(std::log10(axis.lowest))); decade <= axis.highest;
       decade *= 10)
    for (const double lead : {1.0, 2.0, 5.0}) {
      const double share = std::log(lead * decade / axis.lowest) / range;
      if (share > -1e-9 && share < 1 + 1e-9) ticks.push_back({share, fmt::format("{:g}", lead * decade)});
    }
  return ticks;
}

}  // namespace

Plot::Plot(int width, int height, const PlotAxis& x, const PlotAxis& y, const std::string& title)
    : x_(x), y_(y), title_(title), frame_(64, 36, width - 64 - 20, height - 36 - 52) {
  image_ = canvas(width, height, colours::kPaper);
  for (const Tick& tick : ticks_of(x_, 8)) {
    const int at = frame_.x + static_cast<int>(std::lround(tick.share * frame_.width));
    cv::line(image_, {at, frame_.y}, {at, frame_.y + frame_.height}, scalar(kGrid));
  }
  for (const Tick& tick : ticks_of(y_, 6)) {
    const int at = frame_.y + static_cast<int>(std::lround((1 - tick.share) * frame_.height));
    cv::line(image_, {frame_.x, at}, {frame_.x + frame_.width, at}, scalar(kGrid));
  }
}

double Plot::share(const PlotAxis& axis, double value) const {
  if (axis.logarithmic)
    return std::log(std::max(value, 1e-12) / axis.lowest) / std::log(axis.highest / axis.lowest);
  return (value - axis.lowest) / (axis.highest - axis.lowest);
}

cv::Point Plot::pixel(const Vector2d& at) const {
  const double unit = 1 << kFraction;
  return {static_cast<int>(std::lround(unit * (frame_.x + share(x_, at.x()) * frame_.width))),
          static_cast<int>(std::lround(unit * (frame_.y + (1 - share(y_, at.y())) * frame_.height)))};
}

void Plot::line(const std::vector<Vector2d>& points, const Colour& colour, const std::string& label,
                int width) {
  std::vector<cv::Point> pixels;
  for (const Vector2d& p : points) pixels.push_back(pixel(p));
  cv::polylines(image_, pixels, false, scalar(colour), width, cv::LINE_AA, kFraction);
  if (!label.empty()) keys_.push_back({colour, label, Key::Shape::kLine});
}

void Plot::dots(const std::vector<Vector2d>& points, const Colour& colour, const std::string& label) {
  for (const Vector2d& p : points)
    cv::circle(image_, pixel(p), 4 << kFraction, scalar(colour), cv::FILLED, cv::LINE_AA, kFraction);
  if (!label.empty()) keys_.push_back({colour, label, Key::Shape::kDot});
}

void Plot::band(const std::vector<Vector2d>& lower, const std::vector<Vector2d>& upper, const Colour& colour,
                const std::string& label) {
  std::vector<cv::Point> pixels;
  for (const Vector2d& p : lower) pixels.push_back(pixel(p));
  for (auto p = upper.rbegin(); p != upper.rend(); ++p) pixels.push_back(pixel(*p));
  cv::fillPoly(image_, std::vector{pixels}, scalar(colour), cv::LINE_AA, kFraction);
  if (!label.empty()) keys_.push_back({colour, label, Key::Shape::kPatch});
}

void Plot::cell(const Vector2d& lowest, const Vector2d& highest, const Colour& colour) {
  cv::Point a = pixel(lowest), b = pixel(highest);
  const int half = 1 << (kFraction - 1);
  const auto whole = [&](int v) { return (v + half) >> kFraction; };
  const cv::Rect rect(cv::Point(whole(a.x), whole(b.y)), cv::Point(whole(b.x), whole(a.y)));
  image_(rect & frame_).setTo(scalar(colour));
}

void Plot::outline(const std::vector<Vector2d>& corners, const Colour& colour, int width) {
  std::vector<cv::Point> pixels;
  for (const Vector2d& p : corners) pixels.push_back(pixel(p));
  cv::polylines(image_, pixels, true, scalar(colour), width, cv::LINE_AA, kFraction);
}

void Plot::note(const Vector2d& at, const std::string& text, const Colour& colour, Align align, int lift) {
  const cv::Point p = pixel(at);
  draw_text(image_, text, {p.x >> kFraction, (p.y >> kFraction) - lift}, colour, 9, align);
}

void Plot::draw_axes(cv::Mat& image) const {
  // What ran over the frame is covered.
  const Colour paper = colours::kPaper;
  const int right = frame_.x + frame_.width, bottom = frame_.y + frame_.height;
  for (const cv::Rect& beside : {cv::Rect(0, 0, image.cols, frame_.y), cv::Rect(0, 0, frame_.x, image.rows),
                                 cv::Rect(right + 1, 0, image.cols - right - 1, image.rows),
                                 cv::Rect(0, bottom + 1, image.cols, image.rows - bottom - 1)})
    image(beside).setTo(scalar(paper));
  cv::rectangle(image, {frame_.x, frame_.y}, {right, bottom}, scalar(colours::kInk));
  for (const Tick& tick : ticks_of(x_, 8)) {
    const int at = frame_.x + static_cast<int>(std::lround(tick.share * frame_.width));
    cv::line(image, {at, bottom}, {at, bottom + 4}, scalar(colours::kInk));
    draw_text(image, tick.label, {at, bottom + 18}, colours::kInk, 9, Align::kCentre);
  }
  for (const Tick& tick : ticks_of(y_, 6)) {
    const int at = frame_.y + static_cast<int>(std::lround((1 - tick.share) * frame_.height));
    cv::line(image, {frame_.x - 4, at}, {frame_.x, at}, scalar(colours::kInk));
    draw_text(image, tick.label, {frame_.x - 8, at + 4}, colours::kInk, 9, Align::kRight);
  }
  draw_text(image, x_.label, {frame_.x + frame_.width / 2, bottom + 38}, colours::kInk, 10, Align::kCentre);
  draw_text(image, y_.label, {8, frame_.y - 8}, colours::kInk, 10);
  draw_text(image, title_, {frame_.x + frame_.width / 2, 16}, colours::kInk, 11, Align::kCentre);
}

cv::Mat Plot::finished(Corner keys_at) const {
  cv::Mat image = image_.clone();
  draw_axes(image);
  if (keys_.empty()) return image;
  int width = 0;
  for (const Key& key : keys_) width = std::max(width, 28 + text_width(key.label, 10));
  const int height = 22 * static_cast<int>(keys_.size());
  cv::Point at(frame_.x + 12, frame_.y + 8);
  if (keys_at != Corner::kTopLeft) at.x = frame_.x + frame_.width - width - 16;
  if (keys_at == Corner::kBottomRight) at.y = frame_.y + frame_.height - height - 8;
  const cv::Rect box(at.x - 6, at.y - 3, width + 14, height + 6);
  image(box & frame_).setTo(scalar(colours::kPaper));
  draw_keys(image, at, keys_, colours::kInk);
  return image;
}

}  // namespace headway::app
