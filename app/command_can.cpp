// headway can dump: what travels on the robot's bus, in words.
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/can_bus_name.h"
#include "app/can_decoder.h"
#include "app/can_transport.h"
#include "app/candump_log.h"
#include "app/commands.h"
#include "app/finite_range.h"
#include "app/interrupts.h"
#include "app/report.h"
#include "app/standard_streams.h"
#include "hal/clock.h"
#include "hal/error.h"

namespace headway::app {

namespace {

struct DumpOptions {
  std::string bus, log;
  bool json = false, candump = false;
  std::optional<std::uint64_t> count;  ///< frames
  std::optional<double> seconds;       ///< of a bus
};

constexpr Duration kPause = std::chrono::milliseconds(5);  ///< between two looks at a bus

std::string hex_of(const hal::CanFrame& frame, std::string_view between) {
  return fmt::format("{:02X}", fmt::join(frame.data.begin(), frame.data.begin() + frame.dlc, between));
}

std::string id_of(const LoggedFrame& f) {
  return f.kind == LoggedFrame::Kind::kData || (f.kind == LoggedFrame::Kind::kRemote && f.frame.id <= 0x7FF)
             ? fmt::format("{:03X}", f.frame.id)
             : fmt::format("{:08X}", f.frame.id);
}

/// As candump -l has it: 044#2A366C2BBA.
std::string log_text_of(const LoggedFrame& f) {
  if (f.kind == LoggedFrame::Kind::kRemote) return fmt::format("{}#R{}", id_of(f), f.frame.dlc);
  if (f.kind == LoggedFrame::Kind::kError)
    return fmt::format("{:08X}#{}", f.frame.id | CandumpLog::kErrorFlag, hex_of(f.frame, ""));
  return fmt::format("{}#{}", id_of(f), hex_of(f.frame, ""));
}

/// What is not a data frame with an 11-bit identifier, in a word.
const char* kind_of(const LoggedFrame& f) {
  switch (f.kind) {
    case LoggedFrame::Kind::kExtended:
      return "29-bit identifier";
    case LoggedFrame::Kind::kRemote:
      return "remote request";
    case LoggedFrame::Kind::kError:
      return "error frame";
    case LoggedFrame::Kind::kData:
      break;
  }
  return nullptr;
}

/// "TPDO1 of node 0x11"; empty where CANopen knows no such identifier.
std::string text_of(const CanopenPlace& place) {
  return place.node == 0 ? std::string(place.function)
                         : fmt::format("{} of node {:#04x}", place.function, place.node);
}

std::string text_of(const DecodedFrame& decoded) {
  std::string text(decoded.name.empty() ? "unknown" : decoded.name);
  if (!decoded.canopen.function.empty()) text += fmt::format(" ({})", text_of(decoded.canopen));
  if (decoded.check) text += fmt::format(" [{}]", name_of(*decoded.check));
  if (!decoded.name.empty() && !decoded.declared) text += " [not as the contract declares]";
  for (const SignalValue& s : decoded.signals) {
    text += s.hex_digits > 0
                ? fmt::format("  {} 0x{:0{}X}", s.name, static_cast<std::uint64_t>(s.value), s.hex_digits)
                : fmt::format("  {} {:.13g}{}{}", s.name, s.value, s.unit.empty() ? "" : " ", s.unit);
    if (!s.meaning.empty()) text += fmt::format(" ({})", s.meaning);
  }
  return text;
}

Json json_of(const DecodedFrame& decoded) {
  Json json = Json::object();
  if (!decoded.canopen.function.empty()) json["function"] = decoded.canopen.function;
  if (decoded.canopen.node != 0) json["node"] = decoded.canopen.node;
  if (decoded.name.empty()) return json;
  json["name"] = decoded.name;
  if (decoded.check) json["check"] = name_of(*decoded.check);
  json["declared"] = decoded.declared;
  for (const SignalValue& s : decoded.signals) {
    Json& signal = json["signals"][std::string(s.name)];
    signal["value"] = s.value;
    if (!s.unit.empty()) signal["unit"] = s.unit;
    if (!s.meaning.empty()) signal["meaning"] = s.meaning;
  }
  return json;
}

/// One line for each frame.
class Printer {
 public:
  Printer(bool json, bool candump) : json_(json), candump_(candump) {}

