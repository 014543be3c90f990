// How well a map of the room agrees with the room, whoever made it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "bench/mapping_room.h"
#include "nav/voxel_map.h"

namespace headway::bench {

/// Percent.
struct MapScore {
  double surface_occupied = 0, surface_empty = 0;  ///< of the voxels that three or more pixels hit
  double pole = 0;                                 ///< occupied, of those of them on the pole
  double ghosts = 0;          ///< of the occupied voxels, those that no surface touches, nor their neighbours
  double empty_in_solid = 0;  ///< of the empty voxels, those half an edge and more inside of something solid
  double air_empty = 0;       ///< empty, of the voxels of the air that are seen
  std::size_t occupied = 0;   ///< voxels
};

/// What there is to be seen of the room from a number of places, in voxels.
class SeenRoom {
 public:
  SeenRoom(const Room& room, const std::vector<PosedView>& views, double resolution);

  /// `voxel_at` tells a map's voxel at a point [m].
  template <class VoxelAt>
  MapScore score(const VoxelAt& voxel_at) const {
    Counts counts;
    std::size_t i = 0;
    for (int z = 0; z < size_.z(); ++z)
      for (int y = 0; y < size_.y(); ++y)
        for (int x = 0; x < size_.x(); ++x, ++i) counts.add(truth_[i], voxel_at(centre(x, y, z)));
    return counts.score();
  }

  /// The corners of the space that is looked at [m].
  static Eigen::Vector3d lowest() { return {-3.2, -3.2, -0.2}; }
  static Eigen::Vector3d highest() { return {3.2, 3.2, 3.2}; }

 private:
  enum Truth : std::uint8_t {
    kSurface = 1,
    kPole = 2,
    kFarFromSurfaces = 4,
    kSolid = 8,
    kAir = 16,
    kInRange = 32  ///< of one of the cameras; nothing else is counted
  };
  struct Counts {
    std::size_t surface = 0, surface_occupied = 0, surface_empty = 0, pole = 0, pole_occupied = 0,
                occupied = 0, ghosts = 0, empty = 0, in_solid = 0, air = 0, air_empty = 0;
    void add(std::uint8_t truth, nav::Voxel voxel);
    MapScore score() const;
  };

  Eigen::Vector3d centre(int x, int y, int z) const {
    return lowest() + resolution_ * (Eigen::Vector3d(x, y, z).array() + 0.5).matrix();
  }
  std::size_t index(const Eigen::Vector3i& i) const {
    return (static_cast<std::size_t>(i.z()) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(i.y())) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(i.x());
  }
  void add_view(const Room& room, const PosedView& view, std::vector<std::uint8_t>& pixels,
                std::vector<std::uint8_t>& seen) const;

  double resolution_;
  Eigen::Vector3i size_;
  std::vector<std::uint8_t> truth_;
};

}  // namespace headway::bench
