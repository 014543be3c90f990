#include "nav/surface_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace headway::nav {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr double kEnough = 1 / (0.001 * 0.001);  // weight at which a voxel's mean comes to rest [1/m^2]
constexpr double kMostOfOne = kEnough / 16;      // no single point decides
constexpr LogOdds kSurelyEmpty = log_odds::kLowest / 2;
constexpr float kFewest = 6;   // points of a plane
constexpr double kFlat = 0.1;  // standard deviation across a plane beyond noise, in voxels
constexpr double kWide = 0.3;  // and along it
constexpr float kFewestOfBlock = 12;
constexpr double kWideOfBlock = 0.12;        // in edges of the block
constexpr double kNoisy = 1.5;               // noise may be so much more than its variance
constexpr double kMostTilt = 0.1;            // of a normal that says anything [rad]
constexpr double kNeighbours = 9;            // voxels on a plane that share the points of one
constexpr double kReach = 3;                 // sigmas off a plane that its points lie within
constexpr std::array kBeside = {1.25, 2.0};  // voxels off a plane; a side is empty where both are
constexpr double kOneSided = 0.2;            // of the mean direction of looks, along the normal, at least
constexpr std::size_t kFirstSize = std::size_t{1} << 14;
constexpr int kKeyBits = 21;  // of each coordinate
constexpr int kKeyMiddle = 1 << (kKeyBits - 1);

constexpr int kItselfAndFaces[7][3] = {{0, 0, 0},  {1, 0, 0}, {-1, 0, 0}, {0, 1, 0},
                                       {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

std::size_t scattered(std::uint64_t key) {
  // Fibonacci hashing (Knuth 6.4) after a fold, for neighbours differ in few bits.
  key ^= key >> 29;
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20);
}

/// Whether points in a voxel may have such sums.
bool possible(const SurfaceVoxel& v, double resolution) {
  const float xx = v.second[0], yy = v.second[3], zz = v.second[5];
  const float reach = static_cast<float>(resolution) * v.weight;  // with room for rounding
  const auto within = [](float value, float most) { return std::isfinite(value) && std::abs(value) <= most; };
  return v.key != 0 && v.key >> 3 * kKeyBits == 0 && v.weight > 0 && std::isfinite(v.weight) &&
         v.count >= 1 && std::isfinite(v.count) && v.doubt >= 0 && std::isfinite(v.doubt) &&
         std::ranges::all_of(v.first, [&](float f) { return within(f, reach); }) && xx >= 0 && yy >= 0 &&
         zz >= 0 &&
         std::ranges::all_of(v.second,
                             [&](float f) { return within(f, reach * static_cast<float>(resolution)); }) &&
         std::ranges::all_of(v.rays, [&](float f) { return within(f, 1.01F * v.weight); });
}

}  // namespace

/// Sums over the points of several voxels, each seen from the middle of the first.
struct SurfacePoints::Sums {
  double weight = 0, doubt = 0;
  float count = 0;
  Vector3d first = Vector3d::Zero(), rays = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();

  void add(const SurfaceVoxel& voxel, const Vector3d& middle) {
    const auto w = static_cast<double>(voxel.weight);
    const Vector3d s = Eigen::Map<const Eigen::Vector3f>(voxel.first.data()).cast<double>();
    const auto c = [&](std::size_t i) { return static_cast<double>(voxel.second[i]); };
    Matrix3d spread;
    spread << c(0), c(1), c(2), c(1), c(3), c(4), c(2), c(4), c(5);
    weight += w;
    doubt += w * static_cast<double>(voxel.doubt);
    count += voxel.count;
    first += s + w * middle;
    rays += Eigen::Map<const Eigen::Vector3f>(voxel.rays.data()).cast<double>();
    second += spread + s * middle.transpose() + middle * s.transpose() + w * middle * middle.transpose();
  }

  /// Of one point, by noise and by what all of them are off [m^2].
  double variance() const { return (static_cast<double>(count) + doubt) / weight; }

