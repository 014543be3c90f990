#include "app/examine_wires.h"

#include <array>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>

#include "app/drive_names.h"
#include "app/leave_head.h"
#include "app/loop_configs.h"
#include "app/other_master.h"
#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "drivers/v4l2_exposure.h"
#include "hal/emergency.h"

namespace headway::app {

namespace {

constexpr Duration kCycle = seconds(0.005);

/// A classic frame on the wire, stuffed as badly as can be.
double bits_of(const hal::CanFrame& frame) {
  const int data = 8 * frame.dlc;
  return 47 + data + (34 + data - 1) / 4;
}

/// The bus as the bus loop uses it, and what was on it.
class Listening final : public hal::CanBus {
 public:
  explicit Listening(hal::CanBus& bus) : bus_(bus) {}
  bool send(const hal::CanFrame& frame) noexcept override {
    const bool sent = bus_.send(frame);
    if (sent) bits_ += bits_of(frame);
    return sent;
  }
  std::size_t receive(std::span<hal::CanFrame> into) noexcept override {
    const std::size_t count = bus_.receive(into);
    for (const hal::CanFrame& frame : into.first(count)) bits_ += bits_of(frame);
    heard_ += count;
    return count;
  }
  hal::CanBusState state() const noexcept override { return bus_.state(); }
  hal::CanBusStats stats() const noexcept override { return bus_.stats(); }
  double bits() const { return bits_; }
  std::uint64_t heard() const { return heard_; }

