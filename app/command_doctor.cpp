#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/can_bus_name.h"
#include "app/can_transport.h"
#include "app/commands.h"
#include "app/doctor.h"
#include "app/examine_can_links.h"
#include "app/examine_usb.h"
#include "app/examine_wires.h"
#include "app/hardware.h"
#include "app/interrupts.h"
#include "app/slower_option.h"
#include "drivers/can_links.h"
#include "drivers/can_socket_calls.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "nav/whole_file.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path robot, json;
  std::string bus, left, right;
  double slower = 1;
};

constexpr Duration kListen = seconds(4);
constexpr Duration kLook = seconds(3);

constexpr std::string_view kSocketCan = "socketcan:";

bool kernel_has_can() {
  drivers::CanSocketCalls& calls = drivers::kernel_can_socket_calls();
  const int socket = calls.socket();
  if (socket < 0) return errno != EAFNOSUPPORT && errno != EPROTONOSUPPORT;
  calls.close(socket);
  return true;
}

void look_at_can_links(const std::string& bus, Diagnosis& diagnosis) {
  diagnosis.about("can");
  const bool is_the_kernels = bus.starts_with(kSocketCan);
  const std::string interface = is_the_kernels ? bus.substr(kSocketCan.size()) : "";
  try {
    examine_can_links(drivers::list_can_links(), interface, diagnosis, kernel_has_can());
  } catch (const Error& fault) {
    diagnosis.warn("interfaces", "not listed", fault.what());
  }
  if (is_the_kernels) examine_usb_adapter("/", interface, diagnosis);
}

void look_at_bus(const Robot& robot, const std::string& name, hal::Clock& clock, const Interrupts& interrupts,
                 Diagnosis& diagnosis) {
  diagnosis.about("bus");
  if (name.empty()) {
    diagnosis.fail("bus", "none is named", "hardware: bus: in the robot file, or --bus");
    return;
  }
  try {
    const CanTransport wire = open_can_transport(name, clock);
    const auto adapter = serve(wire);
    diagnosis.ok("opened", name);
    if (!wire.adapter.empty()) diagnosis.ok("adapter", wire.adapter);
    examine_bus(
        robot, *wire.bus, clock, kListen, diagnosis, [&] { return interrupts.asked(); }, wire.tells_state);
  } catch (const Error& fault) {
    diagnosis.fail("bus", name + " cannot be opened", fault.what());
  }
}

void look_at_cameras(const Robot& robot, const HardwareConfig& hardware, hal::Clock& clock,
                     const Interrupts& interrupts, Diagnosis& diagnosis) {
  diagnosis.about("eyes");
  if (hardware.left.empty() || hardware.right.empty()) {
    diagnosis.fail(
        "cameras",
        hardware.left.empty() && hardware.right.empty() ? "none are named"
        : hardware.left.empty()                         ? "the left one is not named"
                                                        : "the right one is not named",
        "hardware: cameras: left and right in the robot file, or --left and --right; 'headway camera list'");
    return;
  }
  try {
    const drivers::StereoPairConfig pair = camera_pair(hardware, robot.rig);
    examine_usb_cameras("/", pair, diagnosis);
    diagnosis.about("eyes");
    const CameraLook look =
        look_through(pair, kLook, clock, drivers::kernel_calls(), [&] { return interrupts.asked(); });
    if (interrupts.asked()) return;
    examine_cameras(look, hardware, diagnosis);
    examine_exposures(look.eyes, drivers::kernel_calls(), diagnosis);
  } catch (const Error& fault) {
    diagnosis.fail("cameras", "cannot be opened", fault.what());
  }
}

/// The file for other programs: a verdict of this time, or why there is none.
class VerdictFile {
 public:
  /// From now on an earlier verdict must not be taken for this time's. Throws InputError where the file is
  /// none of the doctor's, such as the robot file.
  explicit VerdictFile(std::filesystem::path file) : file_(std::move(file)) {
    if (file_.empty() || nav::is_stream(file_)) return;
    require_own();
    say_why_not("the doctor has not come to its end");
  }

