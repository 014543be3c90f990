#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "app/can_bus_name.h"
#include "app/can_transport.h"
#include "app/commands.h"
#include "app/end_at_once.h"
#include "app/finite_range.h"
#include "app/frames_report.h"
#include "app/hardware.h"
#include "app/interrupts.h"
#include "app/live_control.h"
#include "app/live_session.h"
#include "app/local_socket.h"
#include "app/operator_page.h"
#include "app/other_master.h"
#include "app/output_folder.h"
#include "app/recording_folder.h"
#include "app/run_recorder.h"
#include "app/safety_report.h"
#include "app/service_manager.h"
#include "app/slower_option.h"
#include "hal/clock.h"
#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "runtime/durable_file.h"
#include "runtime/real_time.h"
#include "runtime/second_processor.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path robot, out, record;
  std::string bus, left, right, socket, black_box;
  std::vector<double> goal, floor{20, 20};
  ServeOptions page;
  double slower = 1;
};

/// The goal as seen from where the robot stands.
nav::Goal goal_from(const Pose2& start, const std::vector<double>& numbers) {
  nav::Goal goal;
  goal.position = start * Eigen::Vector2d(numbers[0], numbers[1]);
  if (numbers.size() == 3) goal.yaw = wrap_angle(start.yaw + numbers[2] * std::numbers::pi / 180);
  return goal;
}

LiveOptions live_options(const Options& options, const HardwareConfig& hardware, hal::CanBus& bus,
                         hal::Clock& clock) {
  const auto stands = hear_where_it_stands(bus, clock, seconds(5));
  if (!stands)
    throw Error(
        fmt::format("{}: the control computer does not say where the robot stands (CTL_ChestXY, "
                    "CTL_ChestZRot); start its program, and see 'headway doctor'",
                    hardware.bus));
  LiveOptions live;
  live.start = *stands;
  live.floor = {options.floor[0], options.floor[1]};
  if (!options.goal.empty()) live.goal = goal_from(*stands, options.goal);
  live.frame_rate = hardware.rate;
  return live;
}

/// Says what has changed, a line each, and every ten seconds where the robot is; the newest to the service
/// manager too.
class Log {
 public:
  Log(const hal::Clock& clock, const ServiceManager& service)
      : clock_(clock), service_(service), begin_(clock.now()) {}

  void see(const LiveStatus& status) {
    if (status.level != level_) say("frames: {}", name(status.level));
    level_ = status.level;
    const auto now = std::tuple(status.state, status.head, status.walker);
    if (said_ && now == known_ && status.stamp - said_at_ < kQuiet) return;
    const std::string reason = status.reason.data();
    say("{}{}{}; at ({:.2f}, {:.2f}); head {}, control computer {}", name(status.state),
        reason.empty() ? "" : ": ", reason, status.base.x, status.base.y, text_of(status.head),
        text_of(status.walker));
    known_ = now;
    said_ = true;
    said_at_ = status.stamp;
  }
  void see(const runtime::SafetyReport& safety) {
    say("safety: {}: {}", name(safety.state), describe(safety));
  }

  /// How the bus loop keeps time.
  void see(runtime::CycleHealth health, std::uint64_t missed) {
    if (health == health_) return;
    health_ = health;
    say("the bus loop is {}: {} cycles missed so far{}", name(health), missed,
        health == runtime::CycleHealth::kFailing ? "; the robot comes to rest"
        : health == runtime::CycleHealth::kLate  ? "; no walk begins until fewer are"
                                                 : "");
  }

  template <class... Values>
  void say(fmt::format_string<Values...> text, Values&&... values) {
    const std::string line = fmt::format(text, std::forward<Values>(values)...);
    if (takes_a_line()) {
      if (unsaid_ > 0)
        std::printf("            (%d lines that nobody took were left out)\n", std::exchange(unsaid_, 0));
      std::printf("%8.2f s  %s\n", to_seconds(clock_.now() - begin_), line.c_str());
      std::fflush(stdout);
    } else {
      ++unsaid_;
    }
    service_.status(line);
  }

