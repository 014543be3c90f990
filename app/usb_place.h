// Where on the USB a device of the kernel hangs, and what it calls itself (sysfs; kernel documentation:
// ABI/testing/sysfs-bus-usb).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace headway::app {

struct UsbPlace {
  std::string bus;                  ///< its root hub: "usb1"
  double bus_speed = 0, speed = 0;  ///< of the bus, and of the device on it [Mbit/s]
  std::string product, release;     ///< "HD Camera"; bcdDevice: "1.02". Empty: it does not say
};

/// Of a device's folder in sysfs, such as `/sys/class/net/can0/device`. Nothing when it is not on the USB.
std::optional<UsbPlace> usb_place(const std::filesystem::path& device);
/// Of a camera's device file below `root` ("/", or a test's), which may be a link.
std::optional<UsbPlace> usb_place_of_camera(const std::filesystem::path& root,
                                            const std::filesystem::path& file);

}  // namespace headway::app
