#include "app/usb_place.h"

#include <cstdlib>

#include "app/first_line.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

bool is_usb_device(const fs::path& folder) {
  return fs::exists(folder / "busnum") && fs::exists(folder / "speed");
}

double number_in(const fs::path& file) { return std::strtod(first_line(file).c_str(), nullptr); }

/// "0102", binary-coded decimals, as "1.02".
std::string release_of(const std::string& bcd) {
  if (bcd.size() != 4) return bcd;
  const std::string whole = bcd.substr(0, 2), part = bcd.substr(2);
  return (whole.front() == '0' ? whole.substr(1) : whole) + "." + part;
}

}  // namespace

std::optional<UsbPlace> usb_place(const fs::path& device) {
  std::error_code fault;
  fs::path folder = fs::canonical(device, fault);
  if (fault) return std::nullopt;
  while (!is_usb_device(folder)) {
    if (folder == folder.parent_path()) return std::nullopt;
    folder = folder.parent_path();
  }
  UsbPlace place;
  place.speed = number_in(folder / "speed");
  place.product = first_line(folder / "product");
  place.release = release_of(first_line(folder / "bcdDevice"));
  while (is_usb_device(folder.parent_path())) folder = folder.parent_path();
  place.bus = folder.filename();
  place.bus_speed = number_in(folder / "speed");
  return place;
}

std::optional<UsbPlace> usb_place_of_camera(const fs::path& root, const fs::path& file) {
  std::error_code fault;
  const fs::path node = fs::canonical(root / file.relative_path(), fault);
  if (fault) return std::nullopt;
  return usb_place(root / "sys/class/video4linux" / node.filename() / "device");
}

}  // namespace headway::app