 private:
  static constexpr Duration kQuiet = seconds(10);

  /// A terminal that is held or gone, or a pipe that nobody drains, must not keep the robot from being told.
  static bool takes_a_line() {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    return ::poll(&output, 1, 0) == 1 && (output.revents & POLLOUT) != 0;
  }

  const hal::Clock& clock_;
  const ServiceManager& service_;
  Time begin_, said_at_{};
  bool said_ = false;
  int unsaid_ = 0;
  runtime::FrameLevel level_ = runtime::FrameLevel::kFull;
  std::tuple<runtime::MissionState, hal::HeadHealth, hal::WalkerHealth> known_;
  runtime::CycleHealth health_ = runtime::CycleHealth::kOnTime;
};

/// Our clock less the control computer's; nothing where that is not known.
Json clock_of(const hal::Walker& walker) {
  const auto clock = walker.clock();
  if (!clock) return nullptr;
  return {{"offset_s", to_seconds(clock->offset)}, {"uncertainty_s", to_seconds(clock->uncertainty)}};
}

/// In microseconds: what a loop's times are.
void add_spread(Json& json, const std::string& what, const runtime::Spread& spread) {
  const auto us = [](Duration d) { return rounded(1e6 * to_seconds(d), 1); };
  json[what + "_p50_us"] = us(spread.p50);
  json[what + "_p99_us"] = us(spread.p99);
  json[what + "_p999_us"] = us(spread.p999);
  json[what + "_max_us"] = us(spread.max);
}

Json bus_loop_of(const LiveSession& session) {
  const runtime::BusLoopCounters& bus = session.bus_loop().counters();
  const runtime::LoopFigures times = session.loops().figures();
  Json json = {{"cycles", bus.cycles},
               {"missed", times.missed},
               {"plans_taken", bus.plans_taken},
               {"plans_late", bus.plans_late},
               {"walks_ended_early", bus.stops},
               {"major_faults", times.bus_faults.major},
               {"minor_faults", times.bus_faults.minor}};
  add_spread(json, "wake", times.bus_wake_up);
  add_spread(json, "run", times.bus_run);
  return json;
}

Json frames_of(const LiveSession& session) {
  Json json = frames_json(session.frame_loop().counters());
  add_spread(json, "run", session.loops().figures().frame_run);
  return json;
}

Json report_of(const Options& options, const Robot& robot, const LiveSession& session,
               const CanTransport& wire, bool rests) {
  const runtime::MissionCounters& mission = session.mission().counters();
  const hal::CanBusStats can = wire.bus->stats();
  return {{"robot", robot.name},
          {"bus", options.bus},
          {"end", name(session.mission().state())},
          {"reason", session.mission().reason()},
          {"stands", rests},
          {"frames", frames_of(session)},
          {"plans", mission.plans},
          {"replans", mission.replans},
          {"bus_loop", bus_loop_of(session)},
          {"safety", safety_json(session.bus_loop().safety())},
          {"control_clock", clock_of(session.walker())},
          {"can",
           {{"sent", can.sent},
            {"received", can.received},
            {"refused", can.refused},
            {"lost", can.lost},
            {"unusable", can.unusable},
            {"bus_off", can.bus_off},
            {"gone", can.gone}}}};
}

void write_map(const LiveSession& session, OutputFolder& folder) {
  const nav::ColdMap known = session.mapper().everything();
  runtime::write_durably(folder.file("map.hmap"), [&](std::ostream& out) {
    nav::write_map_file(known, session.frame_loop().localisation().surfaces(), out);
  });
  write_floor(session.mapper().floor(), folder);
}

