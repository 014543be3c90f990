#include "app/other_master.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "hal/bus_codec.h"
#include "hal/error.h"

namespace headway::app {

namespace {

constexpr Duration kPause = std::chrono::milliseconds(5);

template <std::size_t kCount>
bool is_one_of(std::uint32_t id, const std::array<std::uint32_t, kCount>& ids) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

const char* order_named(std::uint32_t id) {
  namespace wire = hal::bus;
  if (id == wire::Nmt::kId) return "a network management order";
  if (id == wire::Sync::kId) return "SYNC";
  if (id == wire::Heartbeat::kIds[0]) return "the heartbeat of the vision computer's node 1";
  if (is_one_of(id, wire::DriveCommand::kIds)) return "a set-point for a drive";
  if (is_one_of(id, wire::SdoRequest::kIds)) return "an SDO request to a drive";
  if (id == wire::StepCommand::kId || id == wire::WalkOrder::kId) return "an order to walk";
  if (id == wire::WalkControl::kId) return "WalkControl";
  return nullptr;
}

std::optional<std::string> word_of_a_robot(const hal::CanFrame& frame) {
  namespace wire = hal::bus;
  const bool is_drive = frame.id != wire::Heartbeat::kIds[0] && is_one_of(frame.id, wire::Heartbeat::kIds);
  if (!is_drive && frame.id != wire::WalkStatus::kId) return std::nullopt;
  return fmt::format("{} (0x{:03X})",
                     is_drive ? "the heartbeat of a drive" : "the status of a control computer", frame.id);
}

template <class WordOf>
std::optional<std::string> heard(hal::CanBus& bus, hal::Clock& clock, Duration time, WordOf word_of) {
  std::array<hal::CanFrame, 32> frames;
  for (const Time end = clock.now() + time; clock.now() < end; clock.sleep_until(clock.now() + kPause)) {
    const std::size_t count = bus.receive(frames);
    for (const hal::CanFrame& frame : std::span(frames).first(count))
      if (const auto word = word_of(frame)) return word;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> word_of_a_master(const hal::CanFrame& frame) {
  const char* name = order_named(frame.id);
  return name ? std::optional(fmt::format("{} (0x{:03X})", name, frame.id)) : std::nullopt;
}

std::optional<std::string> other_master(hal::CanBus& bus, hal::Clock& clock, Duration time) {
  return heard(bus, clock, time, word_of_a_master);
}

void refuse_other_master(hal::CanBus& bus, hal::Clock& clock) {
  if (const auto word = other_master(bus, clock))
    throw Error(
        *word +
        " is heard on the bus: another program commands this robot; end 'headway run' or what else does, "
        "here or on another computer of this bus");
}

void refuse_other_robot(hal::CanBus& bus, hal::Clock& clock) {
  if (const auto word = heard(bus, clock, kMasterIsHeardWithin, word_of_a_robot))
    throw Error(
        *word +
        " is heard on the bus: there is a robot already; take a bus of its own for the simulated one, or "
        "end the other 'headway node'");
}

}  // namespace headway::app
