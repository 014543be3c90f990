// What cameras there are and what they offer, for tools and error messages.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drivers/device_calls.h"

namespace headway::drivers {

/// One size of one pixel format.
struct OfferedFormat {
  std::uint32_t code = 0;        ///< V4L2's, of the pixel format
  int width = 0, height = 0;     ///< [px]; where any up to this can be had, the largest
  std::vector<double> rates;     ///< frames per second, the fastest first; empty: the driver does not say
  bool is_largest_only = false;  ///< smaller sizes can be had as well
};

/// All, in the driver's order. Empty when the device cannot be asked.
std::vector<OfferedFormat> offered_formats(DeviceCalls& calls, const char* path);

/// "YUYV 640 x 480 (30, 15 /s), ..."; "nothing" for none. Of pixel formats that Headway does not read only
/// their names.
std::string one_line(const std::vector<OfferedFormat>& formats);

/// A device that captures images.
struct ListedCamera {
  std::string path;       ///< of the device
  std::string port_path;  ///< below v4l/by-path, which stays the same for one port; empty if there is none
  std::string name, bus;  ///< as the driver says
};

/// Those below `devices` (mostly /dev), by number. Devices that cannot be opened or do not capture are left
/// out.
std::vector<ListedCamera> list_cameras(DeviceCalls& calls, const std::filesystem::path& devices);

}  // namespace headway::drivers
