#include "app/body_mask_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace headway::app {

using Eigen::Vector2d, Eigen::Vector2i;

namespace {

constexpr std::size_t kAround = 3;  // motions before and after the nearest
constexpr std::size_t kKept = 16;   // plans whose steps may still be walked

bool before(const Vector2i& a, const Vector2i& b) {
  return std::tuple(a.y(), a.x()) < std::tuple(b.y(), b.x());
}

double distance_to_line(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - t * d).norm();
}

bool same(const nav::Path& a, const nav::Path& b) {
  return a.states == b.states && a.start.position() == b.start.position() && a.start.yaw == b.start.yaw &&
         a.end == b.end && a.end_yaw == b.end_yaw;
}

}  // namespace

BodyMaskCheck::BodyMaskCheck(const nav::BodyOutline& outline, const nav::FloorGrid& grid)
    : outline_(outline), grid_(grid), masks_(outline, grid.resolution) {}

void BodyMaskCheck::plan(const nav::Path& path) {
  if (!waiting_ || !same(*waiting_, path)) waiting_ = std::make_shared<nav::Path>(path);
}

void BodyMaskCheck::handed(Time now, const runtime::BusLoopCounters& counters) {
  const bool took = counters.plans_taken > last_.plans_taken;
  last_ = counters;
  if (!took || !waiting_ || (!taken_.empty() && taken_.back().path == waiting_)) return;
  taken_.push_back({now, waiting_});
  if (taken_.size() > kKept) taken_.pop_front();
}

std::vector<std::shared_ptr<const nav::Path>> BodyMaskCheck::walked(
    std::span<const runtime::StepRecord> steps) const {
  std::vector<std::shared_ptr<const nav::Path>> paths;
  const auto add = [&](const std::shared_ptr<const nav::Path>& path) {
    if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
  };
  for (const runtime::StepRecord& step : steps.last(std::min<std::size_t>(steps.size(), 2)))
    for (auto plan = taken_.rbegin(); plan != taken_.rend(); ++plan)
      if (plan->at <= step.committed) {
        add(plan->path);
        break;
      }
  if (!taken_.empty()) add(taken_.back().path);
  return paths;
}

void BodyMaskCheck::add_motions(const nav::Path& path, const Vector2d& body, Room& room) const {
  if (path.states.empty()) return;
  const auto centre = [&](std::size_t i) { return grid_.centre(path.states[i].cell); };
  const auto facing = [&](std::size_t i) { return nav::heading_angle(path.states[i].heading); };
  const std::size_t last = path.states.size() - 1;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::max<std::size_t>(last, 1); ++i)
    nearest = std::min(nearest, distance_to_line(body, centre(i), centre(std::min(i + 1, last))));
  // A path may pass the same place twice, and the robot be at either.
  for (std::size_t i = 0; i < std::max<std::size_t>(last, 1); ++i) {
    if (distance_to_line(body, centre(i), centre(std::min(i + 1, last))) > nearest + 1e-9) continue;
    const std::size_t first = i > kAround ? i - kAround : 0, end = std::min(i + kAround + 1, last);
    for (std::size_t k = first; k < end; ++k) {
      const auto motion = nav::motion_between(path.states[k], path.states[k + 1]);
      const nav::Mask& mask = motion ? masks_.of(*motion) : masks_.standing(path.states[k].heading);
      for (const nav::Mask::Run& run : mask.runs)
        for (int x = run.first; x <= run.last; ++x) room.push_back(path.states[k].cell + Vector2i(x, run.dy));
    }
    if (first == 0) {
      const Vector2d c = centre(0);
      add_turn(path.start, {path.start.x, path.start.y, facing(0)}, room);
      add_turn({path.start.x, path.start.y, facing(0)}, {c.x(), c.y(), facing(0)}, room);
    }
    if (end == last) {
      const Vector2d c = centre(last);
      add_turn({c.x(), c.y(), facing(last)}, {path.end.x(), path.end.y(), facing(last)}, room);
      add_turn({path.end.x(), path.end.y(), facing(last)},
               {path.end.x(), path.end.y(), path.end_yaw.value_or(facing(last))}, room);
    }
  }
}

void BodyMaskCheck::add_turn(const Pose2& from, const Pose2& to, Room& room) const {
  const double turn = wrap_angle(to.yaw - from.yaw);
  const Vector2d way = to.position() - from.position();
  const int parts = 1 + static_cast<int>(std::ceil(std::max(std::abs(turn) / 0.1, way.norm() / 0.01)));
  for (int i = 0; i <= parts; ++i) {
    const double t = static_cast<double>(i) / parts;
    const Vector2d p = from.position() + t * way;
    const auto cells = nav::body_cells(grid_, outline_, {p.x(), p.y(), wrap_angle(from.yaw + t * turn)});
    room.insert(room.end(), cells.begin(), cells.end());
  }
}

double BodyMaskCheck::off(const Vector2i& cell, const Room& room) const {
  if (std::binary_search(room.begin(), room.end(), cell, before)) return 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector2i& r : room) nearest = std::min(nearest, (r - cell).cast<double>().norm());
  return nearest * grid_.resolution;
}

void BodyMaskCheck::judge(std::span<const runtime::StepRecord> steps, std::span<const sim::BodyBox> body) {
  if (body.empty() || taken_.empty()) return;
  Room room;
  for (const auto& path : walked(steps))
    add_motions(*path, body.front().map_from_box.translation().head<2>(), room);
  std::sort(room.begin(), room.end(), before);
  room.erase(std::unique(room.begin(), room.end()), room.end());
  double worst = 0;
  for (const sim::BodyBox& box : body) {
    const Eigen::Vector3d x = box.map_from_box.linear().col(0), at = box.map_from_box.translation();
    const nav::BodyOutline part{box.size.x() / 2, box.size.y() / 2, 0, 0};
    for (const Vector2i& cell : nav::body_cells(grid_, part, {at.x(), at.y(), std::atan2(x.y(), x.x())}))
      worst = std::max(worst, off(cell, room));
  }
  ++samples_;
  outside_ += worst > 0;
  farthest_ = std::max(farthest_, worst);
}

}  // namespace headway::app
