// Any bytes as a conversation between the head's master and its drives. Two scripted drives answer rightly;
// the input loses, cuts, bends, delays and doubles what they say, lets them boot, fault and fall mute, and
// says whatever it likes in their place. What fuzzers and mutation tests do to the head, and small
// conversations to begin with.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/cia402_head.h"
#include "hal/bus_codec.h"
#include "hal/cia402.h"
#include "tests/drivers/scripted_drive.h"
#include "tests/fuzz/any_bytes.h"
#include "tests/fuzz/heard_bus.h"
#include "tests/fuzz/promise.h"

namespace headway::fuzz {

class Conversation {
 public:
  enum Record : std::uint8_t { kCycles, kFrame, kDrive, kToHead, kToDrives, kAim, kOperator, kHang };

  explicit Conversation(std::string_view input)
      : bytes_(input), config_(config_of(bytes_.byte())), head_(bus_, config_) {
    const std::uint8_t drives = bytes_.byte();
    for (Side& side : sides_) {
      side.drive.homed = config_.homing.policy == Policy::kNone || (drives & 1) == 0;
      side.drive.knows_transition_16 = (drives & 2) == 0;
      side.drive.position = 4 * bytes_.number();
    }
    sides_[0].lower = config_.limits.lower.pan, sides_[0].upper = config_.limits.upper.pan;
    sides_[1].lower = config_.limits.lower.tilt, sides_[1].upper = config_.limits.upper.tilt;
  }

  void run() {
    while (!bytes_.empty() && cycles_ < kMostCycles) step();
    heal();
  }

 private:
  using Policy = drivers::HomingConfig::Policy;
  static constexpr int kMostCycles = 3000;
  static constexpr Duration kCycle = std::chrono::milliseconds(5);

  /// A joint, its drive, and what that was heard to say.
  struct Side {
    explicit Side(std::uint8_t node) : drive(node) {}
    drivers::testing::ScriptedDrive drive;
    double lower = 0, upper = 0;                  ///< [rad]
    double least = 0, most = 0;                   ///< positions that were heard [deg]
    Time status{}, motion{};                      ///< stamps of what was heard last
    bool at_home = false;                         ///< said so since it booted
    std::uint32_t boot_ups = 0, quick_stops = 0;  ///< that the head has counted
  };
  /// What becomes of the next frames to the head.
  struct Spoiler {
    enum Kind : std::uint8_t { kNone, kLose, kCut, kBend, kDelay, kDouble } kind = kNone;
    int frames = 0;
    std::uint8_t at = 0, by = 0;  ///< of the data: which byte, with what
  };

  static drivers::HeadConfig config_of(std::uint8_t byte) {
    drivers::HeadConfig config;
    if (byte & 1) config.set_points = drivers::SetPointMode::kCyclic;
    config.homing.policy = static_cast<Policy>((byte >> 1) % 3);
    config.homing.method = 17;
    config.may_come_inside = (byte & 8) == 0;
    return config;
  }

  void step() {
    const std::uint8_t what = bytes_.byte();
    const int more = what >> 3;  // 0..31
    switch (static_cast<Record>(what % 8)) {
      case kCycles:
        for (int i = 0; i <= more * more / 2; ++i) cycle();
        break;
      case kFrame:
        say(more);
        break;
      case kDrive:
        turn(sides_[static_cast<std::size_t>(more % 2)].drive, more / 2);
        break;
      case kToHead: {
        const std::uint8_t how = bytes_.byte();
        spoiler_ = {.kind = static_cast<Spoiler::Kind>(how % 6), .frames = more + 1};
        spoiler_.at = bytes_.byte() % 8, spoiler_.by = bytes_.byte();
        break;
      }
      case kToDrives:
        lost_to_drives_ = more;
        break;
      case kAim:
        head_.command({1e-3 * bytes_.number(), 1e-3 * bytes_.number()});
        break;
      case kOperator:
        operate(more);
        break;
      case kHang:
        now_ += more * kCycle;
        cycle();
        break;
    }
  }

  /// In the name of a drive, or of nobody.
  void say(int more) {
    constexpr std::array<std::uint32_t, 6> kAnswers{hal::cia402::kEmcyBase,      hal::cia402::kTpdo1Base,
                                                    hal::cia402::kTpdo2Base,     hal::cia402::kSdoAnswerBase,
                                                    hal::cia402::kHeartbeatBase, 0};
    const std::uint32_t base = kAnswers[static_cast<std::size_t>(more / 2) % kAnswers.size()];
    hal::CanFrame frame{
        .id = base == 0 ? bytes_.word() & 0x7FFU : base + 0x11U + static_cast<unsigned>(more % 2),
        .dlc = bytes_.byte(),
        .data = bytes_.data(),
        .stamp = now_};
    const hal::bus::MessageInfo* message = hal::bus::find_message(frame.id);
    if (frame.dlc > 8) frame.dlc = message ? message->dlc : 8;
    hear(frame);
  }

