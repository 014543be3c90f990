#include "nav/solid_boxes.h"

#include <bit>
#include <cstring>

namespace headway::nav {
namespace {

static_assert(std::endian::native == std::endian::little, "a row's first voxel is its lowest byte");
static_assert(log_odds::kOccupied == 0, "occupied is what has no sign");

/// Bit y * 8 + x of each layer: occupied.
using Layers = std::array<std::uint64_t, VoxelMap::kBrickEdge>;

/// The signs of four voxels in a row, the first in the lowest bit.
std::uint64_t occupied_of_four(const LogOdds* values) {
  std::uint32_t bytes;
  std::memcpy(&bytes, values, 4);
  // Gathered in the highest byte by one multiplication.
  return (~bytes >> 7 & 0x01010101U) * 0x10204080U >> 28;
}

Layers occupied(std::span<const LogOdds, VoxelMap::kBrickVoxels> values) {
  Layers layers{};
  for (int z = 0; z < VoxelMap::kBrickEdge; ++z)
    for (int y = 0; y < VoxelMap::kBrickEdge; ++y)
      for (const int x : {0, 4})
        layers[static_cast<std::size_t>(z)] |= occupied_of_four(values.data() + VoxelMap::in_brick(x, y, z))
                                               << (8 * y + x);
  return layers;
}

static_assert(VoxelMap::in_brick(7, 5, 6) == VoxelMap::in_brick(4, 5, 6) + 3, "four voxels stand in a row");

}  // namespace

SolidBoxes::SolidBoxes(std::span<const LogOdds, VoxelMap::kBrickVoxels> values) {
  Layers layers = occupied(values);
  for (unsigned z = 0; z < 8; ++z) {
    while (layers[z] != 0) {
      const auto first = static_cast<unsigned>(std::countr_zero(layers[z]));
      const unsigned x = first & 7, y = first >> 3;
      const std::uint64_t row = layers[z] >> 8 * y & 0xff;
      const auto length = static_cast<unsigned>(std::countr_one(row >> x));
      const std::uint64_t run = ((std::uint64_t{1} << length) - 1) << x;
      std::uint64_t area = run << 8 * y;
      unsigned y_end = y + 1, z_end = z + 1;
      for (; y_end < 8 && (layers[z] >> 8 * y_end & run) == run; ++y_end) area |= run << 8 * y_end;
      layers[z] &= ~area;
      for (; z_end < 8 && (layers[z_end] & area) == area; ++z_end) layers[z_end] &= ~area;
      const auto byte = [](unsigned v) { return static_cast<std::uint8_t>(v); };
      boxes_[count_++] = {{byte(x), byte(y), byte(z)}, {byte(x + length), byte(y_end), byte(z_end)}};
    }
  }
}

}  // namespace headway::nav
