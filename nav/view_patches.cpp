#include "nav/view_patches.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

constexpr double kSameSurface = 6;  // sigmas about the median: noise, and what the slope is off
constexpr double kOnPlane = 4;      // sigmas that a pixel may be off the square's plane
constexpr double kMisfit = 2;       // the residuals' root mean square over sigma
constexpr double kLeastFilled = 0.6;

/// One measured pixel, seen from the middle of its square.
struct Pixel {
  double du, dv;  ///< [px]
  double w;       ///< inverse depth [1/m]
  double sigma;   ///< of it
};

/// A square of pixels, and what it takes to look into it.
class Square {
 public:
  explicit Square(int edge) : edge_(edge), middle_((edge - 1) / 2.0) {}

  /// Takes in the known pixels from (u0, v0) on.
  void gather(const vision::RangeView& view, int u0, int v0, double least_weight) {
    pixels_.clear();
    grid_.assign(index(0, edge_), 0);
    for (int v = 0; v < edge_; ++v) {
      for (int u = 0; u < edge_; ++u) {
        const std::size_t i = view.index(u0 + u, v0 + v);
        const double z = static_cast<double>(view.depth[i]);
        if (!(z >= view.near && z <= view.far)) continue;
        if (!view.weight.empty() && !(static_cast<double>(view.weight[i]) >= least_weight)) continue;
        grid_[index(u, v)] = 1 / z;
        pixels_.push_back(
            {u - middle_, v - middle_, 1 / z, static_cast<double>(view.sigma_depth[i]) / (z * z)});
      }
    }
  }

  /// Leaves the pixels near the middle one of all, once the slope across the square is taken off.
  void leave_one_surface() {
    const double along_u = slope(1, 0), along_v = slope(0, 1);
    const auto level = [&](const Pixel& p) { return p.w - along_u * p.du - along_v * p.dv; };
    sorted_.clear();
    for (const Pixel& p : pixels_) sorted_.push_back(level(p));
    const double median = middle_of_sorted();
    std::erase_if(pixels_,
                  [&](const Pixel& p) { return std::abs(level(p) - median) > kSameSurface * p.sigma; });
  }

  const std::vector<Pixel>& pixels() const { return pixels_; }

 private:
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(edge_) + static_cast<std::size_t>(u);
  }

  /// Of inverse depth per pixel, along one axis: the median over pairs half a square apart.
  double slope(int du, int dv) {
    const int apart = (edge_ + 1) / 2;
    sorted_.clear();
    for (int v = 0; v + dv * apart < edge_; ++v) {
      for (int u = 0; u + du * apart < edge_; ++u) {
        const double one = grid_[index(u, v)], two = grid_[index(u + du * apart, v + dv * apart)];
        if (one > 0 && two > 0) sorted_.push_back((two - one) / apart);
      }
    }
    return sorted_.empty() ? 0 : middle_of_sorted();
  }

  double middle_of_sorted() {
    const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
    std::nth_element(sorted_.begin(), middle, sorted_.end());
    return *middle;
  }

  int edge_;
  double middle_;
  std::vector<Pixel> pixels_;
  std::vector<double> grid_;  ///< inverse depths; 0 where nothing is known
  std::vector<double> sorted_;
};

/// Inverse depth in the middle of a square and its standard deviation, by least squares; nothing when the
/// pixels do not lie on one plane. Planes are linear in inverse depth.
std::optional<Eigen::Vector2d> fit(const std::vector<Pixel>& pixels, const PatchConfig& config) {
  double u = 0, v = 0, uu = 0, uv = 0, vv = 0, w = 0, uw = 0, vw = 0, variance = 0;
  for (const Pixel& p : pixels) {
    u += p.du;
    v += p.dv;
    uu += p.du * p.du;
    uv += p.du * p.dv;
    vv += p.dv * p.dv;
    w += p.w;
    uw += p.du * p.w;
    vw += p.dv * p.w;
    variance += p.sigma * p.sigma;
  }
  const double count = static_cast<double>(pixels.size());
  Eigen::Matrix3d squares;
  squares << count, u, v, u, uu, uv, v, uv, vv;
  const Eigen::Matrix3d inverse = squares.inverse();
  const Eigen::Vector3d plane = inverse * Eigen::Vector3d(w, uw, vw);
  variance /= count;
  const double most = kOnPlane * kOnPlane * variance;
  double residuals = 0, largest = 0;
  for (const Pixel& p : pixels) {
    const double r = p.w - plane[0] - plane[1] * p.du - plane[2] * p.dv;
    residuals += r * r;
    largest = std::max(largest, r * r);
  }
  if (!(largest <= most && residuals <= kMisfit * kMisfit * variance * count && plane[0] > 0))
    return std::nullopt;
  // The middle of a square that is not full is less sure than the mean.
  const double spread = inverse(0, 0) * count;
  const double independent =
      std::clamp(count / (config.correlation * config.correlation), 1.0, config.most_independent);
  return Eigen::Vector2d(plane[0], std::sqrt(variance * spread / independent));
}

}  // namespace

void PatchConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("patches: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("most", most, 100, 100000);
  check("least_weight", least_weight, 0, 1);
  check("correlation", correlation, 1, 100);
  check("most_independent", most_independent, 1, 1000);
}

void view_patches(const vision::RangeView& view, const PatchConfig& config, std::vector<Patch>& out) {
  out.clear();
  const vision::PinholeCamera& c = view.camera;
  const double pixels = static_cast<double>(c.width) * static_cast<double>(c.height);
  const int edge = std::max(3, static_cast<int>(std::ceil(std::sqrt(pixels / config.most))));
  const auto least = static_cast<std::size_t>(std::ceil(kLeastFilled * edge * edge));
  Square square(edge);
  for (int v = 0; v + edge <= c.height; v += edge) {
    for (int u = 0; u + edge <= c.width; u += edge) {
      square.gather(view, u, v, config.least_weight);
      if (square.pixels().size() < least) continue;
      auto found = fit(square.pixels(), config);
      if (!found) {
        square.leave_one_surface();
        if (square.pixels().size() < least) continue;
        found = fit(square.pixels(), config);
      }
      if (!found) continue;
      const double z = 1 / found->x();
      if (z > view.far) continue;
      const double middle = (edge - 1) / 2.0;
      const double sigma = found->y() * z;
      // A matcher draws disparities towards whole pixels, over all of a surface that shares them.
      out.push_back({c.point(u + middle, v + middle, z), sigma, view.weight.empty() ? 0 : sigma});
    }
  }
}

}  // namespace headway::nav