  void turn(drivers::testing::ScriptedDrive& drive, int what) {
    switch (what % 12) {
      case 0:
        drive.boot(now_);
        break;
      case 1:
        drive.emergency(bytes_.word(), now_);
        break;
      case 2:
        drive.fault();
        break;
      case 3:
        drive.quick_stop();
        break;
      case 4:
        drive.mute_status = !drive.mute_status;
        break;
      case 5:
        drive.mute_position = !drive.mute_position;
        break;
      case 6:
        drive.mute_heartbeat = !drive.mute_heartbeat;
        break;
      case 7:
        drive.mute_sdo = !drive.mute_sdo;
        break;
      case 8:
        drive.never_acknowledges = !drive.never_acknowledges;
        break;
      case 9:
        drive.stuck_switched_on = !drive.stuck_switched_on;
        break;
      case 10:
        drive.homed = false;
        break;
      default:
        drive.position = 4 * bytes_.number();  // pushed there
    }
  }

  void operate(int what) {
    if (what % 4 == 0) head_.recover();
    if (what % 4 == 1) bus_.full = !bus_.full;
    if (what == 30) leave();
  }
  void leave() {
    head_.leave();
    leaves_ = true;
  }

  // --- one cycle, as the bus loop has it ---

  void cycle() {
    ++cycles_;
    now_ += kCycle;
    std::vector<hal::CanFrame> late;
    late.swap(late_);
    for (const hal::CanFrame& frame : late) hear(frame);
    for (Side& side : sides_) {
      side.drive.tick(now_);
      std::vector<hal::CanFrame> said;
      said.swap(side.drive.out);
      for (const hal::CanFrame& frame : said) pass(frame);
    }
    bus_.sent.clear();
    head_.tick(now_);
    for (const hal::CanFrame& frame : bus_.sent) {
      look_at(frame);
      if (lost_to_drives_ > 0 && frame.id >= 0x200) {
        --lost_to_drives_;
        continue;
      }
      for (Side& side : sides_) side.drive.receive(frame, now_);
    }
    look_at_head();
  }

  void pass(hal::CanFrame frame) {
    if (spoiler_.frames <= 0 || spoiler_.kind == Spoiler::kNone) return hear(frame);
    --spoiler_.frames;
    switch (spoiler_.kind) {
      case Spoiler::kCut:
        frame.dlc = static_cast<std::uint8_t>(frame.dlc > 0 ? frame.dlc - 1 : 0);
        return hear(frame);
      case Spoiler::kBend:
        frame.data[spoiler_.at] = spoiler_.by;
        return hear(frame);
      case Spoiler::kDelay:
        late_.push_back(frame);
        break;
      case Spoiler::kDouble:
        hear(frame);
        return hear(frame);
      default:
        break;
    }
  }

  void hear(const hal::CanFrame& frame) {
    for (Side& side : sides_) note(frame, side);
    head_.receive(frame);
  }

  void note(const hal::CanFrame& frame, Side& side) const {
    using namespace hal::bus;
    const std::uint8_t node = side.drive.node;
    if (const auto status = DriveStatus::unpack(frame);
        status && frame.id == hal::cia402::kTpdo1Base + node) {
      side.status = frame.stamp;
      const bool enabled = hal::cia402::state_of(status->statusword) == hal::cia402::State::kOperationEnabled;
      const bool attained = (status->statusword & hal::cia402::status_bit::kHomingAttained) != 0;
      side.at_home = side.at_home || (enabled && attained && status->mode == hal::cia402::kHoming);
    }
    if (const auto motion = DriveMotion::unpack(frame);
        motion && frame.id == hal::cia402::kTpdo2Base + node) {
      side.motion = frame.stamp;
      side.least = std::min(side.least, motion->position_deg);
      side.most = std::max(side.most, motion->position_deg);
    }
    const auto heartbeat = Heartbeat::unpack(frame);
    if (heartbeat && heartbeat->state == Heartbeat::State::kBootUp &&
        frame.id == hal::cia402::kHeartbeatBase + node)
      side.at_home = false;
  }

  // --- what must hold ---

  bool asks_for_home() const { return config_.homing.policy != Policy::kNone; }

