// One scripted camera on the desk, its driver, and a clock that a test steps.
#pragma once

#include <functional>
#include <optional>

#include "drivers/v4l2_camera.h"
#include "tests/drivers/scripted_camera.h"

namespace headway::drivers::testing {

inline constexpr const char* kEye = "/dev/v4l/by-path/left";

/// Small, so that thousands of streams are made in a moment.
inline V4l2CameraConfig small_config(PixelFormat format = PixelFormat::kGrey) {
  V4l2CameraConfig config;
  config.path = kEye;
  config.width = 32;
  config.height = 24;
  config.format = format;
  config.rate = 30;
  config.exposure = std::chrono::milliseconds(8);
  return config;
}

class CameraBench {
 public:
  explicit CameraBench(PixelFormat format = PixelFormat::kGrey) : config(small_config(format)) {
    clock.set(at_seconds(100));
    device = &calls.add(kEye, ScriptedCamera(format));
  }

  hal::ManualClock clock;
  ScriptedCalls calls{clock};
  ScriptedCamera* device;
  V4l2CameraConfig config;
  std::optional<V4l2Camera> camera;
  hal::GrayImage image;
  int taken = 0;
  /// Called for each frame that is about to be taken.
  std::function<void(const V4l2Camera::Waiting&)> on_frame = [](const auto&) {};

  void open() { camera.emplace(config, clock, calls); }

  /// As the frame loop does it: polls and takes the newest.
  void step(Duration d = std::chrono::milliseconds(5)) {
    clock.advance(d);
    camera->poll();
    while (camera->waiting().size() > 1) camera->skip();
    if (camera->waiting().empty()) return;
    on_frame(camera->waiting().front());
    if (camera->take(image)) ++taken;
  }
  void run(Duration d, Duration cycle = std::chrono::milliseconds(5)) {
    for (const Time end = clock.now() + d; clock.now() < end;) step(cycle);
  }
  bool run_until(const std::function<bool()>& done, Duration limit) {
    for (const Time end = clock.now() + limit; clock.now() < end && !done();) step();
    return done();
  }
  bool run_until(hal::CameraState state, Duration limit) {
    return run_until([&] { return camera->stats().state == state; }, limit);
  }
  /// Open, and the first frame is there.
  void start() {
    open();
    run_until(hal::CameraState::kStreaming, seconds(2));
  }
  const hal::CameraStats& stats() const { return camera->stats(); }
};

}  // namespace headway::drivers::testing