/// Where others of this machine may ask how the robot is. Throws as LocalServer where a place was named.
std::unique_ptr<LocalServer> listen(const Options& options, Log& log) {
  const bool named = !options.socket.empty();
  const std::filesystem::path path = named ? std::filesystem::path(options.socket) : own_socket();
  try {
    if (!path.empty()) return std::make_unique<LocalServer>(path);
    log.say("'headway status' and 'headway go' cannot reach it: XDG_RUNTIME_DIR is not set; see --socket");
  } catch (const Error& fault) {
    if (named) throw;
    log.say("'headway status' and 'headway go' cannot reach it: {}", fault.what());
  }
  return nullptr;
}

/// What the page shows beside the status.
OperatorPage::Beside beside(const LiveSession& session, const LiveStatus& status, Time now) {
  const runtime::LoopFigures figures = session.loops().figures();
  OperatorPage::Beside out;
  out.bus_cycles = figures.bus_wake_up.count;
  out.bus_missed = figures.missed;
  out.bus_wake_max = figures.bus_wake_up.max;
  out.metrics = status_metrics(status_json(session, status, now));
  return out;
}

/// The loops hear no master's frames: this needs all of them. Gives the bus back.
void listen_before(const std::string& bus, hal::Clock& clock) {
  const CanTransport wire = open_can_transport(bus, clock);
  const auto adapter = serve(wire);
  refuse_other_master(*wire.bus, clock);
}

int run(Options options) {
  const Robot robot = read_robot(options.robot);
  HardwareConfig hardware = robot.hardware;
  if (!options.bus.empty()) hardware.bus = options.bus;
  if (!options.left.empty()) hardware.left = options.left;
  if (!options.right.empty()) hardware.right = options.right;
  require_complete(hardware);
  options.bus = hardware.bus;
  require_simulated(options.slower, options.bus);
  std::optional<OutputFolder> out;
  if (!options.out.empty())
    out.emplace(options.out, "run",
                std::initializer_list<const char*>{"map.hmap", "floor.pgm", "floor.yaml"});
  const std::string memory_refusal = runtime::lock_memory(robot.loops.real_time);
  // What the session needs until it has come to rest is made before it.
  Interrupts interrupts(hang_up_of_a_service());
  hal::ScaledClock clock(options.slower);
  listen_before(hardware.bus, clock);
  const CanTransport wire = open_can_transport(hardware.bus, clock, identifiers_of_the_loops());
  const auto adapter = serve(wire, robot.loops.real_time);
  const auto camera = open_cameras(hardware, robot.rig, clock);
  LiveOptions live = live_options(options, hardware, *wire.bus, clock);
  RunRecorder recorder({options.record, options.black_box, options.page.serve}, robot, live, clock);
  live.recorder = recorder.get();
  Taps taps(live.recorder);
  runtime::SecondProcessor second;
  runtime::StereoEyes eyes(taps.camera(*camera), robot.rig, robot.vision, second);
  std::optional<OperatorPage> page;  // shown frames until the session has ended
  LiveSession session(robot, live, *wire.bus, eyes, clock);
  ServiceManager service;
  Log log(clock, service);
  const auto listener = listen(options, log);
  if (options.page.serve) {
    page.emplace(options.page, session.robot(), session.floor_grid(), live.start, session.line(), clock);
    page->offer_recording(*recorder.get(), recording_folder(options.record));
    session.observe([&page](const runtime::FrameSnapshot& snapshot) { page->see(snapshot); });
    log.say("the operator's page: {}", page->address());
  }
  if (options.slower != 1) log.say("the clock runs {:g} times slower than real", options.slower);
  recorder.start();
  session.start();
  for (const std::string& refusal :
       {memory_refusal, adapter ? adapter->refusal() : std::string(), session.refusal()})
    if (!refusal.empty()) log.say("{}", refusal);
  service.ready();
  LiveStatus status;
  std::optional<std::string> failure, hanging;
  bool over = false;
  while (!over && !interrupts.asked() && !failure) {
    if (session.look(status)) log.see(status);
    for (runtime::SafetyChange change; session.look(change);) log.see(change.safety);
    log.see(session.loops().bus_health(), session.loops().bus_missed());
    recorder.tell([&](const std::string& news) { log.say("{}", news); });
    // Who gave the goal at the start waits for its end; else more may come.
    over = !options.goal.empty() && (status.state == runtime::MissionState::kArrived ||
                                     status.state == runtime::MissionState::kStopped);
    if (listener)
      listener->serve([&](std::string_view line) { return answer(line, session, status, clock.now()); });
    if (page) page->serve(status, beside(session, status, clock.now()), clock.now());
    if (interrupts.asked_to_reload())
      log.say(
          "SIGHUP: its files are read at the start only, for a robot must not change under way; restart it");
    failure = session.failure();
    const bool hung = hanging.has_value();
    hanging = session.hanging(clock.now());
    if (hanging && !hung) log.say("{}", *hanging);
    if (hanging && !hung) recorder.fault(*hanging);
    if (!hanging) service.alive(hal::MonotonicClock().now());
    if (adapter && adapter->ended()) failure = "the CAN adapter: " + adapter->failure();
    clock.sleep_until(clock.now() + seconds(0.02));
  }
  service.stopping();
  if (interrupts.asked()) log.say("asked to end: comes to rest");
  if (failure) recorder.fault(*failure);
  const bool rests = session.stop();
  for (runtime::SafetyChange change; session.look(change);) log.see(change.safety);
  recorder.stop();
  recorder.tell([&](const std::string& news) { log.say("{}", news); });
  if (failure) log.say("a loop broke: {}", *failure);
  log.say("{}", rests ? "stands"
                      : "it is not known whether the robot stands: the control computer does not say so");
  if (const std::string loop = session.left_hanging(); !loop.empty())
    end_at_once(
        fmt::format("the {} loop hangs, and was not waited for; neither map nor report were written", loop));
  if (out) {
    write_map(session, *out);
    out->report(report_of(options, robot, session, wire, rests));
    fmt::print("{}\n", out->list());
  }
  if (failure) throw Error(*failure);
  if (options.goal.empty() && interrupts.asked() && rests) return kSuccess;
  return session.mission().state() == runtime::MissionState::kArrived ? kSuccess : kNotReached;
}

}  // namespace

