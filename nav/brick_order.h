// The order in which an octree holds bricks: depth first, x before y before z (Morton's order), so that a map
// is written as a tree without building one.
#pragma once

#include <cstdint>

#include "nav/brick.h"

namespace headway::nav {

/// Bricks from the origin to the end of OctoMap's keys, which are 16 bits wide.
inline constexpr std::int32_t kBrickReach = 32768 / kBrickEdge;
/// Levels of the tree above a brick.
inline constexpr int kLevelsAboveBrick = 13;

/// Whether an octree of OctoMap's has room for the brick.
constexpr bool within_octree(const BrickKey& key) {
  for (const std::int32_t k : {key.x, key.y, key.z}) {
    if (k < -kBrickReach || k >= kBrickReach) return false;
  }
  return true;
}

namespace detail {
/// Moves bit i of 13 to bit 3 i, and back.
constexpr std::uint64_t spread_bits(std::uint64_t v) {
  v = (v | v << 16) & 0x0000FF0000FFU;
  v = (v | v << 8) & 0x00F00F00F00FU;
  v = (v | v << 4) & 0x0C30C30C30C3U;
  return (v | v << 2) & 0x249249249249U;
}
constexpr std::uint64_t gather_bits(std::uint64_t v) {
  v &= 0x249249249249U;
  v = (v | v >> 2) & 0x0C30C30C30C3U;
  v = (v | v >> 4) & 0x00F00F00F00FU;
  v = (v | v >> 8) & 0x0000FF0000FFU;
  return (v | v >> 16) & 0xFFFFU;
}
}  // namespace detail

/// The place of a brick among all 2^39 of the tree. Its three lowest bits say which child the brick is (x + 2
/// y
/// + 4 z), the next three which one its parent is, and so on. Only for bricks within the octree.
constexpr std::uint64_t tree_order(const BrickKey& key) {
  const auto bits = [](std::int32_t k) {
    return detail::spread_bits(static_cast<std::uint64_t>(k + kBrickReach));
  };
  return bits(key.x) | bits(key.y) << 1 | bits(key.z) << 2;
}

/// The brick at a place of the tree.
constexpr BrickKey brick_at(std::uint64_t order) {
  const auto key = [](std::uint64_t bits) {
    return static_cast<std::int32_t>(detail::gather_bits(bits)) - kBrickReach;
  };
  return {key(order), key(order >> 1), key(order >> 2)};
}

}  // namespace headway::nav
