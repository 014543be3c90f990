#include "operator/swept.h"

#include <algorithm>
#include <cmath>

namespace headway::remote {

namespace {

constexpr std::int8_t kSwept = 100;

/// visit(pose) at each of the way, and between two of them at least every half cell and every 0.05 rad.
template <class Visit>
void along(const std::vector<Pose2>& way, double apart, Visit&& visit) {
  if (!way.empty()) visit(way.front());
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Pose2 &a = way[i - 1], &b = way[i];
    const Eigen::Vector2d step = b.position() - a.position();
    const double turn = wrap_angle(b.yaw - a.yaw);
    const int parts =
        std::max(1, static_cast<int>(std::ceil(std::max(step.norm() / apart, std::abs(turn) / 0.05))));
    for (int k = 1; k <= parts; ++k) {
      const double t = static_cast<double>(k) / parts;
      const Eigen::Vector2d at = a.position() + t * step;
      visit(Pose2{at.x(), at.y(), wrap_angle(a.yaw + t * turn)});
    }
  }
}

/// The cells of `grid` around the way, in which no part of the body can be missed.
nav::FloorGrid around(const std::vector<Pose2>& way, double reach, const nav::FloorGrid& grid) {
  nav::FloorGrid out = grid;
  out.width = out.height = 0;
  if (way.empty()) return out;
  Eigen::Vector2d low = way.front().position(), high = low;
  for (const Pose2& base : way) {
    low = low.cwiseMin(base.position());
    high = high.cwiseMax(base.position());
  }
  const Eigen::Vector2d room = Eigen::Vector2d::Constant(reach + grid.resolution);
  const Eigen::Vector2i first = grid.cell(low - room).cwiseMax(0),
                        last =
                            grid.cell(high + room)
                                .cwiseMin(Eigen::Vector2i(grid.width, grid.height) - Eigen::Vector2i::Ones());
  if ((last.array() < first.array()).any()) return out;
  out.origin = grid.origin + grid.resolution * first.cast<double>();
  out.width = last.x() - first.x() + 1;
  out.height = last.y() - first.y() + 1;
  return out;
}

}  // namespace

recording::ros::OccupancyGrid swept_floor(const std::vector<Pose2>& way, const nav::BodyOutline& outline,
                                          const nav::FloorGrid& grid, Time stamp) {
  const nav::FloorGrid part = around(way, outline.reach(), grid);
  recording::ros::OccupancyGrid out;
  out.header = {recording::ros::stamp(stamp), "map"};
  out.info.map_load_time = out.header.stamp;
  out.info.resolution = static_cast<float>(part.resolution);
  out.info.width = static_cast<std::uint32_t>(part.width);
  out.info.height = static_cast<std::uint32_t>(part.height);
  out.info.origin.position = {part.origin.x(), part.origin.y(), 0};
  out.data.assign(part.size(), 0);
  if (out.data.empty()) return out;
  along(way, part.resolution / 2, [&](const Pose2& base) {
    for (const Eigen::Vector2i& cell : nav::body_cells(part, outline, base))
      out.data[part.index(cell)] = kSwept;
  });
  return out;
}

}  // namespace headway::remote
