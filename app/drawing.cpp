#include "app/drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <sstream>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "hal/error.h"
#include "nav/whole_file.h"

namespace headway::app {

namespace {

constexpr int kKeyLine = 22, kKeyWidth = 20, kKeyText = 10;  // [px]

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapitalHeight = 21;  // of that font at scale 1 [px]

double font_scale(int height) { return height / kCapitalHeight; }

std::array<Colour, 256> ramp_table(int colormap) {
  cv::Mat1b shares(256, 1);
  for (int i = 0; i < 256; ++i) shares(i, 0) = static_cast<std::uint8_t>(i);
  cv::Mat3b colours;
  cv::applyColorMap(shares, colours, colormap);
  std::array<Colour, 256> table;
  for (int i = 0; i < 256; ++i) table[static_cast<std::size_t>(i)] = colours(i, 0);
  return table;
}

std::string length_label(double metres) {
  return metres < 0.999 ? fmt::format("{:g} mm", std::round(metres * 1e6) / 1e3)
                        : fmt::format("{:g} m", metres);
}

}  // namespace

cv::Scalar scalar(const Colour& colour) { return {double(colour[0]), double(colour[1]), double(colour[2])}; }

Colour ramp_colour(Ramp ramp, double share) {
  static const std::array<Colour, 256> viridis = ramp_table(cv::COLORMAP_VIRIDIS);
  static const std::array<Colour, 256> inferno = ramp_table(cv::COLORMAP_INFERNO);
  const auto i = static_cast<std::size_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
  return ramp == Ramp::kViridis ? viridis[i] : inferno[i];
}

Colour mixed(const Colour& a, const Colour& b, double share) {
  Colour out;
  for (int i = 0; i < 3; ++i) out[i] = static_cast<std::uint8_t>(std::lround(a[i] + share * (b[i] - a[i])));
  return out;
}

cv::Mat canvas(int width, int height, const Colour& background) {
  return cv::Mat(height, width, CV_8UC3, scalar(background));
}

void draw_text(cv::Mat& image, const std::string& text, cv::Point at, const Colour& colour, int height,
               Align align) {
  if (align != Align::kLeft) at.x -= text_width(text, height) / (align == Align::kCentre ? 2 : 1);
  cv::putText(image, text, at, kFont, font_scale(height), scalar(colour), height > 14 ? 2 : 1, cv::LINE_AA);
}

int text_width(const std::string& text, int height) {
  int below = 0;
  return cv::getTextSize(text, kFont, font_scale(height), 1, &below).width;
}

std::vector<std::string> wrapped(const std::string& text, int width, int height) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::string longer = lines.empty() ? word : lines.back() + ' ' + word;
    if (lines.empty() || text_width(longer, height) > width)
      lines.push_back(word);
    else
      lines.back() = longer;
  }
  return lines;
}

