#include "app/map_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/map_figures.h"
#include "app/voxel_rays.h"

namespace headway::app {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFloorBand = 0.12;   // what is this near to the floor is drawn as floor [m]
constexpr double kVeilOpacity = 0.3;  // of one face of unseen space

const Colour kSky{250, 246, 242}, kFloor{206, 208, 204}, kVeil{200, 120, 170}, kGridLine{225, 218, 212};

/// Directions of the picture's pixels.
class Camera {
 public:
  Camera(const Lookout& from, int width, int height) : width_(width), height_(height) {
    forward_ = (from.target - from.eye).normalized();
    // Straight up or down there is no horizon: north is up then.
    const Eigen::Vector3d up =
        std::abs(forward_.z()) > 0.9999 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
    right_ = forward_.cross(up).normalized();
    up_ = right_.cross(forward_);
    per_pixel_ = 2 * std::tan(from.field / 2) / width;
  }
  Eigen::Vector3d direction(int x, int y) const {
    const double right = (x + 0.5 - width_ / 2.0) * per_pixel_, up = (height_ / 2.0 - y - 0.5) * per_pixel_;
    return (forward_ + right * right_ + up * up_).normalized();
  }

 private:
  int width_, height_;
  double per_pixel_ = 0;
  Eigen::Vector3d forward_, right_, up_;
};

double brightness(const VoxelFace& face) {
  if (face.axis == 2) return face.side > 0 ? 1.0 : 0.55;
  return (face.axis == 0 ? 0.86 : 0.72) - (face.side < 0 ? 0.05 : 0.0);
}

std::string height_label(double z) { return fmt::format("{:g} m up", std::round(z * 100) / 100); }

class Painter {
 public:
  Painter(const nav::VoxelMap& map, const Lookout& from, const MapViewConfig& config,
          const MapFigures& figures)
      : map_(map),
        config_(config),
        eye_(from.eye),
        camera_(from, config.width, config.height),
        rays_(map, {config.lowest, config.highest, config.seen_sides_only, kGap, config.show_unseen}),
        boxes_(figures, config.floor_height),
        marks_(figures) {}

  cv::Mat paint() {
    cv::Mat image = canvas(config_.width, config_.height, kSky);
    std::vector<float> above(static_cast<std::size_t>(config_.width), 0.0F), row = above;
    for (int y = 0; y < config_.height; ++y) {
      for (int x = 0; x < config_.width; ++x) {
        double depth = kInfinity;
        Colour colour = look(camera_.direction(x, y), depth);
        const auto i = static_cast<std::size_t>(x);
        row[i] = static_cast<float>(depth);
        // A line where the depth jumps: shapes of one colour stand out from each other.
        if ((x > 0 && jumps(row[i], row[i - 1])) || (y > 0 && jumps(row[i], above[i]))) {
          colour = mixed(colour, colours::kInk, 0.45);
        }
        image.at<Colour>(y, x) = colour;
      }
      std::swap(row, above);
    }
    return image;
  }

 private:
  static constexpr double kGap = 0.4;  // see VoxelRays::Config

  bool jumps(float a, float b) const {
    if (!std::isfinite(a) || !std::isfinite(b)) return std::isfinite(a) != std::isfinite(b);
    return std::abs(a - b) > 4 * map_.resolution() + 0.03 * static_cast<double>(std::min(a, b));
  }

  Colour look(const Eigen::Vector3d& direction, double& depth) const {
    const RayResult ray = rays_.walk(eye_, direction);
    Colour colour = kSky;
    if (ray.surface) {
      depth = ray.surface->t;
      colour = surface_colour(*ray.surface);
    }
    if (const auto mark = floor_colour(direction, depth)) colour = *mark;
    if (const auto figure = boxes_.meet(eye_, direction); figure && figure->t < depth) {
      depth = figure->t;
      colour = figure->colour;
    }
    for (int i = ray.veil_count - 1; i >= 0; --i) {
      const VoxelFace& veil = ray.veils[static_cast<std::size_t>(i)];
      if (veil.t < depth) colour = mixed(colour, mixed({0, 0, 0}, kVeil, brightness(veil)), kVeilOpacity);
    }
    return colour;
  }

  Colour surface_colour(const VoxelFace& face) const {
    const double z = map_.centre(face.voxel).z();
    const double share = (z - config_.colour_lowest) / (config_.colour_highest - config_.colour_lowest);
    const bool is_floor = std::abs(z - config_.floor_height) < kFloorBand;
    const Colour colour = is_floor ? kFloor : ramp_colour(Ramp::kViridis, share);
    // Neighbouring voxels differ a little, so that one sees their size.
    const double checker = (face.voxel.sum() & 1) != 0 ? 0.0 : 0.035;
    return mixed({0, 0, 0}, colour, brightness(face) - checker);
  }

  /// Marks on the floor, and a grid of metres where nothing is known of it.
  std::optional<Colour> floor_colour(const Eigen::Vector3d& direction, double depth) const {
    const double res = map_.resolution();
    const double t = (config_.floor_height + res - eye_.z()) / direction.z();
    if (!(t > 0) || t > depth + 2.5 * res) return std::nullopt;
    const Eigen::Vector2d at = (eye_ + t * direction).head<2>();
    if (const auto mark = marks_.at(at)) return mark;
    if (depth < kInfinity || t > 40) return std::nullopt;
    const double line = 0.0015 * t;  // as wide as two pixels or so
    const auto near_metre = [&](double v) { return std::abs(v - std::round(v)) < line; };
    if (near_metre(at.x()) || near_metre(at.y())) return kGridLine;
    return std::nullopt;
  }

