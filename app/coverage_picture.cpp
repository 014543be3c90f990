#include "app/coverage_picture.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "app/drawing.h"

namespace headway::app {

namespace {

constexpr int kCellsAcross = 10;
constexpr int kWidth = 560;  // [px] of one camera's panel
constexpr int kMargin = 16, kTitle = 34, kLegend = 74;

const Colour kNever{205, 205, 225}, kCross{110, 90, 200}, kUsual{60, 50, 45}, kOutlier{40, 90, 240};

/// Light, so that dots stay visible on it.
Colour cell_colour(int corners, int most) {
  const double share = std::log1p(corners) / std::log1p(std::max(1, most));
  return mixed(colours::kPaper, ramp_colour(Ramp::kViridis, 0.35 + 0.4 * share), 0.25 + 0.45 * share);
}

struct Panel {
  cv::Rect area;
  double px_per_px;  ///< of the panel per pixel of the image

  cv::Point at(const Eigen::Vector2d& pixel) const {
    return {area.x + static_cast<int>(std::lround((pixel.x() + 0.5) * px_per_px)),
            area.y + static_cast<int>(std::lround((pixel.y() + 0.5) * px_per_px))};
  }
  cv::Rect cell(int i, const Coverage& c) const {
    const auto x = [&](int n) { return area.x + n * area.width / c.across; };
    const auto y = [&](int n) { return area.y + n * area.height / c.down; };
    const int column = i % c.across, row = i / c.across;
    return {cv::Point(x(column), y(row)), cv::Point(x(column + 1), y(row + 1))};
  }
};

void draw_cells(cv::Mat& picture, const Panel& panel, const Coverage& coverage) {
  const int most = *std::max_element(coverage.corners.begin(), coverage.corners.end());
  for (int i = 0; i < coverage.across * coverage.down; ++i) {
    const cv::Rect cell = panel.cell(i, coverage);
    const int corners = coverage.corners[static_cast<std::size_t>(i)];
    cv::rectangle(picture, cell, scalar(corners > 0 ? cell_colour(corners, most) : kNever), cv::FILLED);
    if (corners == 0) {
      const cv::Point inset(cell.width / 4, cell.height / 4), rise(cell.width / 4, -cell.height / 4);
      const cv::Point middle = (cell.tl() + cell.br()) / 2;
      cv::line(picture, middle - inset, middle + inset, scalar(kCross), 2, cv::LINE_AA);
      cv::line(picture, middle - rise, middle + rise, scalar(kCross), 2, cv::LINE_AA);
    }
    cv::rectangle(picture, cell, scalar(colours::kPaper));
  }
  cv::rectangle(picture, panel.area, scalar(colours::kInk));
}

}  // namespace

std::vector<const vision::BoardView*> views_of(const std::vector<vision::BoardPair>& pairs,
                                               vision::BoardView vision::BoardPair::*side) {
  std::vector<const vision::BoardView*> views;
  for (const vision::BoardPair& pair : pairs) views.push_back(&(pair.*side));
  return views;
}

double Coverage::share() const {
  const auto seen = std::count_if(corners.begin(), corners.end(), [](int n) { return n > 0; });
  return corners.empty() ? 0 : static_cast<double>(seen) / static_cast<double>(corners.size());
}

Coverage coverage_of(const std::vector<const vision::BoardView*>& views, int width, int height) {
  Coverage c;
  c.across = std::min(kCellsAcross, width);
  c.down = std::clamp(static_cast<int>(std::lround(double(c.across) * height / width)), 1, height);
  c.corners.assign(static_cast<std::size_t>(c.across * c.down), 0);
  for (const vision::BoardView* view : views) {
    for (const Eigen::Vector2d& pixel : view->pixels) {
      const auto cell = [](double at, int size, int cells) {
        return std::clamp(static_cast<int>(std::floor((at + 0.5) * cells / size)), 0, cells - 1);
      };
      const int i = cell(pixel.y(), height, c.down) * c.across + cell(pixel.x(), width, c.across);
      ++c.corners[static_cast<std::size_t>(i)];
    }
  }
  return c;
}

cv::Mat coverage_picture(const std::vector<vision::BoardPair>& pairs, const std::vector<bool>& standing_out,
                         int width, int height) {
  const double scale = double(kWidth) / width;
  const int panel_height = static_cast<int>(std::lround(scale * height));
  cv::Mat picture = canvas(2 * kWidth + 3 * kMargin, kTitle + panel_height + kLegend, colours::kPaper);
  bool outliers = false;
  for (const bool right : {false, true}) {
    const Panel panel{{right ? kWidth + 2 * kMargin : kMargin, kTitle, kWidth, panel_height}, scale};
    const auto side = right ? &vision::BoardPair::right : &vision::BoardPair::left;
    const std::vector<const vision::BoardView*> views = views_of(pairs, side);
    const Coverage coverage = coverage_of(views, width, height);
    draw_cells(picture, panel, coverage);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      outliers = outliers || standing_out[i];
      for (const Eigen::Vector2d& pixel : views[i]->pixels)
        cv::circle(picture, panel.at(pixel), 2, scalar(standing_out[i] ? kOutlier : kUsual), cv::FILLED,
                   cv::LINE_AA);
    }
    draw_text(picture,
              fmt::format("{} camera: corners in {} pairs, {:.0f} % of the cells", right ? "right" : "left",
                          pairs.size(), 100 * coverage.share()),
              {panel.area.x, kTitle - 12}, colours::kInk);
  }
  const int y = kTitle + panel_height + 8;
  std::vector<Key> dots{{kUsual, "a corner, as seen", Key::Shape::kDot}};
  if (outliers) dots.push_back({kOutlier, "of a pair that stands out", Key::Shape::kDot});
  draw_keys(picture, {kMargin, y}, dots, colours::kInk);
  draw_keys(picture, {kMargin + 260, y},
            {{cell_colour(100, 100), "cell that saw many corners"}, {cell_colour(1, 100), "few"}},
            colours::kInk);
  draw_keys(picture, {kMargin + 560, y}, {{kNever, "crossed out: no corner seen; show the board there too"}},
            colours::kInk);
  return picture;
}

}  // namespace headway::app