  void write(const Diagnosis& diagnosis) const {
    if (!file_.empty()) write_json(file_, diagnosis.json());
  }
  void say_why_not(const std::string& error) const {
    if (!file_.empty())
      write_json(file_, {{"verdict", "fail"}, {"findings", Json::array()}, {"error", error}});
  }

 private:
  void require_own() const {
    std::error_code none;
    if (!std::filesystem::exists(file_, none) || std::filesystem::is_empty(file_, none)) return;
    std::ifstream in(file_, std::ios::binary);
    const Json former = Json::parse(in, nullptr, false);
    if (!former.is_object() || !former.contains("verdict") || !former.contains("findings"))
      throw InputError(
          fmt::format("--json: {}: is of something else, expected nothing there, or what an earlier 'headway "
                      "doctor' wrote",
                      file_.string()));
  }

  std::filesystem::path file_;
};

Diagnosis examine(const Options& options) {
  const Robot robot = read_robot(options.robot);
  HardwareConfig hardware = robot.hardware;
  if (!options.bus.empty()) hardware.bus = options.bus;
  if (!options.left.empty()) hardware.left = options.left;
  if (!options.right.empty()) hardware.right = options.right;
  require_simulated(options.slower, hardware.bus);
  hal::ScaledClock clock(options.slower);
  Diagnosis diagnosis;
  const Interrupts interrupts;
  std::size_t told = 0;
  const auto tell = [&] {
    // Where nobody reads it, that is told at the end: the verdict for other programs comes before.
    std::fputs(diagnosis.text(std::exchange(told, diagnosis.findings().size())).c_str(), stdout);
    std::fflush(stdout);
  };
  examine_machine(MachineFacts::of_this_machine(), robot.loops.real_time, diagnosis);
  examine_head_limits(robot.mission.head, diagnosis);
  look_at_can_links(hardware.bus, diagnosis);
  tell();
  look_at_bus(robot, hardware.bus, clock, interrupts, diagnosis);
  tell();
  if (!interrupts.asked()) look_at_cameras(robot, hardware, clock, interrupts, diagnosis);
  if (interrupts.asked()) {
    diagnosis.about("doctor");
    diagnosis.fail("interrupted", "not all was looked at; the head holds where it is", "run it again");
  }
  tell();
  return diagnosis;
}

int run(const Options& options) {
  const VerdictFile file(options.json);
  Diagnosis diagnosis;
  try {
    diagnosis = examine(options);
  } catch (const std::exception& fault) {
    file.say_why_not(fault.what());
    throw;
  }
  file.write(diagnosis);
  return diagnosis.worst() == Verdict::kFail ? kNotReached : kSuccess;
}

}  // namespace

void add_doctor(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("doctor",
                                         "Look at machine, bus, head, control computer and cameras: what is "
                                         "well, and what to do about the rest");
  command->add_option("robot", options->robot, "Robot file, e.g. config/hrp2/robot.yaml")->required();
  command->add_option("--bus", options->bus, "The CAN bus, like " + can_transports())->check(can_bus_name());
  command->add_option("--left", options->left, "Left camera, in place of the robot file's");
  command->add_option("--right", options->right, "Right camera, in place of the robot file's");
  command->add_option("--json", options->json,
                      "Also write the findings into this file (/dev/stdout: below them)");
  add_slower_option(*command, options->slower);
  command->footer(
      "The head's drives are switched on and hold where they are; nothing walks. Not beside 'headway run'.\n"
      "A line for each finding: ok, warn or fail, with what to do below it. Exit code 0 unless something "
      "failed.\nCtrl-C ends it in order, with what was found so far and exit code 1.\nThe file of --json "
      "holds "
      "\"error\" where the doctor came to no verdict of its own.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