double tick_step(double range, int wanted) {
  const double raw = std::max(range, 1e-12) / std::max(wanted, 1);
  const double decade = std::pow(10.0, std::floor(std::log10(raw)));
  const double lead = raw / decade;
  return decade * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

std::vector<Tick> linear_ticks(double lowest, double highest, int wanted) {
  std::vector<Tick> ticks;
  const double range = highest - lowest;
  if (!(range > 0)) return ticks;
  const double step = tick_step(range, wanted);
  const auto first = static_cast<int>(std::ceil(lowest / step - 1e-9));
  const auto last = static_cast<int>(std::floor(highest / step + 1e-9));
  for (int i = first; i <= last; ++i) {
    const double value = std::round(i * step * 1e6) / 1e6;
    ticks.push_back({(value - lowest) / range, fmt::format("{:g}", value)});
  }
  return ticks;
}

std::vector<Tick> logarithmic_length_ticks(double lowest, double highest) {
  std::vector<Tick> ticks;
  if (!(lowest > 0) || !(highest > lowest)) return ticks;
  const double range = std::log(highest / lowest);
  for (double decade = std::pow(10.0, std::floor(std::log10(lowest))); decade <= highest; decade *= 10) {
    for (const double lead : {1.0, 2.0, 5.0}) {
      const double value = lead * decade;
      if (value < lowest * (1 - 1e-9) || value > highest * (1 + 1e-9)) continue;
      ticks.push_back({std::log(value / lowest) / range, length_label(value)});
    }
  }
  return ticks;
}

cv::Mat with_legend(const cv::Mat& image, const std::string& title, Ramp ramp,
                    const std::vector<Tick>& ticks) {
  constexpr int kLine = 20, kInset = 8, kPanel = 96, kBar = 18, kMargin = 12;
  const std::vector<std::string> lines = wrapped(title, image.cols + kPanel - 2 * kInset);
  const int top = 10 + kLine * std::max(1, static_cast<int>(lines.size()));
  cv::Mat out = canvas(image.cols + kPanel, image.rows + top, colours::kBackground);
  image.copyTo(out(cv::Rect(0, top, image.cols, image.rows)));
  int baseline = 0;
  for (const std::string& line : lines) draw_text(out, line, {kInset, baseline += kLine}, colours::kPale);
  const cv::Rect bar(image.cols + kMargin, top + kMargin, kBar, std::max(1, image.rows - 2 * kMargin));
  for (int y = 0; y < bar.height; ++y) {
    const double share = 1 - y / std::max(1.0, bar.height - 1.0);
    out(cv::Rect(bar.x, bar.y + y, bar.width, 1)).setTo(scalar(ramp_colour(ramp, share)));
  }
  for (const Tick& tick : ticks) {
    const int y = bar.y + static_cast<int>(std::lround((1 - tick.share) * (bar.height - 1)));
    cv::line(out, {bar.x + bar.width, y}, {bar.x + bar.width + 4, y}, scalar(colours::kPale));
    draw_text(out, tick.label, {bar.x + bar.width + 7, y + 4}, colours::kPale, 9);
  }
  return out;
}

cv::Size size_of(const std::vector<Key>& keys) {
  int width = 0;
  for (const Key& key : keys) width = std::max(width, text_width(key.label, kKeyText));
  return {kKeyWidth + 8 + width, kKeyLine * static_cast<int>(keys.size())};
}

void draw_plate(cv::Mat& image, const cv::Rect& area) {
  cv::Mat part = image(area & cv::Rect(0, 0, image.cols, image.rows));
  cv::addWeighted(part, 0.15, cv::Mat(part.size(), CV_8UC3, scalar(colours::kPaper)), 0.85, 0, part);
}

int draw_keys(cv::Mat& image, cv::Point top_left, const std::vector<Key>& keys, const Colour& ink) {
  constexpr int kLine = kKeyLine, kWidth = kKeyWidth;
  int y = top_left.y;
  for (const Key& key : keys) {
    const cv::Point middle(top_left.x + kWidth / 2, y + kLine / 2);
    const cv::Rect patch(top_left.x, y + 5, kWidth, kLine - 10);
    switch (key.shape) {
      case Key::Shape::kPatch:
        cv::rectangle(image, patch, scalar(key.colour), cv::FILLED);
        cv::rectangle(image, patch, scalar(mixed(key.colour, ink, 0.5)));
        break;
      case Key::Shape::kFrame:
        cv::rectangle(image, patch, scalar(key.colour), 2);
        break;
      case Key::Shape::kDot:
        cv::circle(image, middle, 5, scalar(key.colour), cv::FILLED, cv::LINE_AA);
        break;
      case Key::Shape::kLine:
        cv::line(image, {top_left.x, middle.y}, {top_left.x + kWidth, middle.y}, scalar(key.colour), 3,
                 cv::LINE_AA);
        break;
    }
    draw_text(image, key.label, {top_left.x + kWidth + 8, y + kLine / 2 + 5}, ink, kKeyText);
    y += kLine;
  }
  return y - top_left.y;
}

void draw_scale_bar(cv::Mat& image, cv::Point at, double px_per_metre, int wanted_px, const Colour& colour) {
  const double metres = tick_step(wanted_px / px_per_metre, 1);
  const auto width = static_cast<int>(std::lround(metres * px_per_metre));
  cv::rectangle(image, {at.x, at.y - 2}, {at.x + width, at.y + 2}, scalar(colour), cv::FILLED);
  draw_text(image, length_label(metres), {at.x + width / 2, at.y - 7}, colour, 10, Align::kCentre);
}

cv::Mat strip(const std::vector<Captioned>& pictures) {
  constexpr int kGap = 6, kCaption = 32;
  if (pictures.empty()) return canvas(1, 1, colours::kPaper);
  const int height = pictures.front().image.rows;
  std::vector<cv::Mat> scaled;
  int width = -kGap;
  for (const Captioned& p : pictures) {
    cv::Mat image = p.image;
    if (image.rows != height) {
      const double scale = static_cast<double>(height) / image.rows;
      const int columns = std::max(1, static_cast<int>(std::lround(image.cols * scale)));
      cv::resize(p.image, image, {columns, height}, 0, 0, cv::INTER_AREA);
    }
    width += image.cols + kGap;
    scaled.push_back(image);
  }
  cv::Mat out = canvas(width, height + kCaption, colours::kPaper);
  int x = 0;
  for (std::size_t i = 0; i < scaled.size(); ++i) {
    scaled[i].copyTo(out(cv::Rect(x, 0, scaled[i].cols, height)));
    draw_text(out, pictures[i].caption, {x + scaled[i].cols / 2, height + 21}, colours::kInk, 12,
              Align::kCentre);
    x += scaled[i].cols + kGap;
  }
  return out;
}

void write_png(const cv::Mat& image, const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes;
  if (image.empty() || !cv::imencode(".png", image, bytes)) {
    throw InputError(file.string() + ": there is no picture to write");
  }
  nav::write_whole(file, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  });
}

}  // namespace headway::app