 private:
  hal::CanBus& bus_;
  double bits_ = 0;
  std::uint64_t heard_ = 0;
};

void judge_bus(const Listening& bus, Duration time, bool tells_state, Diagnosis& into) {
  into.about("bus");
  const hal::CanBusStats stats = bus.stats();
  const std::string wiring =
      "look at the wiring, at 60 ohms between CAN_H and CAN_L, and at the bit rate of all that is on it";
  const std::string silence =
      tells_state
          ? wiring
          : "is it an adapter of this kind that is plugged in there? Nothing of it was heard; if so, " +
                wiring;
  const bool is_gone = stats.state == hal::CanBusState::kGone;
  const std::string state =
      fmt::format("{}; {} frames heard",
                  tells_state || is_gone ? hal::text_of(stats.state) : "not told by an adapter of this kind",
                  bus.heard());
  if (is_gone) {
    into.fail("state", state,
              "the adapter was unplugged, or lost its power: look at its plug and cable, and at 'dmesg'");
    return;
  }
  if (stats.state == hal::CanBusState::kErrorActive)
    into.ok("state", state);
  else if (stats.state == hal::CanBusState::kErrorWarning)
    into.warn("state", state, wiring);
  else
    into.fail("state", state, wiring);
  const std::uint64_t bad = stats.lost + stats.unusable + stats.bus_off + stats.gone;
  if (bad > 0)
    into.warn("faults",
              fmt::format("{} frames lost, {} unusable; {} times off the bus, {} times gone", stats.lost,
                          stats.unusable, stats.bus_off, stats.gone),
              wiring);
  const double load = bus.bits() / hal::kCanBitRate / to_seconds(time);
  const std::string found = fmt::format("{:.0f} % at most", 100 * load);
  if (bus.heard() == 0)
    into.fail("load", "nothing was heard", silence);
  else if (load > 0.6)
    into.warn("load", found,
              "see with 'headway can dump' who sends so much: frames of low priority come late above 60 %");
  else
    into.ok("load", found);
}

std::string trouble_of(const drivers::DriveReport& drive) {
  switch (drive.failure) {
    case drivers::DriveFailure::kNone:
      return drive.phase != drivers::DrivePhase::kRunning ? "does not answer so far"
             : drive.quick_stops > 0                      ? "runs; was held by a quick stop before"
                                                          : "runs";
    case drivers::DriveFailure::kSetupTimedOut:
      return "does not answer";
    case drivers::DriveFailure::kSetupRefused:
      return fmt::format("refuses object {:04X}:{:02X} (abort code {:08X})", drive.object.index,
                         drive.object.subindex, drive.abort_code);
    case drivers::DriveFailure::kSetupReadsDifferent:
      return fmt::format("does not keep object {:04X}:{:02X}", drive.object.index, drive.object.subindex);
    case drivers::DriveFailure::kStateTimedOut:
      return "does not come to Operation enabled";
    case drivers::DriveFailure::kSetPointTimedOut:
      return "does not acknowledge set-points";
    case drivers::DriveFailure::kOutsideLimits:
      return "stands outside its limits";
    case drivers::DriveFailure::kNotHomed:
      return "does not know where its joint is";
    case drivers::DriveFailure::kHomingFailed:
      return "did not find its home";
    case drivers::DriveFailure::kDriveFault:
      return "reports a fault";
    case drivers::DriveFailure::kQuickStopped:
      return "has stopped by itself (Quick stop active)";
    case drivers::DriveFailure::kEmergency:
      return fmt::format("sent emergency 0x{:04X} ({})", drive.emergency_code,
                         hal::name_of_emergency(drive.emergency_code));
    case drivers::DriveFailure::kGone:
      return "went silent: its heartbeat stays away";
  }
  return "?";
}

void judge_drive(const char* joint, std::uint8_t node, const drivers::DriveReport& drive,
                 const DriveNames& names, Diagnosis& into) {
  const std::string what = fmt::format("{} drive, node 0x{:02X}", joint, node);
  const std::string name = names.text();
  const std::string found = trouble_of(drive) + (name.empty() ? "" : "; " + name);
  if (drive.phase == drivers::DrivePhase::kRunning && drive.failure == drivers::DriveFailure::kNone)
    into.ok(what, found);
  else if (drive.failure == drivers::DriveFailure::kNone ||
           drive.failure == drivers::DriveFailure::kSetupTimedOut ||
           drive.failure == drivers::DriveFailure::kGone)
    into.fail(what, found, "switch the head on; look at its node number and at the bit rate of its bus");
  else if (drive.failure == drivers::DriveFailure::kNotHomed)
    into.fail(what, found, "home it with its maker's tool, or see 'homing' in docs/bring-up.md");
  else if (drive.failure == drivers::DriveFailure::kOutsideLimits)
    into.fail(what, found,
              "turn the head inside by hand; led by profile ('set_points'), 'headway run' brings it there");
  else
    into.fail(what, found, "its manual says what that means; docs/bus.md says what it must be able to do");
}

void judge_walker(const drivers::CanWalker& walker, Diagnosis& into) {
  into.about("walker");
  switch (walker.health()) {
    case hal::WalkerHealth::kReady:
      into.ok("control computer", "sends status and chest pose");
      break;
    case hal::WalkerHealth::kNoChest:
      into.fail("control computer", "sends its status, and no chest pose",
                "it must send CTL_ChestXY and CTL_ChestZRot every 20 ms (docs/bus.md)");
      break;
    case hal::WalkerHealth::kStarting:
    case hal::WalkerHealth::kLost:
      into.fail("control computer",
                walker.health() == hal::WalkerHealth::kLost ? "went silent" : "is not heard",
                "start its program; it must send CTL_WalkStatus every 20 ms (docs/bus.md)");
      break;
  }
  const drivers::WalkerCounts counts = walker.counts();
  const std::uint32_t bad = counts.wrong_crc + counts.repeated + counts.wrong_sequence + counts.undeclared;
  // Whoever computes CRCs rightly counts rightly as well; two who do count each for itself.
  const bool are_two = counts.wrong_sequence > 0 && counts.wrong_crc + counts.undeclared == 0;
  if (bad > 0)
    into.warn("frames",
              fmt::format("{} with a wrong CRC, {} repeated, {} out of sequence, {} undeclared",
                          counts.wrong_crc, counts.repeated, counts.wrong_sequence, counts.undeclared),
              are_two ? "two may be sending the same messages: is there another control computer, or a "
                        "simulated one, on this bus? See 'headway can dump'"
                      : "both sides must mean the same config/can/headway.dbc; see 'headway can dump'");
  if (const auto clock = walker.clock())
    into.ok("clock",
            fmt::format("is {:.3f} s {} ours, give or take {:.1f} ms", std::abs(to_seconds(clock->offset)),
                        clock->offset < Duration{} ? "ahead of" : "behind",
                        1e3 * to_seconds(clock->uncertainty)));
  else if (walker.clock_is_synchronised())
    into.ok("clock", "heard");
  else
    into.warn("clock", "CTL_Time is not heard", "it must send CTL_Time every second (docs/bus.md)");
}

}  // namespace

void examine_bus(const Robot& robot, hal::CanBus& wire, hal::Clock& clock, Duration time, Diagnosis& into,
                 const std::function<bool()>& asked, bool tells_state) {
  Listening bus(wire);
  drivers::HeadConfig config = head_config(robot);
  // Who examines the robot moves nothing.
  using Policy = drivers::HomingConfig::Policy;
  if (config.homing.policy == Policy::kMove) config.homing.policy = Policy::kRequired;
  config.may_come_inside = false;
  if (const auto word = other_master(bus, clock)) {
    into.about("bus");
    into.fail("other master", *word + " is heard: another program commands this robot; nothing was sent",
              "end 'headway run' or what else commands it, here or on another computer of this bus");
    return;
  }
  drivers::Cia402Head head(bus, config);
  drivers::CanWalker walker(bus);
  DriveNames pan(bus, config.pan_node), tilt(bus, config.tilt_node);
  std::array<hal::CanFrame, 32> frames;
  const Time begin = clock.now();
  for (Time next = begin; next - begin < time && !asked(); next += kCycle) {
    clock.sleep_until(next);
    while (const std::size_t count = bus.receive(frames))
      for (const hal::CanFrame& frame : std::span(frames).first(count)) {
        head.receive(frame);
        walker.receive(frame);
        pan.receive(frame);
        tilt.receive(frame);
      }
    head.tick(clock.now());
    walker.tick(clock.now());
    if (head.pan().phase == drivers::DrivePhase::kRunning) pan.start();
    if (head.tilt().phase == drivers::DrivePhase::kRunning) tilt.start();
    // A drive that boots is set up again, over the same SDO channel.
    if (head.pan().phase == drivers::DrivePhase::kRunning) pan.tick(clock.now());
    if (head.tilt().phase == drivers::DrivePhase::kRunning) tilt.tick(clock.now());
  }
  if (!asked()) {
    judge_bus(bus, time, tells_state, into);
    if (bus.state() == hal::CanBusState::kGone) {
      // Their silence is the adapter's.
      into.about("head");
      into.fail("drives", "not looked at to the end: the adapter went away", "see what is said of the bus");
      into.about("walker");
      into.fail("control computer", "not looked at to the end: the adapter went away",
                "see what is said of the bus");
    } else {
      into.about("head");
      judge_drive("pan", config.pan_node, head.pan(), pan, into);
      judge_drive("tilt", config.tilt_node, head.tilt(), tilt, into);
      judge_walker(walker, into);
    }
  }
  leave_head(head, bus, clock);
}

void examine_exposures(const std::vector<EyeLook>& eyes, drivers::DeviceCalls& calls, Diagnosis& into) {
  into.about("eyes");
  for (const EyeLook& eye : eyes) {
    const auto exposure = drivers::present_exposure(calls, eye.path.c_str());
    if (!exposure) continue;  // a camera that is gone has its line already
    const std::string what = fmt::format("{} exposure", eye.name);
    const std::string found = fmt::format(
        "{}, {}", exposure->time ? fmt::format("{:.1f} ms", to_seconds(*exposure->time) * 1e3) : "not told",
        exposure->is_automatic ? "automatic" : "by hand");
    if (exposure->may_slow_down)
      into.warn(what, found + ": in the dark it may lower the frame rate",
                "hardware: cameras: exposure_ms: in the robot file" +
                    (exposure->can_keep_rate
                         ? fmt::format("; or 'v4l2-ctl -d {} -c exposure_dynamic_framerate=0'", eye.path)
                         : ""));
    else
      into.ok(what, found);
  }
}

void examine_cameras(const CameraLook& look, const HardwareConfig& wanted, Diagnosis& into) {
  into.about("eyes");
  for (const EyeLook& eye : look.eyes) {
    const std::string what = fmt::format("{} camera", eye.name);
    const std::string found =
        fmt::format("{}, {:.1f} frames/s, {} lost, {} damaged{}{}", hal::text_of(eye.stats.state), eye.rate,
                    eye.stats.lost, eye.stats.damaged, eye.fault.empty() ? "" : "; ", eye.fault);
    if (eye.stats.state != hal::CameraState::kStreaming)
      into.fail(what, found, "look at its plug, and at 'headway camera list'");
    else if (eye.rate < 0.9 * wanted.rate)
      into.warn(what, found,
                fmt::format(
                    "{} frames/s are asked for: a longer exposure than {:.1f} ms, or two cameras on one USB "
                    "controller, keep it from that",
                    wanted.rate, 1e3 / wanted.rate));
    else
      into.ok(what, found);
  }
  if (!look.pair) return;
  const auto gap = look.pair->exposure_gap;  // the lower end of a bin of the histogram
  const double apart = gap ? to_seconds(*gap + drivers::PairStats::kBinWidth / 2) * 1e3 : 5;
  const std::string found =
      fmt::format("{}; {:.1f} pairs/s, right {} ms after left", hal::text_of(look.pair->state),
                  look.pair->rate, gap ? fmt::format("{:+.1f}", apart) : "more than 5");
  if (look.pair->state != hal::CameraState::kStreaming)
    into.fail("pair", found, "the eyes must be triggered together, or run at the same rate");
  else if (std::abs(apart) > 2)
    into.warn("pair", found, "a head that turns meanwhile errs in depth: trigger both eyes together");
  else
    into.ok("pair", found);
}

}  // namespace headway::app