  void look_at(const hal::CanFrame& frame) const {
    using namespace hal::bus;
    if (const auto nmt = Nmt::unpack(frame)) {
      promise(nmt->node == 0x11 || nmt->node == 0x12, "only the head's drives are ordered about");
      return;
    }
    if (frame.id == Sync::kId || frame.id == 0x701) return;
    for (const Side& side : sides_) {
      if (frame.id == hal::cia402::kRpdo1Base + side.drive.node)
        return look_at(DriveCommand::unpack(frame), side);
      if (frame.id == hal::cia402::kSdoRequestBase + side.drive.node) {
        promise(!head_.has_left(), "who has left says nothing more");
        return promise(SdoRequest::unpack(frame).has_value(), "requests are such as the contract declares");
      }
    }
    promise(false, "the head sends its own messages only");
  }

  void look_at(const std::optional<hal::bus::DriveCommand>& command, const Side& side) const {
    using namespace hal::cia402;
    promise(command.has_value(), "commands are such as the contract declares");
    promise(!head_.has_left(), "who has left says nothing more");
    const bool cyclic = config_.set_points == drivers::SetPointMode::kCyclic;
    constexpr double kRounding = 1e-3;  // [deg]
    const double lower = degrees(side.lower), upper = degrees(side.upper), target = command->target_deg;
    // A cyclic one stands where the joint is, wherever that is.
    promise(target >= (cyclic ? std::min(lower, side.least) : lower) - kRounding &&
                target <= (cyclic ? std::max(upper, side.most) : upper) + kRounding,
            "no set-point lies outside the limits", std::to_string(target));
    if (leaves_) return;
    if (command->mode == kHoming) {
      promise(asks_for_home(), "only drives that may not know where they are look for home");
      promise(
          (command->controlword & control_bit::kStartHoming) == 0 || config_.homing.policy == Policy::kMove,
          "no drive looks for home that may not");
    } else {
      promise(command->mode == (cyclic ? kCyclicPosition : kProfilePosition),
              "drives are led as was configured");
      promise(!asks_for_home() || side.at_home, "no set-point before a drive is at home");
    }
  }

  void look_at_head() {
    using hal::HeadHealth;
    const hal::HeadState state = head_.state();
    const drivers::DriveReport &pan = head_.pan(), &tilt = head_.tilt();
    promise(state.health <= HeadHealth::kFault, "the head's health has a name");
    look_at(pan, sides_[0]);
    look_at(tilt, sides_[1]);
    promise(within(state.target.pan, sides_[0]) && within(state.target.tilt, sides_[1]),
            "the target lies within the limits");
    if (leaves_) return;
    const auto failed = [](const drivers::DriveReport& r) { return r.phase == drivers::DrivePhase::kFailed; };
    const auto runs = [](const drivers::DriveReport& r) { return r.phase == drivers::DrivePhase::kRunning; };
    const bool at_fault = state.health == HeadHealth::kFault || state.health == HeadHealth::kNotHomed;
    promise(at_fault == (failed(pan) || failed(tilt)), "a head is at fault where a drive is");
    const bool is_ready = state.health == HeadHealth::kReady;
    promise(!is_ready || (runs(pan) && runs(tilt)), "a head that is ready has drives that run");
    for (const Side& side : sides_)
      promise(!is_ready || (now_ - side.status <= hal::bus::DriveStatus::kTimeout &&
                            now_ - side.motion <= hal::bus::DriveMotion::kTimeout),
              "a head that is ready was heard");
    const bool moved_on = state.stamp != stamp_;
    promise(std::isfinite(state.position.pan) && std::isfinite(state.position.tilt) && state.stamp <= now_,
            "positions are numbers from before now");
    promise(!moved_on || !asks_for_home() || (sides_[0].at_home && sides_[1].at_home),
            "no position before both drives are at home");
    stamp_ = state.stamp;
  }

  static void look_at(const drivers::DriveReport& report, Side& side) {
    using drivers::DriveFailure, drivers::DrivePhase;
    promise(report.phase <= DrivePhase::kLeft && report.failure <= DriveFailure::kGone,
            "a drive's state has a name");
    promise((report.phase == DrivePhase::kFailed) <= (report.failure != DriveFailure::kNone),
            "a drive that failed says why");
    promise(report.boot_ups >= side.boot_ups && report.quick_stops >= side.quick_stops, "counts only grow");
    side.boot_ups = report.boot_ups, side.quick_stops = report.quick_stops;
  }

  static double degrees(double radians) { return radians * 180 / std::numbers::pi; }
  static bool within(double angle, const Side& side) {
    constexpr double kRounding = 2e-5;
    return angle >= side.lower - kRounding && angle <= side.upper + kRounding;
  }

  // --- the end ---