  /// The plane that the points lie on, as far as their noise and what all of them are off allow. `flat`
  /// and `wide`: standard deviations across it beyond that, at most, and along it, at least [m].
  std::optional<SurfacePlane> plane(const Vector3d& origin, double flat, double wide) const {
    const Vector3d mean = first / weight;
    Eigen::SelfAdjointEigenSolver<Matrix3d> axes;
    axes.computeDirect(second / weight - mean * mean.transpose());
    const Vector3d spread = axes.eigenvalues();
    const auto points = static_cast<double>(count);
    const double noise = points / weight, off = doubt / weight;  // variances of one point
    if (spread[0] > flat * flat + kNoisy * noise + off || spread[1] < wide * wide + noise)
      return std::nullopt;
    // Of an eigenvector, by perturbation of the first order.
    const double across = std::max(noise, spread[0]);
    const auto tilt_variance = [&](int axis) {
      const double gap = std::max(spread[axis] - across, 1e-12);
      return across * spread[axis] / (points * gap * gap);
    };
    if (tilt_variance(1) > kMostTilt * kMostTilt) return std::nullopt;
    const Matrix3d tilt = axes.eigenvectors().rightCols<2>() *
                          Eigen::Vector2d(tilt_variance(1), tilt_variance(2)).asDiagonal() *
                          axes.eigenvectors().rightCols<2>().transpose();
    // Less where both faces of a thin thing were seen alike, or at a graze; maps of old files hold none.
    Vector3d normal = axes.eigenvectors().col(0);
    const double towards = -normal.dot(rays) / weight;
    const bool sided = std::abs(towards) >= kOneSided;
    if (towards < 0) normal = -normal;
    return SurfacePlane{.point = origin + mean,
                        .normal = normal,
                        .sigma = 1 / std::sqrt(weight),
                        .tilt = tilt,
                        .doubt = off,
                        .sided = sided};
  }
};

SurfacePoints::SurfacePoints(double resolution, std::size_t most_voxels)
    : resolution_(resolution), most_(std::bit_ceil(most_voxels)), cells_(std::min(kFirstSize, 2 * most_)) {}

void SurfacePoints::Cell::add(const Eigen::Vector3f& d, float w, const Eigen::Vector3f& ray) {
  weight += w;
  count += 1;
  const Eigen::Vector3f v = w * d;
  for (int i = 0; i < 3; ++i) {
    first[static_cast<std::size_t>(i)] += v[i];
    rays[static_cast<std::size_t>(i)] += w * ray[i];
  }
  second[0] += v.x() * d.x();
  second[1] += v.x() * d.y();
  second[2] += v.x() * d.z();
  second[3] += v.y() * d.y();
  second[4] += v.y() * d.z();
  second[5] += v.z() * d.z();
}

/// Whether a look of this doubt [m^2] tells anything new of a voxel. Noise spreads the points of a surface
/// over its neighbours: what holds for one holds for all. Forgets what the look replaces.
bool SurfacePoints::admit(const VoxelMap::Index& absolute, float doubt) {
  constexpr float kSurer = 4;
  bool admitted = true;
  for (const auto& offset : kItselfAndFaces) {
    Cell* cell = find(key_of(absolute + VoxelMap::Index(offset[0], offset[1], offset[2])));
    if (cell == nullptr || cell->weight <= 0) continue;
    if (kSurer * doubt < cell->doubt)
      cell->forget();
    else if (cell->weight >= static_cast<float>(kEnough) || doubt > kSurer * (cell->doubt + 1 / cell->weight))
      admitted = false;
  }
  return admitted;
}

std::uint64_t SurfacePoints::key_of(const VoxelMap::Index& absolute) {
  const auto bits = [](int i) { return static_cast<std::uint64_t>(std::int64_t{i} + kKeyMiddle); };
  return bits(absolute.x()) | bits(absolute.y()) << kKeyBits | bits(absolute.z()) << 2 * kKeyBits;
}

