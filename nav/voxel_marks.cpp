#include "nav/voxel_marks.h"

namespace headway::nav {

void VoxelMarks::reset(const VoxelMap& map) {
  if (slots_.size() == map.brick_count()) {
    for (const std::size_t brick : marked_) slots_[brick] = -1;
  } else {
    slots_.assign(map.brick_count(), -1);
  }
  marked_.clear();
  size_ = map.size().cast<float>();
  row_ = static_cast<std::size_t>(map.bricks().x());
  layer_ = row_ * static_cast<std::size_t>(map.bricks().y());
}

void VoxelMarks::mark(const Eigen::Vector3f& point, Mark mark) {
  const bool inside = (point.array() >= 0).all() && (point.array() < size_.array()).all();
  if (!inside) return;
  const Eigen::Vector3i i = point.cast<int>();
  const std::size_t brick = static_cast<std::size_t>(i.z() >> 3) * layer_ +
                            static_cast<std::size_t>(i.y() >> 3) * row_ +
                            static_cast<std::size_t>(i.x() >> 3);
  std::int32_t& slot = slots_[brick];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(marked_.size());
    marked_.push_back(brick);
    if (pool_.size() < marked_.size()) pool_.emplace_back();
    pool_[static_cast<std::size_t>(slot)].fill(kNone);
  }
  Mark& m = pool_[static_cast<std::size_t>(slot)]
                 [static_cast<std::size_t>(VoxelMap::in_brick(i.x() & 7, i.y() & 7, i.z() & 7))];
  if (m < mark) m = mark;
}

}  // namespace headway::nav
