#include "app/examine_can_links.h"

#include <cmath>

#include <fmt/format.h>

namespace headway::app {

namespace {

constexpr double kSamplePoint = 0.875, kSamplePointTolerance = 0.03;

std::string description_of(const drivers::CanLink& link) {
  std::string text = link.is_up ? "up" : "down";
  if (link.controller && link.is_up) text += fmt::format(", {}", hal::text_of(*link.controller));
  if (link.bitrate > 0)
    text += fmt::format(", {} bit/s, sample point {:.1f} %", link.bitrate, 100 * link.sample_point);
  else
    text += ", no bit rate";
  if (link.controller)
    text += link.restart > Duration::zero()
                ? fmt::format(", back {:.0f} ms after it went off", to_seconds(link.restart) * 1e3)
                : ", stays off once it went off";
  return text + (link.kind.empty() ? "" : fmt::format(" ({})", link.kind));
}

void judge(const drivers::CanLink& link, Diagnosis& into) {
  const std::string found = description_of(link);
  const std::string set_up = fmt::format(
      "sudo ip link set {0} down; sudo ip link set {0} up type can bitrate {1} sample-point {2} restart-ms "
      "100 (without restart-ms where the driver refuses it, as the kernel's gs_usb does: better name that "
      "adapter as gs_usb:SERIAL in the robot file)",
      link.name, hal::kCanBitRate, kSamplePoint);
  // A virtual bus has neither controller nor bit rate.
  const bool is_real = link.controller.has_value();
  if (!link.is_up)
    into.fail(link.name, found, is_real ? set_up : fmt::format("sudo ip link set {} up", link.name));
  else if (is_real && link.bitrate != hal::kCanBitRate)
    into.fail(link.name, found, set_up);
  else if (is_real && link.controller == hal::CanBusState::kBusOff)
    into.fail(link.name, found,
              "look at the wiring, and at the bit rate of all that is on the bus; " + set_up);
  else if (is_real && (std::abs(link.sample_point - kSamplePoint) > kSamplePointTolerance ||
                       link.restart == Duration::zero()))
    into.warn(link.name, found, set_up);
  else
    into.ok(link.name, found);
}

}  // namespace

void examine_can_links(const std::vector<drivers::CanLink>& links, const std::string& interface,
                       Diagnosis& into, bool kernel_has_can) {
  into.about("can");
  bool is_there = interface.empty();
  for (const drivers::CanLink& link : links) {
    if (link.name == interface) {
      is_there = true;
      judge(link, into);
    } else {
      into.ok(link.name, description_of(link));
    }
  }
  if (!is_there && !kernel_has_can)
    into.fail(interface, "the kernel has no CAN",
              "'sudo modprobe can-raw', or a kernel with CONFIG_CAN_RAW; then look again");
  else if (!is_there)
    into.fail(interface, "there is no such interface",
              links.empty() ? "plug the adapter in, and look at 'dmesg' for its driver"
                            : "name one of the above: hardware: bus: in the robot file, or --bus");
  else if (links.empty())
    into.ok("interfaces", "the kernel has none, and none is needed");
}

}  // namespace headway::app