  void print(const LoggedFrame& f) {
    const bool known = f.kind == LoggedFrame::Kind::kData;
    ++printed_;
    if (!known) ++strange_;
    const DecodedFrame decoded = known ? decoders_[f.bus].decode(f.frame) : DecodedFrame{};
    const std::string stamp = fmt::format("{}.{:06}", f.stamp / std::chrono::seconds(1),
                                          f.stamp % std::chrono::seconds(1) / std::chrono::microseconds(1));
    if (candump_) {
      fmt::print("({:0>17}) {} {}\n", stamp, f.bus, log_text_of(f));
      return;
    }
    if (!json_) {
      fmt::print("({:0>17})  {}  {}  [{}]  {:<23}  {}\n", stamp, f.bus, id_of(f), f.frame.dlc,
                 hex_of(f.frame, " "), known ? text_of(decoded) : kind_of(f));
      return;
    }
    Json line{{"stamp", std::chrono::duration<double>(f.stamp).count()},
              {"bus", f.bus},
              {"id", f.frame.id},
              {"length", f.frame.dlc},
              {"data", hex_of(f.frame, "")}};
    if (known)
      line.update(json_of(decoded));
    else
      line["kind"] = kind_of(f);
    fmt::print("{}\n", line.dump());
  }

  std::uint64_t printed() const { return printed_; }

  /// On stderr, so that it is in no pipe's way.
  void sum_up() const {
    DecodedCounts c;
    for (const auto& [bus, decoder] : decoders_) c += decoder.counts();
    say_error(
        "{} frames: {} unknown, {} not as declared, {} with a wrong CRC, {} repeated, {} out of "
        "sequence, {} lost by "
        "their counters, {} of other kinds\n",
        printed_, c.unknown, c.undeclared, c.wrong_crc, c.repeated, c.wrong_sequence, c.lost, strange_);
  }

