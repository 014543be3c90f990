#include "nav/masks.h"

#include <algorithm>
#include <numbers>
#include <string>

#include "hal/error.h"

namespace headway::nav {

namespace {

using Eigen::Vector2i;

constexpr int kWidest = 60;           // cells from the centre
constexpr double kStepsPerCell = 10;  // of the simulated motion

/// The cells touched so far while the outline moves, around the cell where it began.
class Touched {
 public:
  Touched(const BodyOutline& outline, double resolution)
      : outline_(outline),
        resolution_(resolution),
        reach_(static_cast<int>(std::ceil(outline.reach() / resolution)) + 2),
        side_(2 * reach_ + 1),
        cells_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), false) {}

  void stand(const Pose2& base, double clearance) {
    for (int y = -reach_; y <= reach_; ++y) {
      for (int x = -reach_; x <= reach_; ++x) {
        if (at(x, y)) continue;
        const Eigen::Vector2d centre(x * resolution_, y * resolution_);
        if (distance_to_square(outline_, base, centre, resolution_) <= clearance) {
          cells_[index(x, y)] = true;
        }
      }
    }
  }

  /// In small steps, the clearance widened by half of one so that nothing between two of them is missed.
  void move(const Pose2& from, const Pose2& to) {
    const double turn = wrap_angle(to.yaw - from.yaw);
    const Eigen::Vector2d way = to.position() - from.position();
    const double longest = way.norm() + std::abs(turn) * outline_.reach();
    const int steps = std::max(1, static_cast<int>(std::ceil(longest / resolution_ * kStepsPerCell)));
    const double clearance = outline_.clearance() + longest / steps / 2;
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      stand({from.x + t * way.x(), from.y + t * way.y(), from.yaw + t * turn}, clearance);
    }
  }

  /// The mask, turned by a quarter turn as often as asked.
  Mask mask(int quarters) const {
    Mask mask;
    for (int y = -reach_; y <= reach_; ++y) {
      for (int x = -reach_; x <= reach_; ++x) {
        const Vector2i source = turned_back({x, y}, quarters);
        if (!at(source.x(), source.y())) continue;
        if (!mask.runs.empty() && mask.runs.back().dy == y && mask.runs.back().last == x - 1) {
          mask.runs.back().last = x;
        } else {
          mask.runs.push_back({y, x, x});
        }
      }
    }
    return mask;
  }

 private:
  static Vector2i turned_back(Vector2i cell, int quarters) {
    for (int i = 0; i < quarters; ++i) cell = Vector2i(cell.y(), -cell.x());
    return cell;
  }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y + reach_) * static_cast<std::size_t>(side_) +
           static_cast<std::size_t>(x + reach_);
  }
  bool at(int x, int y) const { return cells_[index(x, y)]; }

  BodyOutline outline_;
  double resolution_;
  int reach_, side_;
  std::vector<bool> cells_;
};

Touched simulate(const BodyOutline& outline, double resolution, const Motion& motion) {
  const double before = heading_angle(motion.heading), after = heading_angle(motion.heading_after());
  const Eigen::Vector2d way = cell_towards(motion.direction()).cast<double>() * resolution;
  Touched touched(outline, resolution);
  touched.move({0, 0, before}, {0, 0, after});
  touched.move({0, 0, after}, {way.x(), way.y(), after});
  return touched;
}

}  // namespace

double heading_angle(int heading) { return wrap_angle(heading * std::numbers::pi / 4); }

bool Mask::contains(const Vector2i& cell) const {
  return std::any_of(runs.begin(), runs.end(), [&](const Run& r) {
    return r.dy == cell.y() && r.first <= cell.x() && cell.x() <= r.last;
  });
}

int Mask::size() const {
  int cells = 0;
  for (const Run& r : runs) cells += r.last - r.first + 1;
  return cells;
}

Masks::Masks(const BodyOutline& outline, double resolution) : resolution_(resolution) {
  if (!(resolution > 0) || outline.reach() / resolution > kWidest - 3) {
    throw InputError("body: spans more than " + std::to_string(kWidest) + " cells of " +
                     std::to_string(resolution) + " m to a side, expected a coarser floor grid");
  }
  // A quarter turn maps the grid on itself, so two headings give all eight.
  for (int heading = 0; heading < 2; ++heading) {
    Touched still(outline, resolution);
    still.stand({0, 0, heading_angle(heading)}, outline.clearance());
    for (int quarters = 0; quarters < 4; ++quarters) {
      const int turned = heading + 2 * quarters;
      standing_[static_cast<std::size_t>(turned)] = still.mask(quarters);
    }
    for (int number = 0; number < kMotions; ++number) {
      const Touched touched = simulate(outline, resolution, {heading, number});
      for (int quarters = 0; quarters < 4; ++quarters) {
        const Motion turned{heading + 2 * quarters, number};
        motions_[static_cast<std::size_t>(turned.configuration())] = touched.mask(quarters);
      }
    }
  }
}

}  // namespace headway::nav