  const nav::VoxelMap& map_;
  const MapViewConfig& config_;
  Eigen::Vector3d eye_;
  Camera camera_;
  VoxelRays rays_;
  FigureBoxes boxes_;
  FloorMarks marks_;
};

/// The range of coordinates along each axis that holds all but the outermost few occupied voxels.
Eigen::AlignedBox3d extent_of_occupied(const nav::VoxelMap& map, const MapViewConfig& config) {
  std::array<std::vector<std::size_t>, 3> counts;
  for (int a = 0; a < 3; ++a)
    counts[static_cast<std::size_t>(a)].assign(static_cast<std::size_t>(map.size()[a]), 0);
  std::size_t all = 0;
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    if (map.summary(b).occupied == 0) continue;
    const nav::VoxelMap::Index corner = nav::VoxelMap::kBrickEdge * map.brick_at(b);
    const auto values = map.values(b);
    for (int i = 0; i < nav::VoxelMap::kBrickVoxels; ++i) {
      const nav::VoxelOfBrick in = nav::voxel_of_brick(i);
      const nav::VoxelMap::Index voxel = corner + nav::VoxelMap::Index(in.x, in.y, in.z);
      const Eigen::Vector3d at = map.centre(voxel);
      if (nav::voxel_of(values[static_cast<std::size_t>(i)]) != nav::Voxel::kOccupied) continue;
      if ((at.array() < config.lowest.array()).any() || (at.array() > config.highest.array()).any()) continue;
      for (int a = 0; a < 3; ++a) ++counts[static_cast<std::size_t>(a)][static_cast<std::size_t>(voxel[a])];
      ++all;
    }
  }
  if (all == 0) return {map.lowest(), map.highest()};
  const std::size_t few = all / 400;
  Eigen::AlignedBox3d box;
  Eigen::Vector3d lowest, highest;
  for (int a = 0; a < 3; ++a) {
    const auto& count = counts[static_cast<std::size_t>(a)];
    std::size_t low = 0, high = count.size() - 1;
    for (std::size_t sum = count[low]; sum <= few && low < high; sum += count[++low]) {
    }
    for (std::size_t sum = count[high]; sum <= few && high > low; sum += count[--high]) {
    }
    lowest[a] = map.lowest()[a] + static_cast<double>(low) * map.resolution();
    highest[a] = map.lowest()[a] + static_cast<double>(high + 1) * map.resolution();
  }
  return {lowest, highest};
}

void extend_by(const MapFigures& figures, double floor_height, Eigen::AlignedBox3d& box) {
  const double ground = std::isfinite(floor_height) ? floor_height : 0;
  const auto extend = [&](const Eigen::Vector2d& at, double height) {
    if (!at.allFinite()) return;
    box.extend(Eigen::Vector3d(at.x(), at.y(), ground));
    box.extend(Eigen::Vector3d(at.x(), at.y(), ground + height));
  };
  if (figures.robot) extend(figures.robot->position(), 1.6);
  if (figures.goal) extend(*figures.goal, 0.9);
  for (const Eigen::Vector2d& p : figures.path) extend(p, 0);
  for (const FootPrint& foot : figures.feet) extend(foot.pose.position(), 0);
}

}  // namespace

cv::Mat map_view(const nav::VoxelMap& map, const Lookout& from, const MapViewConfig& config,
                 const MapFigures& figures) {
  cv::Mat image = Painter(map, from, config, figures).paint();
  std::vector<Key> keys;
  for (const double share : {1.0, 0.5, 0.0}) {
    const double z = config.colour_lowest + share * (config.colour_highest - config.colour_lowest);
    keys.push_back({ramp_colour(Ramp::kViridis, share), height_label(z)});
  }
  if (std::isfinite(config.floor_height)) keys.push_back({kFloor, "floor"});
  if (config.show_unseen) keys.push_back({mixed(kSky, kVeil, 0.5), "unseen"});
  const cv::Size room = size_of(keys);
  const int below = config.title.empty() ? 6 : 32;
  draw_plate(image, {4, 4, 16 + std::max(room.width, text_width(config.title, 12)), below + room.height + 2});
  draw_text(image, config.title, {12, 24}, colours::kInk, 12);
  draw_keys(image, {12, below}, keys, colours::kInk);
  return image;
}

Lookout bird_view(const nav::VoxelMap& map, const MapViewConfig& config, double azimuth, double elevation,
                  const MapFigures& figures) {
  Eigen::AlignedBox3d box = extent_of_occupied(map, config);
  extend_by(figures, config.floor_height, box);
  const Eigen::Vector3d towards(std::cos(azimuth) * std::cos(elevation),
                                std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
  const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(towards).normalized();
  const Eigen::Vector3d up = towards.cross(right);
  Lookout from;
  const double across = std::tan(from.field / 2), upward = across * config.height / config.width;
  double distance = 0.5;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)) - box.center();
    const double needed = std::max(std::abs(corner.dot(right)) / across, std::abs(corner.dot(up)) / upward);
    distance = std::max(distance, 1.04 * needed + corner.dot(towards));
  }
  from.target = box.center();
  from.eye = from.target + distance * towards;
  return from;
}

}  // namespace headway::app
