// What the simulated robot's two cameras see, drawn on a thread of its own: who serves the bus may not wait
// for pictures.
#pragma once

#include <Eigen/Geometry>
#include <atomic>
#include <cstdint>
#include <filesystem>

#include "app/frame_pipe.h"
#include "hal/clock.h"
#include "hal/exchange.h"
#include "runtime/threads.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/world.h"

namespace headway::app {

/// A moment at which both eyes were exposed.
struct Exposure {
  Time at{};
  Eigen::Isometry3d map_from_left = Eigen::Isometry3d::Identity();  ///< of the left camera's optical frame
  sim::WorldState world;
};

/// Draws the newest exposure and, when the camera's transfer is over, hands both eyes' pictures over to named
/// pipes: later only where drawing takes longer than that. Exposures that come while one is drawn are left
/// out, but for the newest.
class NodePictures {
 public:
  /// `clock` must outlive this. Throws InputError as SimStereoCamera and FramePipe do.
  NodePictures(const sim::World& world, const sim::StereoCameraModel& model,
               const std::filesystem::path& left, const std::filesystem::path& right, hal::Clock& clock);

  /// Called on one thread. Does not wait.
  void expose(const Exposure& exposure) { exposures_.publish(exposure); }
  /// Pairs that went out whole.
  std::uint64_t written() const { return written_; }
  bool failed() const { return thread_.ended(); }
  /// Why no more pictures come, once failed().
  const std::string& failure() const { return thread_.failure(); }

 private:
  void run(const std::atomic<bool>& stop);

  hal::Clock& clock_;
  hal::NewestSlot<Exposure> exposures_;
  std::atomic<std::uint64_t> written_{0};
  // The thread's alone:
  sim::Scene scene_;
  sim::SimStereoCamera camera_;
  hal::StereoFrame frame_;
  FramePipe left_, right_;
  runtime::Thread thread_;  ///< last: it ends first
};

}  // namespace headway::app
