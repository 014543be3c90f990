// A brick: 8x8x8 voxels, the piece that maps keep, exchange and write as one.
//
// Brick boundaries lie at multiples of eight voxels from the map's origin, as OctoMap's keys have them: a
// brick is one node of depth 13 of an octree of the same resolution.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "hal/time.h"

namespace headway::nav {

/// Log-odds of being occupied in units of 0.05, so that OctoMap's defaults are whole numbers.
using LogOdds = std::int8_t;
namespace log_odds {
inline constexpr double kUnit = 0.05;     ///< natural log-odds per unit
inline constexpr LogOdds kUnseen = -128;  ///< never updated
inline constexpr LogOdds kLowest = -40, kHighest = 70;
inline constexpr LogOdds kHit = 17, kMiss = -8;
/// What a miss leaves of an older past before it counts: whatever has gone is empty after three of them.
inline constexpr LogOdds kMostBeforeMiss = -3 * kMiss - 1;
inline constexpr LogOdds kOccupied =
    0;  ///< from here on a voxel counts as occupied, as in OctoMap (p >= 0.5)
}  // namespace log_odds

/// A stamp older than any other, whose age is still a valid Duration.
inline constexpr Time kNever = Time(Duration(std::numeric_limits<Duration::rep>::min() / 4));

/// Which brick of space: floor(coordinate / (8 resolution)) along x, y and z.
struct BrickKey {
  std::int32_t x = 0, y = 0, z = 0;
  friend bool operator==(const BrickKey&, const BrickKey&) = default;
  friend auto operator<=>(const BrickKey&, const BrickKey&) = default;
};

inline constexpr int kBrickEdge = 8;  ///< voxels
inline constexpr int kBrickVoxels = 512;

/// The place of voxel (x, y, z), each 0..7, among a brick's values: eight cubes of 4x4x4 voxels, each of them
/// one cache line, with x running fastest in the cubes as among them.
constexpr int in_brick(int x, int y, int z) {
  const int cube = (z >> 2) << 2 | (y >> 2) << 1 | x >> 2;
  return cube << 6 | (z & 3) << 4 | (y & 3) << 2 | (x & 3);
}

/// The voxel of a brick that stands at this place.
struct VoxelOfBrick {
  int x, y, z;
};
constexpr VoxelOfBrick voxel_of_brick(int place) {
  return {(place >> 6 & 1) << 2 | (place & 3), (place >> 7 & 1) << 2 | (place >> 2 & 3),
          (place >> 8 & 1) << 2 | (place >> 4 & 3)};
}

/// The columns of a cube of 4x4x4 (bit y * 4 + x) in which a voxel's bit is set.
constexpr std::uint16_t columns_of_cube(std::uint64_t voxels) {
  voxels |= voxels >> 32;
  voxels |= voxels >> 16;
  return static_cast<std::uint16_t>(voxels);
}

using BrickValues = std::array<LogOdds, kBrickVoxels>;

/// Known about one brick without looking into it.
struct BrickSummary {
  std::uint16_t unseen = kBrickVoxels;  ///< voxels never updated
  std::uint16_t occupied = 0;           ///< voxels that count as occupied
  Time changed = kNever;                ///< stamp of the view that last changed a value in it
};

/// A brick on its own.
struct Brick {
  BrickValues values;
  BrickSummary summary;
};

}  // namespace headway::nav
