#include "app/scene_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace headway::app {

namespace {

using Eigen::Vector3d;

constexpr double kNearest = 0.05;  // before the eye nothing is drawn [m]

int rounded_up(double v) { return static_cast<int>(std::ceil(v)); }

}  // namespace

ScenePicture::ScenePicture(const Lookout& from, int width, int height, const Colour& background)
    : eye_(from.eye),
      image_(height * kFine, width * kFine, cv::Vec3b(background)),
      depth_(height * kFine, width * kFine, std::numeric_limits<float>::infinity()) {
  forward_ = (from.target - from.eye).normalized();
  const Vector3d up =
      std::abs(forward_.z()) > 0.9999 ? Vector3d(Vector3d::UnitY()) : Vector3d(Vector3d::UnitZ());
  right_ = forward_.cross(up).normalized();
  up_ = right_.cross(forward_);
  focal_ = width * kFine / 2.0 / std::tan(from.field / 2);
}

std::optional<ScenePicture::Place> ScenePicture::place(const Vector3d& point) const {
  const Vector3d p = point - eye_;
  const double depth = forward_.dot(p);
  if (!(depth > kNearest)) return std::nullopt;
  return Place{image_.cols / 2.0 + focal_ * right_.dot(p) / depth,
               image_.rows / 2.0 - focal_ * up_.dot(p) / depth, depth};
}

void ScenePicture::paint(int x, int y, double depth, const Colour& colour) {
  if (static_cast<float>(depth) >= depth_(y, x)) return;
  depth_(y, x) = static_cast<float>(depth);
  image_(y, x) = colour;
}

void ScenePicture::triangle(const std::array<Vector3d, 3>& corners, const std::array<Colour, 3>& colours) {
  const auto a = place(corners[0]), b = place(corners[1]), c = place(corners[2]);
  if (!a || !b || !c) return;
  const double area = (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
  if (std::abs(area) < 1e-9) return;
  const int y0 = std::max(0, rounded_up(std::min({a->y, b->y, c->y}) - 0.5));
  const int y1 = std::min(image_.rows, rounded_up(std::max({a->y, b->y, c->y}) - 0.5));
  const int x0 = std::max(0, rounded_up(std::min({a->x, b->x, c->x}) - 0.5));
  const int x1 = std::min(image_.cols, rounded_up(std::max({a->x, b->x, c->x}) - 0.5));
  const bool plain = colours[0] == colours[1] && colours[1] == colours[2];
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double wb = ((px - a->x) * (c->y - a->y) - (py - a->y) * (c->x - a->x)) / area;
      const double wc = ((b->x - a->x) * (py - a->y) - (b->y - a->y) * (px - a->x)) / area;
      const double wa = 1 - wb - wc;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      // 1/depth is linear in the picture.
      const double depth = 1 / (wa / a->depth + wb / b->depth + wc / c->depth);
      Colour colour = colours[0];
      for (int i = 0; i < 3 && !plain; ++i)
        colour[i] =
            cv::saturate_cast<std::uint8_t>(wa * colours[0][i] + wb * colours[1][i] + wc * colours[2][i]);
      paint(x, y, depth, colour);
    }
}

void ScenePicture::lit_triangle(const std::array<Vector3d, 3>& corners, const Colour& colour) {
  const Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  // From over the viewer's left shoulder.
  const Vector3d light = (up_ - 0.6 * right_ - 0.8 * forward_).normalized();
  const double share = 0.55 + 0.45 * std::max(0.0, normal.dot(light));
  const Colour lit = mixed({0, 0, 0}, colour, share);
  triangle(corners, {lit, lit, lit});
}

void ScenePicture::dot(const Vector3d& at, double radius, const Colour& colour) {
  const auto p = place(at);
  if (!p) return;
  const double r = radius * kFine;
  for (int y = std::max(0, rounded_up(p->y - r - 0.5)); y < std::min<double>(image_.rows, p->y + r - 0.5);
       ++y)
    for (int x = std::max(0, rounded_up(p->x - r - 0.5)); x < std::min<double>(image_.cols, p->x + r - 0.5);
         ++x)
      if (std::hypot(x + 0.5 - p->x, y + 0.5 - p->y) <= r) paint(x, y, p->depth, colour);
}

void ScenePicture::line(const Vector3d& a, const Vector3d& b, const Colour& colour, double width,
                        double behind) {
  const auto pa = place(a), pb = place(b);
  if (!pa || !pb) return;
  const double length = std::hypot(pb->x - pa->x, pb->y - pa->y), half = width * kFine / 2;
  if (length < 1e-9) return;
  const double ux = (pb->x - pa->x) / length, uy = (pb->y - pa->y) / length;
  const int x0 = std::max(0, rounded_up(std::min(pa->x, pb->x) - half)),
            y0 = std::max(0, rounded_up(std::min(pa->y, pb->y) - half));
  const int x1 = std::min(image_.cols, rounded_up(std::max(pa->x, pb->x) + half)),
            y1 = std::min(image_.rows, rounded_up(std::max(pa->y, pb->y) + half));
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const double dx = x + 0.5 - pa->x, dy = y + 0.5 - pa->y;
      if (std::abs(dx * uy - dy * ux) > half) continue;
      const double share = std::clamp((dx * ux + dy * uy) / length, 0.0, 1.0);
      const double depth = 1 / ((1 - share) / pa->depth + share / pb->depth);
      if (static_cast<float>(0.999 * depth) < depth_(y, x))
        paint(x, y, 0.999 * depth, colour);
      else
        image_(y, x) = mixed(image_(y, x), colour, behind);
    }
}

std::optional<cv::Point> ScenePicture::pixel(const Vector3d& point) const {
  const auto p = place(point);
  if (!p) return std::nullopt;
  return cv::Point(static_cast<int>(std::lround(p->x / kFine)), static_cast<int>(std::lround(p->y / kFine)));
}

cv::Mat ScenePicture::finished() const {
  cv::Mat out;
  cv::resize(image_, out, {image_.cols / kFine, image_.rows / kFine}, 0, 0, cv::INTER_AREA);
  return out;
}

Lookout framing(const std::vector<Vector3d>& points, double azimuth, double elevation, int width, int height,
                double field) {
  const Vector3d towards(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                         std::sin(elevation));
  const Vector3d right = Vector3d::UnitZ().cross(towards).normalized(), up = towards.cross(right);
  const double across = 0.94 * std::tan(field / 2), upward = across * height / width;
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  Vector3d target = box.center();
  double distance = 0;
  // Moving the target to the middle of what is seen lets the eye come nearer; this settles quickly.
  for (int round = 0; round < 6; ++round) {
    distance = 0;
    for (const Vector3d& p : points) {
      const Vector3d d = p - target;
      distance = std::max(
          distance, std::max(std::abs(d.dot(right)) / across, std::abs(d.dot(up)) / upward) + d.dot(towards));
    }
    Eigen::AlignedBox2d seen;
    for (const Vector3d& p : points) {
      const Vector3d d = p - target;
      seen.extend(Eigen::Vector2d(d.dot(right), d.dot(up)) / (distance - d.dot(towards)));
    }
    target += distance * (seen.center().x() * right + seen.center().y() * up);
  }
  return {target + distance * towards, target, field};
}

}  // namespace headway::app
