// What the frame loop shows of its newest frame, as plain copies, so that nobody has to wait for anybody.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "hal/exchange.h"
#include "hal/frame.h"
#include "hal/pose2.h"
#include "runtime/frame_loop.h"
#include "runtime/recording/ros_messages.h"

namespace headway::remote {

/// As it lies in a point cloud's message.
struct SeenPoint {
  float x = 0, y = 0, z = 0;  ///< in the map [m]
  std::uint32_t rgb = 0;      ///< 0x00rrggbb
  float sigma = 0;            ///< sqrt of the largest eigenvalue of its covariance [m]
};

struct SeenFoot {
  Pose2 at;  ///< of the sole's middle, in the map
  bool left = false, committed = false;
};

struct Seen {
  std::uint64_t number = 0;  ///< of the frame that was shown, from 1
  Time exposure{};
  Pose2 base;  ///< where the committed steps end, in the map
  Eigen::Isometry3d map_from_chest = Eigen::Isometry3d::Identity(),
                    map_from_view = Eigen::Isometry3d::Identity();
  hal::GrayImage picture;  ///< rectified left; of a depth camera, near is bright
  std::vector<SeenPoint> points;
  std::vector<Pose2> way;
  std::vector<SeenFoot> feet;
  recording::ros::OccupancyGrid floor;
  std::uint64_t floor_number = 0;  ///< one more whenever `floor` is another
};

/// A brick's voxels: bit x of byte 8 z + y is voxel (x, y, z).
struct SeenBrick {
  nav::BrickKey key;
  std::uint32_t world = 0;  ///< another number: all bricks told before are of another world
  std::array<std::uint8_t, 64> occupied{}, unseen{};
};

/// The frame loop's end. Copies only what somebody looks at.
class Onlooker {
 public:
  struct Config {
    std::size_t most_points = 20000;
    Duration floor_every = seconds(0.5), voxels_every = seconds(0.2);
  };
  Onlooker() : Onlooker(Config()) {}
  explicit Onlooker(const Config& config) : config_(config) {}

  // In the frame loop's thread:
  void see(const runtime::FrameSnapshot& snapshot);
  /// What comes next is another run, perhaps at an earlier time.
  void begin_again();

  // In the viewers':
  /// What is to be copied from the next frame on.
  struct Wish {
    bool picture = false, points = false, voxels = false;
  };
  void wish(const Wish& wish);
  /// True when there was a new frame.
  bool update() { return seen_.update(); }
  const Seen& seen() const { return seen_.value(); }
  bool take(SeenBrick& brick) { return bricks_.pop(brick); }

 private:
  struct Told {
    std::uint64_t changes = 0;
    Time until = nav::kNever;
  };
  void copy_picture(const runtime::FrameSnapshot& snapshot);
  void copy_points(const runtime::FrameSnapshot& snapshot);
  void copy_feet(const runtime::FrameSnapshot& snapshot);
  void copy_floor(const runtime::FrameSnapshot& snapshot);
  void tell_voxels(const nav::VoxelMap& voxels);
  bool tell_column(const nav::VoxelMap& voxels, int x, int y, Told& told);

  Config config_;
  Seen next_;
  Time floor_at_ = nav::kNever, voxels_at_ = nav::kNever;
  std::uint32_t floor_sum_ = 0, world_ = 0;
  std::map<std::pair<int, int>, Told> told_;  ///< by columns of bricks
  hal::NewestSlot<Seen> seen_;
  hal::BoundedQueue<SeenBrick, 8192> bricks_;
  std::atomic<bool> picture_{false}, points_{false}, voxels_{false};
};

}  // namespace headway::remote