  /// Once nothing disturbs them, they come to what has a name; and where the drives can, to work again when
  /// somebody recovers the head.
  void heal() {
    bus_.full = false;
    spoiler_ = {};
    lost_to_drives_ = 0;
    for (Side& side : sides_) {
      auto& d = side.drive;
      d.mute_status = d.mute_position = d.mute_heartbeat = d.mute_sdo = false;
      d.never_acknowledges = d.stuck_switched_on = false;
    }
    if (leaves_) {
      wait([&] { return head_.has_left(); });
      return promise(head_.has_left(), "a head that is to leave has left");
    }
    settle();
    if (is_outside(sides_[0]) || is_outside(sides_[1])) return;
    head_.recover();
    cycle();
    settle();
    const bool knows = sides_[0].drive.homed && sides_[1].drive.homed;
    if (knows || config_.homing.policy != Policy::kRequired)
      promise(head_.state().health == hal::HeadHealth::kReady,
              "a head whose drives are whole is ready once recovered",
              text(head_.pan()) + "; " + text(head_.tilt()));
  }

  static std::string text(const drivers::DriveReport& r) {
    return "phase " + std::to_string(static_cast<int>(r.phase)) + ", failure " +
           std::to_string(static_cast<int>(r.failure)) + ", state " +
           std::to_string(static_cast<int>(r.state));
  }

  void settle() {
    const auto has_settled = [&] {
      using drivers::DrivePhase;
      const DrivePhase pan = head_.pan().phase, tilt = head_.tilt().phase;
      const bool failed = pan == DrivePhase::kFailed || tilt == DrivePhase::kFailed;
      // Beside one that failed the other looks for home no further.
      const auto ends = [&](DrivePhase phase) {
        return phase == DrivePhase::kRunning || phase == DrivePhase::kFailed ||
               (failed && phase == DrivePhase::kHoming);
      };
      const hal::HeadHealth health = head_.state().health;
      return ends(pan) && ends(tilt) && health != hal::HeadHealth::kStarting &&
             health != hal::HeadHealth::kDegraded;
    };
    wait(has_settled);
    for (int i = 0; i < 50; ++i) cycle();  // what was ready by what was heard before is that no more
    wait(has_settled);
    promise(has_settled(), "a head that nothing disturbs is ready or says what it lacks",
            text(head_.pan()) + "; " + text(head_.tilt()));
  }
  template <class Done>
  void wait(const Done& done) {
    for (const Time end = now_ + std::chrono::seconds(12); now_ < end && !done();) cycle();
  }
  bool is_outside(const Side& side) const {
    const double at = 1e-3 * side.drive.position;
    return at < degrees(side.lower) - 0.5 || at > degrees(side.upper) + 0.5;
  }

  AnyBytes bytes_;
  drivers::HeadConfig config_;
  HeardBus bus_;
  drivers::Cia402Head head_;
  std::array<Side, 2> sides_{Side(0x11), Side(0x12)};
  Time now_ = at_seconds(100), stamp_{};
  int cycles_ = 0, lost_to_drives_ = 0;
  Spoiler spoiler_;
  std::vector<hal::CanFrame> late_;  ///< to be heard in the next cycle
  bool leaves_ = false;
};

inline void hear_answers(std::string_view input) { Conversation(input).run(); }

inline std::vector<std::string> whole_answers() {
  using C = Conversation;
  const auto record = [](Input& in, C::Record what, int more) -> Input& { return in.byte(what | more << 3); };
  const auto begun = [&](int config, int drives) {
    Input in;
    in.byte(config).byte(drives).word(500).word(-500);
    record(in, C::kCycles, 20);
    return in;
  };
  std::vector<std::string> all;
  for (const int config : {0, 1, 2, 3, 4, 5, 8}) {
    Input in = begun(config, config >= 4 ? 1 : 0);
    record(in, C::kCycles, 25);
    record(in, C::kAim, 0).word(300).word(200);
    record(in, C::kCycles, 10);
    all.push_back(in.text());
  }
  Input spoilt = begun(0, 0);
  for (int kind = 1; kind < 6; ++kind) {
    record(spoilt, C::kToHead, 3).byte(kind).byte(0).byte(7);
    record(spoilt, C::kCycles, 6);
  }
  all.push_back(spoilt.text());
  Input turned = begun(1, 2);
  for (int what = 0; what < 12; ++what) {
    record(turned, C::kDrive, what * 2 % 32);
    if (what == 1 || what == 11) turned.word(0x1000);
    record(turned, C::kCycles, 5);
    record(turned, C::kOperator, 0);
  }
  all.push_back(turned.text());
  Input said = begun(0, 0);
  for (int answer = 0; answer < 12; ++answer) {
    record(said, C::kFrame, answer);
    if (answer >= 10) said.word(0x123);
    said.byte(255).data({0x27, 0x10, 1});
    record(said, C::kCycles, 2);
  }
  record(said, C::kHang, 30);
  record(said, C::kToDrives, 5);
  record(said, C::kCycles, 3);
  record(said, C::kOperator, 30);
  all.push_back(said.text());
  return all;
}

}  // namespace headway::fuzz
