#include "app/hardware.h"

#include <string>

#include <fmt/format.h>

#include "drivers/stereo_pair.h"
#include "hal/error.h"

namespace headway::app {

void require_complete(const HardwareConfig& hardware) {
  const auto require = [&](const std::string& value, const char* key, const char* option,
                           const char* example) {
    if (!value.empty()) return;
    throw InputError(fmt::format("{}: hardware.{}: is missing, expected {}, here or with {}", hardware.place,
                                 key, example, option));
  };
  require(hardware.bus, "bus", "--bus", "the robot's CAN bus, such as socketcan:can0");
  require(hardware.left, "cameras.left", "--left", "a device file, such as one below /dev/v4l/by-path");
  require(hardware.right, "cameras.right", "--right", "a device file, such as one below /dev/v4l/by-path");
}

drivers::StereoPairConfig camera_pair(const HardwareConfig& hardware, const vision::StereoRig& rig) {
  drivers::V4l2CameraConfig eye;
  eye.format = hardware.format;
  eye.rate = hardware.rate;
  if (hardware.exposure) eye.exposure = seconds(*hardware.exposure);
  eye.gain = hardware.gain;
  eye.white_balance = hardware.white_balance;
  const auto looking = [&eye](const std::string& path, const vision::CameraIntrinsics& camera) {
    drivers::V4l2CameraConfig config = eye;
    config.path = path;
    config.width = camera.width;
    config.height = camera.height;
    return config;
  };
  drivers::StereoPairConfig pair;
  pair.left = looking(hardware.left, rig.left);
  pair.right = looking(hardware.right, rig.right);
  return pair;
}

std::unique_ptr<hal::StereoCamera> open_cameras(const HardwareConfig& hardware, const vision::StereoRig& rig,
                                                const hal::Clock& clock) {
  return std::make_unique<drivers::StereoPair>(camera_pair(hardware, rig), clock);
}

}  // namespace headway::app
