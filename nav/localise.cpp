#include "nav/localise.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "hal/error.h"

namespace headway::nav {
namespace {

constexpr double kGrazing = 0.2;     // cosine; flatter looks at a surface say little of where it is
constexpr double kSoft = 3;          // sigmas at which a residual has lost most of its weight
constexpr double kStill = 1e-5;      // a step so small ends the search [m, rad]
constexpr double kNormal = 0.6745;   // median of a standard normal's absolute value
constexpr double kFeigned = 0.5;     // times the variance of normals, by which that may be off itself
constexpr double kNarrowing = 0.25;  // of the believed covariance with each step

/// A patch and the plane that it meets.
struct Match {
  std::size_t plane;
  double residual;          ///< along the plane's normal [m]
  Eigen::Vector3d row;      ///< its change with x, y [1], yaw [m]
  double arm2;              ///< squared distance from the robot [m^2]
  double tilt2;             ///< variance of the plane's normal within the floor plane [rad^2]
  Eigen::Vector3d feigned;  ///< what the normal's errors, being in both, add to residual * row on average
  double doubt;             ///< of the place of its surroundings [m^2]
  double variance;          ///< of the residual [m^2]
};

/// The normal equations of a step.
struct Equations {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double weight = 0, arm2 = 0, tilt2 = 0, doubt = 0;  ///< sums

