#include "operator/seen.h"

#include <algorithm>
#include <cmath>

#include "runtime/recorded_values.h"

namespace headway::remote {

namespace {

std::uint32_t grey(std::uint8_t value) {
  return std::uint32_t{value} << 16 | std::uint32_t{value} << 8 | value;
}

/// In closed form, as vision::resolution(): the larger eigenvalue belongs to a + b P P^T on the plane of the
/// optical axis and the ray.
float largest_sigma(const vision::RangeView& view, const Eigen::Vector3d& p, double sigma_depth) {
  const double s = sigma_depth / p.z(), lateral = p.z() / view.camera.focal * vision::RangeView::kPixelSigma;
  const double across = p.head<2>().squaredNorm(), a = lateral * lateral, b = s * s;
  const double xx = a + b * across, zz = b * p.z() * p.z(), xz2 = b * b * across * p.z() * p.z();
  const double half = (xx + zz) / 2, apart = (xx - zz) / 2;
  return static_cast<float>(std::sqrt(std::max(half + std::sqrt(apart * apart + xz2), a)));
}

SeenBrick brick_of(const nav::VoxelMap& voxels, const nav::BrickKey& key, std::size_t brick) {
  SeenBrick out;
  out.key = key;
  const auto values = voxels.values(brick);
  for (std::size_t place = 0; place < values.size(); ++place) {
    const nav::VoxelOfBrick v = nav::voxel_of_brick(static_cast<int>(place));
    const auto byte = static_cast<std::size_t>(8 * v.z + v.y);
    const auto bit = static_cast<std::uint8_t>(1U << v.x);
    const nav::Voxel is = nav::voxel_of(values[place]);
    if (is == nav::Voxel::kOccupied) out.occupied[byte] |= bit;
    if (is == nav::Voxel::kUnseen) out.unseen[byte] |= bit;
  }
  return out;
}

}  // namespace

void Onlooker::wish(const Wish& wish) {
  picture_ = wish.picture;
  points_ = wish.points;
  voxels_ = wish.voxels;
}

void Onlooker::begin_again() {
  ++world_;
  told_.clear();
  floor_at_ = voxels_at_ = nav::kNever;
}

void Onlooker::see(const runtime::FrameSnapshot& snapshot) {
  ++next_.number;
  next_.exposure = snapshot.stamp.exposure;
  next_.base = snapshot.bus.committed.stance.base();
  next_.map_from_chest = snapshot.map_from_chest;
  next_.map_from_view = snapshot.map_from_view;
  next_.way.clear();
  if (const auto& walk = snapshot.mission.walk()) next_.way = walk->walk.bases;
  copy_feet(snapshot);
  copy_floor(snapshot);
  if (picture_) copy_picture(snapshot);
  if (points_) copy_points(snapshot);
  seen_.publish(next_);
  if (voxels_ && snapshot.stamp.exposure - voxels_at_ >= config_.voxels_every) {
    voxels_at_ = snapshot.stamp.exposure;
    tell_voxels(snapshot.mapper.voxels());
  }
}

void Onlooker::copy_picture(const runtime::FrameSnapshot& snapshot) {
  const vision::RangeView& view = snapshot.view;
  if (snapshot.picture) {
    next_.picture = *snapshot.picture;
    return;
  }
  next_.picture.width = view.camera.width;
  next_.picture.height = view.camera.height;
  next_.picture.pixels.resize(view.depth.size());
  const auto near = static_cast<float>(std::max(view.near, 0.1));
  std::ranges::transform(view.depth, next_.picture.pixels.begin(), [near](float z) {
    return std::isfinite(z) ? static_cast<std::uint8_t>(std::clamp(255 * near / z, 0.0F, 255.0F))
                            : std::uint8_t{0};
  });
}

void Onlooker::copy_points(const runtime::FrameSnapshot& snapshot) {
  const vision::RangeView& view = snapshot.view;
  next_.points.clear();
  const double pixels = static_cast<double>(view.depth.size());
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / static_cast<double>(config_.most_points)))));
  const hal::GrayImage* picture = snapshot.picture;
  const bool coloured = picture && picture->pixels.size() == view.depth.size();
  for (int v = 0; v < view.camera.height; v += stride) {
    for (int u = 0; u < view.camera.width; u += stride) {
      const std::size_t at = view.index(u, v);
      const auto z = static_cast<double>(view.depth[at]);
      if (!std::isfinite(z) || z > view.far) continue;
      const Eigen::Vector3d p = view.camera.point(u, v, z);
      const Eigen::Vector3f q = (snapshot.map_from_view * p).cast<float>();
      next_.points.push_back({q.x(), q.y(), q.z(), grey(coloured ? picture->pixels[at] : 160),
                              largest_sigma(view, p, static_cast<double>(view.sigma_depth[at]))});
    }
  }
}