/// Where a voxel's cell is, or the free place where it would be.
std::size_t SurfacePoints::place(std::uint64_t key) const {
  const std::size_t mask = cells_.size() - 1;
  std::size_t i = scattered(key) & mask;
  while (cells_[i].key != key && cells_[i].key != 0) i = (i + 1) & mask;
  return i;
}

/// The cell of a voxel, new if need be; null when there is no room.
SurfacePoints::Cell* SurfacePoints::make(std::uint64_t key, const VoxelMap& map) {
  if (Cell* known = find(key)) return known;
  if (used_ >= most_) rebuild(cells_.size(), &map);
  if (used_ >= most_) return nullptr;
  if (2 * (used_ + 1) > cells_.size()) rebuild(2 * cells_.size(), nullptr);
  ++used_;
  Cell& cell = cells_[place(key)];
  cell.key = key;
  return &cell;
}

/// Moves all cells into a table of `size`; with a map, only those whose voxels it has seen.
void SurfacePoints::rebuild(std::size_t size, const VoxelMap* keep_known_to) {
  std::vector<Cell> old(size);
  old.swap(cells_);
  used_ = 0;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << kKeyBits) - 1;
  const auto coordinate = [&](std::uint64_t key, int at) {
    return static_cast<int>(key >> at * kKeyBits & kMask) - kKeyMiddle;
  };
  for (const Cell& cell : old) {
    if (cell.key == 0 || cell.weight <= 0) continue;
    if (keep_known_to != nullptr) {
      const VoxelMap::Index absolute(coordinate(cell.key, 0), coordinate(cell.key, 1),
                                     coordinate(cell.key, 2));
      if (keep_known_to->at(absolute - keep_known_to->first_key()) == Voxel::kUnseen) continue;
    }
    cells_[place(cell.key)] = cell;
    ++used_;
  }
}

std::vector<SurfaceVoxel> SurfacePoints::saved() const {
  std::vector<SurfaceVoxel> all;
  for (const Cell& cell : cells_)
    if (cell.key != 0 && cell.weight > 0) all.push_back(cell);
  std::ranges::sort(all, {}, &SurfaceVoxel::key);
  return all;
}

bool SurfacePoints::restore(const SurfaceVoxel& voxel) {
  if (!possible(voxel, resolution_) || find(voxel.key) != nullptr || used_ >= most_) return false;
  if (2 * (used_ + 1) > cells_.size()) rebuild(2 * cells_.size(), nullptr);
  ++used_;
  static_cast<SurfaceVoxel&>(cells_[place(voxel.key)]) = voxel;
  return true;
}

void SurfacePoints::add(std::span<const Patch> patches, const Eigen::Isometry3d& map_from_camera,
                        const VoxelMap& map, const PoseVariance& pose) {
  for (const Patch& patch : patches) {
    const Eigen::Vector3d ray = map_from_camera.linear() * patch.point,
                          point = map_from_camera.translation() + ray;
    const VoxelMap::Index voxel = map.index(point);
    if (!map.contains(voxel)) continue;
    const VoxelMap::Index absolute = voxel + map.first_key();
    const LogOdds value = map.value(voxel);
    if (value != log_odds::kUnseen && value <= kSurelyEmpty) {
      if (Cell* cell = find(key_of(absolute))) cell->forget();
      continue;
    }
    const double sigma = patch.sigma * patch.point.norm();
    const auto doubt =
        static_cast<float>(pose.shift + (pose.turn + patch.alike * patch.alike) * patch.point.squaredNorm());
    if (!admit(absolute, doubt)) continue;
    Cell* cell = make(key_of(absolute), map);
    if (cell == nullptr) continue;
    if (cell->weight <= 0) cell->doubt = doubt;
    cell->add((point - map.centre(voxel)).cast<float>(),
              static_cast<float>(std::min(1 / (sigma * sigma), kMostOfOne)), ray.normalized().cast<float>());
  }
}

