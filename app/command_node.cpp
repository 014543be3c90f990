#include <array>
#include <filesystem>
#include <memory>
#include <numbers>
#include <system_error>

#include <fmt/format.h>

#include "app/can_bus_name.h"
#include "app/can_transport.h"
#include "app/commands.h"
#include "app/finite_range.h"
#include "app/interrupts.h"
#include "app/node_pictures.h"
#include "app/node_session.h"
#include "app/other_master.h"
#include "app/world_map.h"
#include "hal/clock.h"
#include "hal/error.h"

namespace headway::app {

namespace {

struct Options {
  std::filesystem::path robot = default_robot_file(), world, left, right;
  std::string bus;
  std::uint64_t seed = 0;
  double slower = 1, camera_delay = 20;
};

/// All that one bus has received goes out on the other.
void carry(hal::CanBus& from, hal::CanBus& to) {
  std::array<hal::CanFrame, 32> frames;
  while (const std::size_t count = from.receive(frames))
    for (std::size_t i = 0; i < count; ++i) to.send(frames[i]);
}

/// Two names of one place, be there something yet or not.
bool are_one(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code none;
  const auto place = [&](const auto& name) { return weakly_canonical(absolute(name), none); };
  return place(a) == place(b);
}

int run(const Options& options) {
  const Robot robot = read_robot(options.robot);
  const sim::World world = read_world_for(robot, options.world);
  if (options.left.empty() != options.right.empty())
    throw InputError("node: --left or --right is missing, expected both or neither");
  if (!options.left.empty() && are_one(options.left, options.right))
    throw InputError(fmt::format("node: --right: '{}' is the left eye as well, expected a pipe for each",
                                 options.right.string()));
  hal::ScaledClock clock(options.slower);
  const CanTransport wire = open_can_transport(options.bus, clock);
  const auto adapter = serve(wire);
  refuse_other_robot(*wire.bus, clock);
  SimulatedRobotOptions simulated;
  simulated.seed = options.seed ? options.seed : world.seed;
  NodeSession node(robot, world, simulated, false, clock.now());
  std::unique_ptr<NodePictures> pictures;
  if (!options.left.empty()) {
    sim::StereoCameraModel model = simulated_pair(robot.rig, simulated.seed);
    model.transfer = seconds(options.camera_delay / 1000);
    pictures = std::make_unique<NodePictures>(world, model, options.left, options.right, clock);
    node.on_exposure([&](Time at, const Eigen::Isometry3d& map_from_left, const sim::WorldState& state) {
      pictures->expose({at, map_from_left, state});
    });
  }
  const Interrupts interrupts;
  fmt::print("{} in {}, on {}{}\n", robot.name, world.name, options.bus,
             options.slower == 1 ? "" : fmt::format(", {:g} times slower than real", options.slower));
  std::fflush(stdout);
  bool fallen = false;
  while (!interrupts.asked() && !fallen && !node.body().collision()) {
    carry(*wire.bus, node.bus());
    node.catch_up(clock.now());
    carry(node.bus(), *wire.bus);
    if (pictures && pictures->failed()) throw Error("pictures: " + pictures->failure());
    fallen = node.body().fallen();
    clock.sleep_until(clock.now() + seconds(0.001));
  }
  const Pose2 base = node.body().stance().base();
  fmt::print("stands at ({:.2f}, {:.2f}), {:.0f} deg; walked {:.2f} m; {} pairs of pictures handed over\n",
             base.x, base.y, base.yaw * 180 / std::numbers::pi, node.body().path_walked(),
             pictures ? pictures->written() : 0);
  if (const std::uint64_t refused = wire.bus->stats().refused; refused > 0)
    fmt::print("{} frames found no room on the bus\n", refused);
  if (const auto& hit = node.body().collision()) fmt::print("the {} touched {}\n", hit->part, hit->object);
  if (fallen) fmt::print("it fell\n");
  return fallen || node.body().collision() ? kNotReached : kSuccess;
}

}  // namespace

void add_node(CLI::App& app, Run& run_command) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "node",
      "The simulated robot behind real wires: head drives and control computer on a CAN bus, pictures "
      "into named pipes; 'headway run' guides it from another process (scripts/wires makes bus and cameras)");
  command->add_option("robot", options->robot, "Robot file")->required();
  command->add_option("--world", options->world, "World file, e.g. config/worlds/lab.yaml")->required();
  command->add_option("--bus", options->bus, "The CAN bus, like " + can_transports())
      ->required()
      ->check(can_bus_name());
  command->add_option(
      "--left", options->left,
      "Named pipe for the left camera's raw grey frames; made if need be, and then removed at the end");
  command->add_option("--right", options->right, "And for the right one's");
  command
      ->add_option("--camera-delay", options->camera_delay,
                   "From the exposure to when a picture is handed over [ms]; 'run' needs to know it "
                   "(neck: camera_time_offset_ms in its robot file)")
      ->check(finite_in(0, 100))
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Seed of all noise; 0: the world's")
      ->check(seed_number())
      ->capture_default_str();
  command
      ->add_option("--slower", options->slower,
                   "So many times slower than real, for machines that are too slow; 'run' needs the same")
      ->check(finite_in(0.1, 1000))
      ->capture_default_str();
  command->footer(
      "Example: headway node config/hrp2/robot.yaml --world config/worlds/lab.yaml --bus socketcan:vcan0\n"
      "Ends with Ctrl-C, a fall or a collision; exit code 1 for the latter two.");
  command->callback([options, &run_command] { run_command = [options] { return run(*options); }; });
}

}  // namespace headway::app
