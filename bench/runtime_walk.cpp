#include "bench/runtime_walk.h"

#include <utility>

#include <fmt/format.h>

#include "app/loop_configs.h"
#include "app/simulated_robot.h"
#include "app/world_map.h"
#include "bench/cpu_time.h"
#include "drivers/can_walker.h"
#include "drivers/cia402_head.h"
#include "hal/error.h"
#include "runtime/bus_loop.h"
#include "sim_hal/robot.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"
#include "vision/rig_files.h"

namespace headway::bench {

namespace {

constexpr double kFrameRate = 15;
constexpr Duration kLongest = seconds(300);

app::Robot robot_in(const sim::World& world) {
  app::Robot robot = app::read_robot(source_dir() / "config/hrp2/robot.yaml");
  robot.rig = vision::read_rig(source_dir() / "config/hrp2/rigs/bottom_640.yaml");
  robot.simulation.frame_rate = kFrameRate;
  robot.mapper.voxels.resolution = 0.02;
  robot.mapper.voxels = app::map_box(robot, world);
  robot.mapper.voxels.validate();
  return robot;
}

/// Keeps the frame that was taken last.
class KeptCamera final : public hal::StereoCamera {
 public:
  explicit KeptCamera(hal::StereoCamera& camera) : camera_(camera) {}
  bool take_newest(hal::StereoFrame& into) override {
    if (!camera_.take_newest(into)) return false;
    last = into;
    return true;
  }
  hal::StereoFrame last;

 private:
  hal::StereoCamera& camera_;
};

/// Robot, bus and both loops in lockstep, as in the simulation.
class Recorder {
 public:
  Recorder(RecordedWalk& walk, const sim::World& world)
      : walk_(walk),
        scene_(world),
        body_(app::simulated_robot(walk.robot, {}), world.start),
        rendered_(scene_, clock_, app::simulated_pair(walk.robot.rig, 1)),
        camera_(rendered_),
        head_(body_.bus(), app::head_config(walk.robot)),
        walker_(body_.bus()),
        links_(std::make_unique<runtime::Links>()),
        bus_loop_(app::bus_config(walk.robot, world.start), body_.bus(), head_, walker_, *links_),
        side_(walk.robot, world.start, camera_, walk.frame_rate) {
    body_.on_exposure([this](Time t, const Eigen::Isometry3d& pose) { rendered_.expose(t, pose); });
  }

  /// Until it has arrived, or is so near to the goal [m] that it may as well be given the next one as it
  /// walks.
  void walk_to(const nav::Goal& goal, double near) {
    side_.mission.set_goal(goal);
    const Time end = clock_.now() + kLongest;
    do {
      step();
      if (clock_.now() > end || side_.mission.state() == runtime::MissionState::kStopped)
        throw Error(fmt::format("the recorded walk did not come to its end: {} {}",
                                name(side_.mission.state()), side_.mission.reason()));
    } while (side_.mission.state() != runtime::MissionState::kArrived &&
             (body_.stance().base().position() - goal.position).norm() > near);
  }

 private:
  void step() {
    clock_.advance(sim::SimRobot::kPeriod);
    const Time now = clock_.now();
    scene_.advance(now, body_.stance().base());
    body_.step(now);
    bus_loop_.cycle(now);
    pass_on();
    if (busy_until_ && now >= *busy_until_) {
      side_.frames.publish();
      side_.links->order.update();
      links_->order.publish(side_.links->order.value());
      busy_until_.reset();
    }
    side_.frames.fix_level(runtime::FrameLevel::kFull);
    if (!busy_until_ && side_.frames.work(now)) {
      given_.now = now;
      given_.frame = camera_.last;
      given_.then = side_.mission.state();
      walk_.frames.push_back(std::exchange(given_, {}));
      busy_until_ = now + walk_.robot.simulation.charge.total();
    }
  }

  /// From the bus loop to the frame loop, and into the record.
  void pass_on() {
    for (hal::ChestSample sample; links_->chest.pop(sample); side_.links->chest.push(sample))
      given_.chest.push_back(sample);
    for (runtime::HeadSample sample; links_->head.pop(sample); side_.links->head.push(sample))
      given_.head.push_back(sample);
    links_->report.update();
    given_.report = links_->report.value();
    side_.links->report.publish(given_.report);
  }

  RecordedWalk& walk_;
  hal::ManualClock clock_;
  sim::Scene scene_;
  sim::SimRobot body_;
  sim::SimStereoCamera rendered_;
  KeptCamera camera_;
  drivers::Cia402Head head_;
  drivers::CanWalker walker_;
  std::unique_ptr<runtime::Links>
      links_;  ///< of the bus loop; what passes on to the frame loop's is recorded
  runtime::BusLoop bus_loop_;
  FrameSide side_;
  Given given_;
  std::optional<Time> busy_until_;
};

}  // namespace

FrameSide::FrameSide(const app::Robot& robot, const Pose2& start, hal::StereoCamera& camera,
                     double frame_rate)
    : eyes(camera, robot.rig, robot.vision, second),
      links(std::make_unique<runtime::Links>()),
      mapper(robot.mapper, start),
      mission(robot.mission, mapper.floor().grid),
      frames(app::frame_config(robot, frame_rate), eyes, mapper, mission, *links, stopwatch) {}

RecordedWalk record_walk() {
  const sim::World world = sim::read_world(source_dir() / "config/worlds/lab.yaml");
  RecordedWalk walk{.robot = robot_in(world),
                    .start = world.start,
                    .frame_rate = kFrameRate,
                    .there = {{-0.4, 0.2}, std::nullopt},
                    .back = {world.start.position(), std::nullopt},
                    .frames = {},
                    .turned = 0};
  Recorder recorder(walk, world);
  recorder.walk_to(walk.there, 0.5);
  walk.turned = walk.frames.size();
  recorder.walk_to(walk.back, 0);
  return walk;
}

bool PlayedWalk::take_newest(hal::StereoFrame& into) {
  if (shown_ == nullptr) return false;
  into = *std::exchange(shown_, nullptr);
  return true;
}

void PlayedWalk::work() {
  if (next_ == 0) side_.mission.set_goal(walk_.there);
  if (next_ == walk_.turned) side_.mission.set_goal(walk_.back);
  const Given& given = walk_.frames[next_++];
  for (const hal::ChestSample& sample : given.chest) side_.links->chest.push(sample);
  for (const runtime::HeadSample& sample : given.head) side_.links->head.push(sample);
  side_.links->report.publish(given.report);
  shown_ = &given.frame;
  side_.frames.fix_level(runtime::FrameLevel::kFull);  // a slow machine leaves nothing out
  const double cpu = bench::cpu_seconds();
  const Time begin = stopwatch_.now();
  const bool worked = side_.frames.work(given.now);
  side_.frames.publish();
  seconds_ = to_seconds(stopwatch_.now() - begin);
  cpu_seconds_ = bench::cpu_seconds() - cpu;
  if (!worked || side_.mission.state() != given.then)
    throw Error(fmt::format("frame {} of the recorded walk came out otherwise when it was played", next_));
}

}  // namespace headway::bench