/// Those that are committed, as far as they are known, and those that the walk goes on with.
void Onlooker::copy_feet(const runtime::FrameSnapshot& snapshot) {
  next_.feet.clear();
  const nav::Committed& committed = snapshot.bus.committed;
  const auto add = [&](const hal::Stance& stance, hal::Foot foot, bool is_committed) {
    next_.feet.push_back({stance.at(foot), foot == hal::Foot::kLeft, is_committed});
  };
  if (committed.at_rest) {
    for (const hal::Foot foot : {hal::Foot::kLeft, hal::Foot::kRight}) add(committed.stance, foot, true);
  } else {
    constexpr std::uint32_t kUnderWay = 4;
    for (std::uint32_t back = std::min(kUnderWay, committed.next_index); back > 0; --back)
      if (const nav::CommittedStep* step = committed.step(committed.next_index - back))
        add(step->stance, step->step.foot, true);
  }
  const auto& walk = snapshot.mission.walk();
  if (!walk || !walk->fits(committed)) return;
  for (std::size_t i = walk->done(committed); i < walk->walk.steps.size(); ++i)
    add(walk->walk.stances[i], walk->walk.steps[i].foot, false);
}

void Onlooker::copy_floor(const runtime::FrameSnapshot& snapshot) {
  if (snapshot.stamp.exposure - floor_at_ < config_.floor_every) return;
  floor_at_ = snapshot.stamp.exposure;
  const std::uint32_t sum = runtime::sum_of(snapshot.mapper.floor());
  if (sum == floor_sum_ && next_.floor_number > 0) return;
  floor_sum_ = sum;
  next_.floor = runtime::occupancy(snapshot.mapper.floor(), snapshot.stamp.exposure);
  ++next_.floor_number;
}

void Onlooker::tell_voxels(const nav::VoxelMap& voxels) {
  for (int y = 0; y < voxels.bricks().y(); ++y) {
    for (int x = 0; x < voxels.bricks().x(); ++x) {
      const std::uint64_t changes = voxels.column_changed(x, y);
      if (changes == 0) continue;
      const nav::BrickKey key = voxels.key({x, y, 0});
      Told& told = told_[{key.x, key.y}];
      if (told.changes == changes) continue;
      if (!tell_column(voxels, x, y, told)) return;  // the rest next time
      told.changes = changes;
    }
  }
}

/// False where there was no room for all of it.
bool Onlooker::tell_column(const nav::VoxelMap& voxels, int x, int y, Told& told) {
  Time newest = told.until;
  for (int z = 0; z < voxels.bricks().z(); ++z) {
    const nav::VoxelMap::Index at{x, y, z};
    const std::size_t brick = voxels.brick_index(at);
    const nav::BrickSummary& summary = voxels.summary(brick);
    const bool known = told.changes != 0 && summary.changed <= told.until;
    if (known || summary.unseen == nav::kBrickVoxels) continue;
    SeenBrick seen = brick_of(voxels, voxels.key(at), brick);
    seen.world = world_;
    if (!bricks_.push(seen)) return false;
    newest = std::max(newest, summary.changed);
  }
  told.until = newest;
  return true;
}

}  // namespace headway::remote
