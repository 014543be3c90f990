#include "drivers/v4l2_listing.h"

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <linux/videodev2.h>

#include "drivers/opened_device.h"
#include "drivers/pixel_format.h"

namespace headway::drivers {

namespace fs = std::filesystem;

namespace {

/// No driver has more of anything; one that never ends its list must not hang the program.
constexpr std::uint32_t kMost = 256;

std::optional<OpenedDevice> opened(DeviceCalls& calls, const char* path) {
  const int descriptor = calls.open(path);
  if (descriptor < 0) return std::nullopt;
  return OpenedDevice(calls, descriptor);
}

double rate_of(const v4l2_fract& period) {
  return period.numerator == 0 ? 0 : static_cast<double>(period.denominator) / period.numerator;
}

std::vector<double> offered_rates(const OpenedDevice& device, std::uint32_t code, const OfferedFormat& size) {
  std::vector<double> rates;
  for (std::uint32_t i = 0; i < kMost; ++i) {
    v4l2_frmivalenum interval{};
    interval.index = i;
    interval.pixel_format = code;
    interval.width = static_cast<std::uint32_t>(size.width);
    interval.height = static_cast<std::uint32_t>(size.height);
    if (device.ioctl(VIDIOC_ENUM_FRAMEINTERVALS, &interval) < 0) break;
    if (interval.type != V4L2_FRMIVAL_TYPE_DISCRETE) {
      rates.push_back(rate_of(interval.stepwise.min));  // the shortest interval
      break;
    }
    rates.push_back(rate_of(interval.discrete));
  }
  std::sort(rates.rbegin(), rates.rend());
  return rates;
}

void add_sizes(const OpenedDevice& device, std::uint32_t code, std::vector<OfferedFormat>& formats) {
  for (std::uint32_t i = 0; i < kMost; ++i) {
    v4l2_frmsizeenum size{};
    size.index = i;
    size.pixel_format = code;
    if (device.ioctl(VIDIOC_ENUM_FRAMESIZES, &size) < 0) return;
    const bool is_discrete = size.type == V4L2_FRMSIZE_TYPE_DISCRETE;
    OfferedFormat format{.code = code, .rates = {}, .is_largest_only = !is_discrete};
    format.width = static_cast<int>(is_discrete ? size.discrete.width : size.stepwise.max_width);
    format.height = static_cast<int>(is_discrete ? size.discrete.height : size.stepwise.max_height);
    format.rates = offered_rates(device, code, format);
    formats.push_back(std::move(format));
    if (!is_discrete) return;
  }
}

template <std::size_t kSize>
std::string text_in(const __u8 (&characters)[kSize]) {
  const auto* end = std::find(std::begin(characters), std::end(characters), 0);
  return {std::begin(characters), end};
}

std::string text_of(const OfferedFormat& format) {
  std::string text = fmt::format("{} {}{} x {}", code_text(format.code),
                                 format.is_largest_only ? "up to " : "", format.width, format.height);
  if (!format.rates.empty()) text += fmt::format(" ({:.4g} /s)", fmt::join(format.rates, ", "));
  return text;
}

/// The link below v4l/by-path that leads to a device.
std::string port_path_of(const fs::path& devices, const fs::path& device) {
  std::error_code ignored;
  for (const fs::directory_entry& link : fs::directory_iterator(devices / "v4l/by-path", ignored)) {
    if (fs::equivalent(link.path(), device, ignored)) return link.path().string();
  }
  return "";
}

std::optional<ListedCamera> camera_at(DeviceCalls& calls, const fs::path& devices, const fs::path& device) {
  const std::optional<OpenedDevice> open = opened(calls, device.c_str());
  v4l2_capability capability{};
  if (!open || open->ioctl(VIDIOC_QUERYCAP, &capability) < 0) return std::nullopt;
  const bool knows_own = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const std::uint32_t can = knows_own ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0) return std::nullopt;
  return ListedCamera{device.string(), port_path_of(devices, device), text_in(capability.card),
                      text_in(capability.bus_info)};
}

std::optional<int> number_of(const std::string& name) {
  constexpr std::string_view kPrefix = "video";
  if (!name.starts_with(kPrefix) || name.size() == kPrefix.size() || name.size() > kPrefix.size() + 6)
    return std::nullopt;
  const std::string digits = name.substr(kPrefix.size());
  if (digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return std::stoi(digits);
}

}  // namespace

std::vector<OfferedFormat> offered_formats(DeviceCalls& calls, const char* path) {
  std::vector<OfferedFormat> formats;
  const std::optional<OpenedDevice> device = opened(calls, path);
  for (std::uint32_t i = 0; device && i < kMost; ++i) {
    v4l2_fmtdesc description{};
    description.index = i;
    description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (device->ioctl(VIDIOC_ENUM_FMT, &description) < 0) break;
    add_sizes(*device, description.pixelformat, formats);
  }
  return formats;
}

std::string one_line(const std::vector<OfferedFormat>& formats) {
  std::vector<std::string> read, unread;
  for (const OfferedFormat& format : formats) {
    const std::string code = code_text(format.code);
    if (format_of(format.code))
      read.push_back(text_of(format));
    else if (unread.empty() || unread.back() != code)
      unread.push_back(code);
  }
  std::string line = read.empty() ? "nothing" : fmt::format("{}", fmt::join(read, ", "));
  if (!unread.empty())
    line += fmt::format("; in formats that Headway does not read: {}", fmt::join(unread, ", "));
  return line;
}

std::vector<ListedCamera> list_cameras(DeviceCalls& calls, const fs::path& devices) {
  std::vector<std::pair<int, fs::path>> nodes;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(devices, ignored)) {
    if (const auto number = number_of(entry.path().filename())) nodes.emplace_back(*number, entry.path());
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<ListedCamera> cameras;
  for (const auto& [number, path] : nodes) {
    if (auto camera = camera_at(calls, devices, path)) cameras.push_back(std::move(*camera));
  }
  return cameras;
}

}  // namespace headway::drivers