 private:
  bool json_, candump_;
  std::map<std::string, CanDecoder> decoders_;  ///< of each bus: a log may hold several
  std::uint64_t printed_ = 0, strange_ = 0;
};

/// Passes over lines that are no frames, such as the last one of a log that was cut off, and tells of them at
/// the end. True when there was none.
bool dump_log(const DumpOptions& options, Printer& printer) {
  constexpr std::size_t kTold = 10;
  std::vector<std::string> told;
  std::uint64_t bad = 0;
  CandumpLog log(options.log, [&](const std::string& what) {
    ++bad;
    if (told.size() < kTold) told.push_back(what);
  });
  while (printer.printed() < options.count.value_or(UINT64_MAX)) {
    const auto frame = log.next();
    if (!frame && bad == 0 && printer.printed() == 0)
      throw InputError(fmt::format("{}: holds no frame, expected a log that candump -l wrote", options.log));
    if (!frame) break;
    printer.print(*frame);
  }
  if (bad == 0) return true;
  if (printer.printed() == 0) throw InputError(told.front());
  for (const std::string& what : told) say_error("{}\n", what);
  say_error("lines that are no frames, passed over: {}\n", bad);
  return false;
}

/// True unless its adapter went away and has not come back.
bool dump_bus(const DumpOptions& options, Printer& printer) {
  const Interrupts interrupts;
  std::signal(SIGPIPE, SIG_DFL);  // a reader that leaves ends it, as any filter
  hal::MonotonicClock clock;
  const CanTransport transport = open_can_transport(options.bus, clock);
  const std::string name = options.bus.substr(options.bus.find(':') + 1);
  const std::uint64_t most = options.count.value_or(UINT64_MAX);
  const std::optional<Time> end =
      options.seconds ? std::optional(clock.now() + seconds(*options.seconds)) : std::nullopt;
  hal::CanBusState told = hal::CanBusState::kErrorActive;
  while (printer.printed() < most && (!end || clock.now() < *end) && !interrupts.asked()) {
    std::array<hal::CanFrame, 64> frames;
    const std::size_t room = std::min<std::uint64_t>(frames.size(), most - printer.printed());
    const std::size_t received = transport.bus->receive(std::span(frames).first(room));
    for (const hal::CanFrame& frame : std::span(frames).first(received))
      printer.print({LoggedFrame::Kind::kData, name, frame.stamp.time_since_epoch(), frame});
    if (transport.bus->state() != told) {
      told = transport.bus->state();
      say_error("{}: {}\n", options.bus, hal::text_of(told));
    }
    if (received == room) continue;
    flush_output();
    transport.serve ? transport.serve(kPause) : clock.sleep_until(clock.now() + kPause);
  }
  const hal::CanBusStats stats = transport.bus->stats();
  say_error("{}: {} received, {} lost by the receiver, {} unusable, off the bus {} times, gone {} times\n",
            options.bus, stats.received, stats.lost, stats.unusable, stats.bus_off, stats.gone);
  return transport.bus->state() != hal::CanBusState::kGone;
}

int dump(const DumpOptions& options) {
  if (options.bus.empty() == options.log.empty())
    throw InputError(fmt::format("can dump: expected either --bus ({}) or --log FILE", can_transports()));
  if (options.seconds && !options.log.empty())
    throw InputError("can dump: --seconds is for a bus; a log ends by itself, or after --count frames");
  Printer printer(options.json, options.candump);
  const bool whole = options.log.empty() ? dump_bus(options, printer) : dump_log(options, printer);
  printer.sum_up();
  return whole ? kSuccess : kNotReached;
}

}  // namespace

void add_can(CLI::App& app, Run& run) {
  auto options = std::make_shared<DumpOptions>();
  CLI::App* can = app.add_subcommand("can", "Shows what travels on the robot's CAN bus.");
  can->require_subcommand(1);
  CLI::App* command = can->add_subcommand("dump", "Prints each frame with its name and values.");
  command->footer(
      "One line for each frame, as candump prints it, then its name in the contract (docs/bus.md), its "
      "function and\n"
      "node in CANopen, what counter and CRC say of it, and its values with units or names.\n"
      "  headway can dump --bus socketcan:can0 --seconds 10\n"
      "  headway can dump --log walk.log --json\n"
      "  headway can dump --bus socketcan:can0 --candump > walk.log\n"
      "Without --count and --seconds a bus is shown until Ctrl-C. It only listens, but an slcan adapter is "
      "told to go\n"
      "on the bus at 500 kbit/s. How many frames may not be used is told at the end, on stderr. Lines of a "
      "log "
      "that\n"
      "are no frames are told there and passed over; then the exit code is 1, and 2 where there is no frame "
      "at "
      "all. It is 1 as well where the bus's adapter is gone at the end.");
  command->add_option("--bus", options->bus, fmt::format("The bus: {}", can_transports()))
      ->check(can_bus_name())
      ->type_name("TRANSPORT");
  command->add_option("--log", options->log, "A log that candump -l wrote, in place of a bus")
      ->type_name("FILE");
  command->add_option("--count", options->count, "Ends after so many frames")
      ->check(seed_number())
      ->type_name("N");
  command->add_option("--seconds", options->seconds, "Ends after so long")
      ->check(finite_in(0.001, 1e6))
      ->type_name("S");
  CLI::Option* json = command->add_flag("--json", options->json, "One JSON object for each frame");
  command
      ->add_flag("--candump", options->candump,
                 "Lines as candump -l writes them and --log reads them, without a meaning; seconds since the "
                 "machine's start, where candump has the time of day")
      ->excludes(json);
  command->callback([options, &run] { run = [options] { return dump(*options); }; });
}

}  // namespace headway::app