void add_run(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "run",
      "Guide the robot: the whole program on its cameras and its CAN bus, as the robot file's hardware says");
  command->add_option("robot", options->robot, "Robot file, e.g. config/hrp2/robot.yaml")->required();
  command
      ->add_option(
          "--goal", options->goal,
          "Where to go [m, deg], as seen from where the robot stands: ahead, to the left, turned to the left")
      ->delimiter(',')
      ->expected(2, 3)
      ->option_text("X,Y[,YAW]")
      ->check(finite_in(-500, 500));
  command->add_option("--floor", options->floor, "Size of the floor in use, around the start [m]")
      ->delimiter(',')
      ->expected(2)
      ->option_text("X,Y")
      ->check(finite_in(1, 200));
  command->add_option("--bus", options->bus, "The CAN bus, like " + can_transports())->check(can_bus_name());
  command->add_option("--left", options->left, "Left camera, in place of the robot file's");
  command->add_option("--right", options->right, "Right camera, in place of the robot file's");
  command->add_option("--out", options->out, kOutHelp);
  command->add_option("--socket", options->socket,
                      "Where it listens to 'headway status', 'go' and 'stay', in place of the usual place");
  command->add_option(
      "--record", options->record,
      "Folder for a recording (.mcap) of all that happens, for 'headway replay'. With --serve "
      "the page begins and ends recordings too, without it with the user's state");
  command->add_option(
      "--black-box", options->black_box,
      "Folder for what was recorded of the half minute before a fault, or 'off'; default: the "
      "robot file's");
  add_serve_options(*command, options->page);
  add_slower_option(*command, options->slower);
  command->footer(
      "Example: headway run robot.yaml --bus socketcan:can0 --goal 2,0.5 --out build/walk\n"
      "Without a goal it looks around and waits for 'headway go'. Ctrl-C brings the robot to rest, and then "
      "ends.\n"
      "Exit code 0 when the robot arrived, or was ended at rest without a goal from the command line.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