  void add(const Match& m, double w) {
    matrix += w * m.row * m.row.transpose();
    right -= w * (m.residual * m.row - m.feigned);
    weight += w;
    arm2 += w * m.arm2;
    tilt2 += w * m.tilt2;
    doubt += w * m.doubt;
  }
};

/// A step along the determined directions: the eigenvectors that surfaces face. Yaw is measured in metres at
/// the patches' mean distance, so that it can be compared with x and y.
struct Step {
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();  ///< columns b of the components b . (x, y, yaw)
  Eigen::Vector3d variances = Eigen::Vector3d::Zero();   ///< of the components
  int determined = 0;                                    ///< columns in use
  double doubt = 0, arm2 = 0;                            ///< means over the patches [m^2]
};

Step solve(const Equations& e, double least_facing) {
  Step step;
  if (!(e.weight > 0) || !(e.arm2 > 0)) return step;
  step.doubt = e.doubt / e.weight;
  step.arm2 = e.arm2 / e.weight;
  const Eigen::Vector3d unit(1, 1, 1 / std::sqrt(step.arm2));
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(unit.asDiagonal() * e.matrix * unit.asDiagonal());
  for (int i = 0; i < 3; ++i) {
    // Errors of normals feign surfaces that face where none do.
    const double strength = axes.eigenvalues()[i] - e.tilt2;
    if (!(strength >= least_facing * e.weight + kFeigned * e.tilt2)) continue;
    const Eigen::Vector3d along = unit.asDiagonal() * axes.eigenvectors().col(i);
    step.change += along * (along.dot(e.right) / strength);
    step.directions.col(step.determined) = unit.cwiseInverse().asDiagonal() * axes.eigenvectors().col(i);
    step.variances[step.determined++] = 1 / strength;
  }
  return step;
}

/// The inverse covariance of a step whose residuals are `misfit` times their sigma, with what all patches err
/// alike.
Eigen::Matrix3d information(const Step& step, double misfit, const LocaliseConfig& config) {
  const int n = step.determined;
  const Eigen::MatrixXd directions = step.directions.leftCols(n);
  const double shift = config.shift_sigma * config.shift_sigma + step.doubt;
  const double turn = config.turn_sigma * config.turn_sigma + step.doubt / step.arm2;
  const Eigen::Vector3d alike(shift, shift, turn);
  const Eigen::MatrixXd covariance = directions.transpose() * alike.asDiagonal() * directions +
                                     Eigen::MatrixXd((misfit * misfit * step.variances.head(n)).asDiagonal());
  return directions * covariance.inverse() * directions.transpose();
}

/// How unlikely a change is: squared, over the covariance of the believed pose and its own, where it has one.
double chi2(const Eigen::Vector3d& change, const Eigen::Matrix3d& information,
            const Eigen::Matrix3d& believed) {
  const Eigen::Vector3d weighed = information * change;
  const Eigen::Matrix3d spread = information + information * believed * information;
  return weighed.dot(spread.completeOrthogonalDecomposition().solve(weighed));
}

Eigen::Isometry3d moved(const Eigen::Vector2d& about, const Eigen::Vector3d& change) {
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.linear() = Eigen::AngleAxisd(change.z(), Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d centre(about.x(), about.y(), 0);
  t.translation() = centre + Eigen::Vector3d(change.x(), change.y(), 0) - t.linear() * centre;
  return t;
}

/// Geman and McClure's weight of a residual of so many (robust) sigma.
double robust(double sigmas) {
  const double q = 1 + sigmas * sigmas / (kSoft * kSoft);
  return 1 / (q * q);
}

}  // namespace

const char* name(Aligned aligned) {
  switch (aligned) {
    case Aligned::kWhole:
      return "whole";
    case Aligned::kPartly:
      return "partly";
    case Aligned::kFewPatches:
      return "few patches";
    case Aligned::kUndetermined:
      return "undetermined";
    case Aligned::kMisfit:
      return "misfit";
    case Aligned::kTooFar:
      return "too far";
  }
  return "?";
}

void LocaliseConfig::validate() const {
  const auto check = [](const char* name, double value, double lowest, double highest) {
    if (value >= lowest && value <= highest) return;
    throw InputError("localise: " + std::string(name) + ": " + std::to_string(value) + ", expected " +
                     std::to_string(lowest) + " to " + std::to_string(highest));
  };
  check("fewest_patches", fewest_patches, 10, 100000);
  check("least_known", least_known, 0, 1);
  check("least_share", least_share, 0, 1);
  check("gate", gate, 1, 20);
  check("largest_misfit", largest_misfit, 1, 100);
  check("largest_chi2", largest_chi2, 1, 1000);
  check("steepest", steepest, 0.05, 1);
  check("least_facing", least_facing, 0, 1);
  check("place_sigma", place_sigma, 0, 0.1);
  check("shift_sigma", shift_sigma, 1e-4, 0.1);
  check("turn_sigma", turn_sigma, 1e-4, 0.1);
  check("iterations", iterations, 1, 100);
}

Eigen::Isometry3d Alignment::correction() const { return moved(about, change); }

struct Localiser::Scratch {
  struct Plane {
    std::optional<SurfacePlane> surface;
    double patches = 0;  ///< matched with it
  };
  std::unordered_map<std::uint64_t, std::size_t> plane_of;  ///< by voxel
  std::vector<Plane> planes;
  std::vector<Match> matches;
  std::vector<double> sizes;

  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t plane_at(const VoxelMap& map, const SurfacePoints& surfaces, const VoxelMap::Index& voxel,
                       double steepest);
  void match(const VoxelMap& map, const SurfacePoints& surfaces, std::span<const Patch> patches,
             const Eigen::Isometry3d& map_from_camera, const Eigen::Vector2d& about,
             const LocaliseConfig& config);
  void widen(const Eigen::Matrix3d& believed);
  double spread();
  Equations equations(double spread, double gate) const;
  std::size_t agreeing(double gate) const;
};

/// The plane of a voxel's block, or around it where its block has none. Looked up once for each view; those
/// that are not steep are none.
std::size_t Localiser::Scratch::plane_at(const VoxelMap& map, const SurfacePoints& surfaces,
                                         const VoxelMap::Index& voxel, double steepest) {
  constexpr std::uint64_t kOfBlock = std::uint64_t{1} << 63;
  const VoxelMap::Index n = map.size();
  const auto key = [&](const VoxelMap::Index& i) {
    return (static_cast<std::uint64_t>(i.z()) * static_cast<std::uint64_t>(n.y()) +
            static_cast<std::uint64_t>(i.y())) *
               static_cast<std::uint64_t>(n.x()) +
           static_cast<std::uint64_t>(i.x());
  };
  const auto look_up = [&](std::uint64_t where, const auto& plane) {
    const auto [place, fresh] = plane_of.try_emplace(where, planes.size());
    if (fresh) planes.push_back({plane()});
    return place->second;
  };
  const VoxelMap::Index block = SurfacePoints::block_of(voxel + map.first_key()),
                        first = SurfacePoints::block_of(map.first_key());
  const std::size_t of_block =
      look_up(kOfBlock | key(block - first), [&] { return surfaces.block_plane(block, map); });
  const std::size_t found =
      planes[of_block].surface ? of_block : look_up(key(voxel), [&] { return surfaces.plane(voxel, map); });
  const auto& surface = planes[found].surface;
  return surface && std::abs(surface->normal.z()) <= steepest ? found : kNone;
}

void Localiser::Scratch::match(const VoxelMap& map, const SurfacePoints& surfaces,
                               std::span<const Patch> patches, const Eigen::Isometry3d& map_from_camera,
                               const Eigen::Vector2d& about, const LocaliseConfig& config) {
  matches.clear();
  for (Plane& plane : planes) plane.patches = 0;
  for (const Patch& patch : patches) {
    const Eigen::Vector3d ray = map_from_camera.linear() * patch.point;
    const Eigen::Vector3d point = map_from_camera.translation() + ray;
    const VoxelMap::Index voxel = map.index(point);
    if (!map.contains(voxel)) continue;
    const std::size_t index = plane_at(map, surfaces, voxel, config.steepest);
    if (index == kNone) continue;
    const SurfacePlane& plane = *planes[index].surface;
    const double along = plane.normal.dot(ray);
    if (std::abs(along) < kGrazing * ray.norm()) continue;
    if (plane.sided && along > 0) continue;  // the other face of a thin wall
    const Eigen::Vector3d off = point - plane.point;
    const double residual = plane.normal.dot(off);
    const Eigen::Vector3d arm(-(point.y() - about.y()), point.x() - about.x(), 0);
    const Eigen::Vector3d feigned = plane.tilt * off;  // covariance of the normal and the residual
    ++planes[index].patches;
    matches.push_back({index,
                       residual,
                       {plane.normal.x(), plane.normal.y(), plane.normal.dot(arm)},
                       arm.squaredNorm(),
                       plane.tilt.topLeftCorner<2, 2>().trace(),
                       {feigned.x(), feigned.y(), feigned.dot(arm)},
                       plane.doubt,
                       patch.sigma * patch.sigma * along * along + off.dot(feigned)});
  }
  // Patches on one plane share the error of its place: their mean has it once, so each has it as often as
  // they are.
  for (Match& m : matches) {
    const Plane& plane = planes[m.plane];
    const double place = plane.surface->sigma * plane.surface->sigma +
                         config.place_sigma * config.place_sigma + plane.surface->doubt;
    m.variance += plane.patches * place;
  }
}

/// While the pose is not found, residuals are as large as the believed one may be off.
void Localiser::Scratch::widen(const Eigen::Matrix3d& believed) {
  for (Match& m : matches) m.variance += m.row.dot(believed * m.row);
}

/// By how much residuals are larger than their sigma, by the median; at least 1.
double Localiser::Scratch::spread() {
  sizes.clear();
  for (const Match& m : matches) sizes.push_back(std::abs(m.residual) / std::sqrt(m.variance));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(1.0, *middle / kNormal);
}

Equations Localiser::Scratch::equations(double spread, double gate) const {
  Equations e;
  for (const Match& m : matches) {
    const double sigmas = std::abs(m.residual) / (spread * std::sqrt(m.variance));
    if (sigmas <= gate) e.add(m, robust(sigmas) / m.variance);
  }
  return e;
}

std::size_t Localiser::Scratch::agreeing(double gate) const {
  return static_cast<std::size_t>(std::count_if(matches.begin(), matches.end(), [&](const Match& m) {
    return m.residual * m.residual <= gate * gate * m.variance;
  }));
}

Localiser::Localiser(const LocaliseConfig& config) : config_(config), scratch_(std::make_unique<Scratch>()) {
  config_.validate();
}
Localiser::~Localiser() = default;
Localiser::Localiser(Localiser&&) noexcept = default;
Localiser& Localiser::operator=(Localiser&&) noexcept = default;

Alignment Localiser::align(const VoxelMap& map, const SurfacePoints& surfaces, std::span<const Patch> patches,
                           const Eigen::Isometry3d& map_from_camera, const Eigen::Vector2d& about,
                           const Eigen::Matrix3d& believed) {
  Scratch& s = *scratch_;
  s.plane_of.clear();
  s.planes.clear();
  Alignment out;
  out.about = about;
  out.patches = patches.size();
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  Eigen::Matrix3d doubt = believed;
  Step step;
  for (int i = 0; i < config_.iterations; ++i) {
    s.match(map, surfaces, patches, moved(about, change) * map_from_camera, about, config_);
    const auto met = static_cast<double>(s.matches.size());
    if (met < config_.fewest_patches || met < config_.least_known * static_cast<double>(patches.size()))
      return out;
    out.matched = s.agreeing(config_.gate);
    s.widen(doubt);
    out.misfit = s.spread();
    step = solve(s.equations(out.misfit, config_.gate), config_.least_facing);
    change += step.change;
    doubt *= kNarrowing;
    if (step.change.norm() < kStill) break;
  }
  out.determined = step.determined;
  const Eigen::Matrix3d known = information(step, out.misfit, config_);
  if (step.determined == 0)
    out.aligned = Aligned::kUndetermined;
  else if (out.misfit > config_.largest_misfit ||
           static_cast<double>(out.matched) < config_.least_share * static_cast<double>(s.matches.size()))
    out.aligned = Aligned::kMisfit;
  else if (chi2(change, known, believed) > config_.largest_chi2)
    out.aligned = Aligned::kTooFar;
  else
    out.aligned = step.determined == 3 ? Aligned::kWhole : Aligned::kPartly;
  if (!out) return out;
  out.change = change;
  out.information = known;
  return out;
}

}  // namespace headway::nav