/// Whether both sides are empty: of a thing so thin, noise mixes the points of both faces.
bool SurfacePoints::between_empty(const SurfacePlane& plane, const VoxelMap& map) const {
  const auto empty = [&](double side) {
    return std::ranges::all_of(kBeside, [&](double voxels) {
      return map.at_point(plane.point + side * voxels * resolution_ * plane.normal) == Voxel::kEmpty;
    });
  };
  return empty(1) && empty(-1);
}

/// Over the points in the voxels of a box.
SurfacePoints::Sums SurfacePoints::sums_of(const Box& box) const {
  Sums sums;
  for (int z = 0; z < box.size.z(); ++z)
    for (int y = 0; y < box.size.y(); ++y)
      for (int x = 0; x < box.size.x(); ++x)
        if (const Cell* cell = find(key_of(box.first + VoxelMap::Index(x, y, z)));
            cell != nullptr && cell->count > 0)
          sums.add(*cell, resolution_ * Vector3d(x, y, z));
  return sums;
}

std::optional<SurfacePlane> SurfacePoints::plane(const VoxelMap::Index& voxel, const VoxelMap& map) const {
  const VoxelMap::Index first = voxel - VoxelMap::Index::Ones();
  const Sums sums = sums_of({first + map.first_key(), VoxelMap::Index::Constant(3)});
  if (sums.count < kFewest) return std::nullopt;
  auto plane = sums.plane(map.centre(first), kFlat * resolution_, kWide * resolution_);
  if (!plane || map.at_point(plane->point) != Voxel::kOccupied || between_empty(*plane, map))
    return std::nullopt;
  plane->sigma *= std::sqrt(kNeighbours);
  return plane;
}

/// The box that holds, along the axis that the plane of a block faces, all points of the plane, whose
/// standard deviation is `sigma`, and across it what the block holds.
SurfacePoints::Box SurfacePoints::uncut(const SurfacePlane& plane, double sigma, const Box& block,
                                        const VoxelMap& map) const {
  int axis = 0;
  const Vector3d cosines = plane.normal.cwiseAbs();
  const double along = cosines.maxCoeff(&axis);
  const double slope = (cosines.sum() - along) / along * kBlock * resolution_ / 2;
  const double reach = std::min(kReach * sigma / along, kBlock * resolution_) + slope;
  const auto voxel_at = [&](double offset) {
    return (map.index(plane.point + offset * Vector3d::Unit(axis)) + map.first_key())[axis];
  };
  Box box = block;
  box.first[axis] = voxel_at(-reach);
  box.size[axis] = voxel_at(reach) - box.first[axis] + 1;
  return box;
}

std::optional<SurfacePlane> SurfacePoints::block_plane(const VoxelMap::Index& block,
                                                       const VoxelMap& map) const {
  const Box whole{kBlock * block, VoxelMap::Index::Constant(kBlock)};
  const auto plane_of = [&](const Sums& sums, const Box& box) -> std::optional<SurfacePlane> {
    if (sums.count < kFewestOfBlock) return std::nullopt;
    return sums.plane(map.centre(box.first - map.first_key()), kFlat * resolution_,
                      kWideOfBlock * kBlock * resolution_);
  };
  const Sums sums = sums_of(whole);
  std::optional<SurfacePlane> plane = plane_of(sums, whole);
  if (!plane) return std::nullopt;
  // Where a surface lies beside a face of the block, noise carries some of its points into the next one.
  const Box box = uncut(*plane, std::sqrt(sums.variance()), whole, map);
  if (const auto wider = plane_of(sums_of(box), box)) plane = wider;
  const VoxelMap::Index middle = map.index(plane->point);
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (map.at(middle + VoxelMap::Index(x, y, z)) == Voxel::kOccupied)
          return between_empty(*plane, map) ? std::nullopt : plane;
  return std::nullopt;
}

}  // namespace headway::nav
