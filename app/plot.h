// Plots: curves, bands and dots over two axes, with a legend.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/drawing.h"

namespace headway::app {

struct PlotAxis {
  double lowest = 0, highest = 1;
  std::string label;         ///< with its unit
  bool logarithmic = false;  ///< marks at 1, 2, 5 times powers of ten
};

class Plot {
 public:
  Plot(int width, int height, const PlotAxis& x, const PlotAxis& y, const std::string& title);

  void line(const std::vector<Eigen::Vector2d>& points, const Colour& colour, const std::string& label,
            int width = 2);
  void dots(const std::vector<Eigen::Vector2d>& points, const Colour& colour, const std::string& label);
  /// The area between two curves over the same x.
  void band(const std::vector<Eigen::Vector2d>& lower, const std::vector<Eigen::Vector2d>& upper,
            const Colour& colour, const std::string& label);
  /// A cell of a map, from corner to corner, filled.
  void cell(const Eigen::Vector2d& lowest, const Eigen::Vector2d& highest, const Colour& colour);
  /// The outline of a polygon.
  void outline(const std::vector<Eigen::Vector2d>& corners, const Colour& colour, int width = 2);
  void note(const Eigen::Vector2d& at, const std::string& text, const Colour& colour,
            Align align = Align::kCentre, int lift = 0);

  /// A line of the legend for what was drawn without one.
  void key(const Key& key) { keys_.push_back(key); }

  /// Axes, title and legend (in the corner `keys_at` of the frame) are drawn over all that.
  enum class Corner { kTopLeft, kTopRight, kBottomRight };
  cv::Mat finished(Corner keys_at = Corner::kTopLeft) const;

 private:
  cv::Point pixel(const Eigen::Vector2d& at) const;
  double share(const PlotAxis& axis, double value) const;
  void draw_axes(cv::Mat& image) const;

  PlotAxis x_, y_;
  std::string title_;
  cv::Rect frame_;
  cv::Mat image_;
  std::vector<Key> keys_;
};

}  // namespace headway::app
