// The 72 motions of the planner and their masks: the floor cells the body may touch during each.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "nav/body_outline.h"

namespace headway::nav {

constexpr int kHeadings = 8;        ///< heading h faces 45 deg * h
constexpr int kForwardMotions = 5;  ///< turn by -2..2 eighths, then go one cell that way
constexpr int kSidewayMotions = 4;  ///< go one cell by -2, -1, 1, 2 eighths off the heading, which stays
constexpr int kMotions = kForwardMotions + kSidewayMotions;
constexpr int kStraightOn = 2;                         ///< the forward motion without a turn
constexpr int kConfigurations = kHeadings * kMotions;  ///< 72

enum class Mode : std::uint8_t { kForward = 0, kSideway = 1 };

/// One cell on, in direction d (45 deg * d).
inline Eigen::Vector2i cell_towards(int direction) {
  constexpr std::array<int, kHeadings> kX{1, 1, 0, -1, -1, -1, 0, 1}, kY{0, 1, 1, 1, 0, -1, -1, -1};
  const auto d = static_cast<std::size_t>(direction);
  return {kX[d], kY[d]};
}

double heading_angle(int heading);  ///< [rad], in [-pi, pi)

/// Motion `number` (0..8, forward ones first) from `heading` (0..7).
struct Motion {
  int heading = 0, number = 0;

  constexpr Mode mode() const { return number < kForwardMotions ? Mode::kForward : Mode::kSideway; }
  /// Eighths of a turn from the heading to where it goes: -2..2, left positive.
  constexpr int turn() const {
    if (number < kForwardMotions) return number - 2;
    return number < kForwardMotions + 2 ? number - 7 : number - 6;
  }
  constexpr int direction() const { return (heading + turn()) & 7; }
  constexpr int heading_after() const { return mode() == Mode::kForward ? direction() : heading; }
  constexpr int configuration() const { return heading * kMotions + number; }
};

/// Cells relative to the one the robot stands on, as runs of one row each.
struct Mask {
  struct Run {
    int dy = 0, first = 0, last = 0;  ///< cells (first..last, dy)
    bool operator==(const Run&) const = default;
  };
  std::vector<Run> runs;  ///< by rising dy, then first; never touching each other

  bool contains(const Eigen::Vector2i& cell) const;
  int size() const;
};

/// Masks of all configurations, built by moving the outline in steps of a tenth of a cell.
/// Throws InputError when the outline spans more than 60 cells to a side.
class Masks {
 public:
  Masks(const BodyOutline& outline, double resolution);

  const Mask& of(const Motion& m) const { return motions_[static_cast<std::size_t>(m.configuration())]; }
  const Mask& of(int configuration) const { return motions_[static_cast<std::size_t>(configuration)]; }
  /// Standing on the centre of a cell.
  const Mask& standing(int heading) const { return standing_[static_cast<std::size_t>(heading)]; }
  double resolution() const { return resolution_; }

 private:
  std::array<Mask, kConfigurations> motions_;
  std::array<Mask, kHeadings> standing_;
  double resolution_;
};

}  // namespace headway::nav
