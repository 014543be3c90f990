// A small picture of things in space: triangles, dots and lines before one perspective camera, with a depth
// buffer.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "app/drawing.h"
#include "app/map_view.h"

namespace headway::app {

/// A point or direction of an optical frame (x right, y down, z forward) with x forward, y left, z up.
inline Eigen::Vector3d upright(const Eigen::Vector3d& p) { return {p.z(), -p.x(), -p.y()}; }

/// Everything is in one frame [m] with z up. Drawn at twice the size and shrunk at the end, so that edges are
/// smooth. What comes to lie behind the eye is left out.
class ScenePicture {
 public:
  ScenePicture(const ScenePicture& other)
      : eye_(other.eye_),
        forward_(other.forward_),
        right_(other.right_),
        up_(other.up_),
        focal_(other.focal_),
        image_(other.image_.clone()),
        depth_(other.depth_.clone()) {}
  ScenePicture& operator=(const ScenePicture&) = delete;
  ScenePicture(const Lookout& from, int width, int height, const Colour& background = colours::kPaper);

  /// Filled; colours are mixed between its corners.
  void triangle(const std::array<Eigen::Vector3d, 3>& corners, const std::array<Colour, 3>& colours);
  /// The same, in one colour, darker where it is turned away from the light.
  void lit_triangle(const std::array<Eigen::Vector3d, 3>& corners, const Colour& colour);
  /// A disc of `radius` [px] that faces the eye.
  void dot(const Eigen::Vector3d& at, double radius, const Colour& colour);
  /// `width` [px]; what lies behind other things shows through as `behind` (0..1) of its colour.
  void line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Colour& colour, double width,
            double behind = 0.3);

  /// Where the point comes to lie in the finished picture, to write beside it.
  std::optional<cv::Point> pixel(const Eigen::Vector3d& point) const;
  cv::Mat finished() const;

 private:
  static constexpr int kFine = 2;
  struct Place {
    double x = 0, y = 0, depth = 0;  // [fine px], [m]
  };
  std::optional<Place> place(const Eigen::Vector3d& point) const;
  void paint(int x, int y, double depth, const Colour& colour);

  Eigen::Vector3d eye_, forward_, right_, up_;
  double focal_;  // [fine px]
  cv::Mat3b image_;
  cv::Mat1f depth_;
};

/// An eye in the direction `azimuth` (counter-clockwise from +x) and `elevation` above the horizon [rad], as
/// near as it can be while all `points` are in a picture of this size.
Lookout framing(const std::vector<Eigen::Vector3d>& points, double azimuth, double elevation, int width,
                int height, double field = 0.5);

}  // namespace headway::app
