#include "app/examine_usb.h"

#include <array>
#include <map>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "app/usb_place.h"
#include "drivers/pixel_format.h"

namespace headway::app {

namespace {

constexpr double kMegabyte = 1e6;

struct Eye {
  const char* name;
  UsbPlace place;
  double need;  ///< [bytes/s]
};

/// JPEG images are as large as the scene makes them: a fifth of a byte and more for each pixel.
constexpr double kJpegBytesPerPixel = 0.4;

double bytes_per_second(const drivers::V4l2CameraConfig& config) {
  const double frame =
      config.format == drivers::PixelFormat::kMjpeg
          ? kJpegBytesPerPixel * config.width * config.height
          : static_cast<double>(drivers::least_bytes({config.format, config.width, config.height,
                                                      drivers::row_bytes(config.format, config.width)}));
  return frame * config.rate.value_or(30);
}

/// What transfers with a reserved rate may take of a bus of that speed [Mbit/s]: 90 % at full speed, 80 % at
/// high speed (USB 2.0, 5.6.4); from 5 Gbit/s on of what the wire's code leaves, 8 bits in 10
/// (USB 3.2, 6.3.1).
double carried(double speed) {
  const double share = speed <= 12 ? 0.9 : speed <= 480 ? 0.8 : 0.64;
  return share * speed * 1e6 / 8;
}

std::string megabytes(double bytes) { return fmt::format("{:.1f} MB/s", bytes / kMegabyte); }

void judge_port(const Eye& eye, Diagnosis& into) {
  if (eye.need <= carried(eye.place.speed)) return;
  into.warn(
      fmt::format("{} camera's port", eye.name),
      fmt::format("{} are asked for, and {:.0f} Mbit/s carry {}", megabytes(eye.need), eye.place.speed,
                  megabytes(carried(eye.place.speed))),
      "plug it into a port of USB 2 or 3 without a slow hub between, or ask for less: size, rate, or format: "
      "MJPG");
}

void judge_bus(const std::string& bus, const std::vector<Eye>& eyes, Diagnosis& into) {
  double need = 0;
  std::string who;
  for (const Eye& eye : eyes) {
    need += eye.need;
    who += fmt::format("{}{} {}", who.empty() ? "" : " + ", eye.name, megabytes(eye.need));
  }
  const double speed = eyes.front().place.bus_speed;
  const std::string found =
      fmt::format("{} of the {} that {:.0f} Mbit/s carry", who, megabytes(carried(speed)), speed);
  if (need <= carried(speed))
    into.ok("bus " + bus, found);
  else
    into.warn("bus " + bus, found,
              eyes.size() > 1
                  ? "plug one camera into a port of another USB controller ('lsusb -t' shows which is "
                    "which), or ask for less: size, rate, or format: MJPG"
                  : "plug it into a port of USB 3, or ask for less: size, rate, or format: MJPG");
}

std::string name_of(const UsbPlace& place) {
  return fmt::format("{}, release {}", place.product.empty() ? "without a name" : place.product,
                     place.release.empty() ? "unknown" : place.release);
}

}  // namespace

void examine_usb_cameras(const std::filesystem::path& root, const drivers::StereoPairConfig& cameras,
                         Diagnosis& into) {
  into.about("usb");
  std::map<std::string, std::vector<Eye>> buses;
  for (const auto& [name, config] : {std::pair("left", &cameras.left), {"right", &cameras.right}}) {
    const std::optional<UsbPlace> place = usb_place_of_camera(root, config->path);
    std::error_code unreadable;
    if (!place && !std::filesystem::exists(config->path, unreadable)) continue;  // the eyes' lines say so
    into.ok(fmt::format("{} camera", name), place ? name_of(*place) : "not on the USB");
    if (!place) continue;
    const Eye eye{name, *place, bytes_per_second(*config)};
    judge_port(eye, into);
    buses[place->bus].push_back(eye);
  }
  for (const auto& [bus, eyes] : buses) judge_bus(bus, eyes, into);
}

void examine_usb_adapter(const std::filesystem::path& root, const std::string& interface, Diagnosis& into) {
  const std::optional<UsbPlace> place = usb_place(root / "sys/class/net" / interface / "device");
  if (place) into.ok("adapter", name_of(*place));
}

}  // namespace headway::app
