// A recording on the operator's page: played, held, and gone to and fro.
#include "app/replay_player.h"

#include <atomic>
#include <filesystem>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/recording_preface.h"
#include "app/sim_session.h"
#include "hal/error.h"
#include "runtime/recorder.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {
namespace {

using testing::HasSubstr;

/// The clock of a wall that goes on as soon as somebody waits for it.
class EagerClock final : public hal::Clock {
 public:
  Time now() const noexcept override { return now_; }
  void sleep_until(Time t) noexcept override { now_ = std::max(now_.load(), t); }

 private:
  std::atomic<Time> now_{Time{}};  // the server's thread asks too
};

class ReplayPlayerTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("headway_player_{}", ::getpid());
    std::filesystem::remove_all(folder_);
    record();
    options_.serve = true;
    options_.port = 0;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Some seconds of looking around.
  void record() {
    const Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
    sim::World world;
    world.name = "room";
    sim::add_room(world, {0.5, 0}, {5, 4}, 2.2, 0);
    SimOptions sim;
    sim.range_mode = true;
    sim.goal = nav::Goal{{1, 0}, std::nullopt};
    sim.longest = seconds(8);
    hal::MonotonicClock clock;
    runtime::RecorderConfig config;
    config.files.emplace().folder = folder_;
    runtime::Recorder recorder(config, recording_preface(robot, loop_setup(robot, world, sim), "sim"), clock,
                               Time{});
    sim.recorder = &recorder;
    SimSession session(robot, world, sim);
    session.run();
    recorder.stop();
    file_ = recorder.tape()->file();
  }

  std::filesystem::path folder_, file_;
  ServeOptions options_;
  EagerClock clock_;
};

TEST_F(ReplayPlayerTest, PlaysAtTheRecordingsPaceToItsEnd) {
  ReplayPlayer player(file_, options_, clock_);
  EXPECT_THAT(player.address(), HasSubstr("http://127.0.0.1:"));
  player.play([&] { return player.played().paused; });
  EXPECT_NEAR(to_seconds(player.played().at - player.played().from), 8, 0.5);
  EXPECT_NEAR(to_seconds(clock_.now().time_since_epoch()), 8, 0.5) << "a second of it takes a second";
}

TEST_F(ReplayPlayerTest, GoesToAndFroAndTwiceAsFast) {
  ReplayPlayer player(file_, options_, clock_);
  int asked = 0;
  Time back{};
  player.play([&] {
    ++asked;
    const double at = to_seconds(player.played().at - player.played().from);
    if (asked == 10) player.steer(R"({"at": 6})");
    if (at >= 6 && back == Time{}) {
      back = clock_.now();
      EXPECT_LT(to_seconds(clock_.now().time_since_epoch()), 2) << "the way there is not played";
      player.steer(R"({"at": 1, "speed": 2})");
    }
    return back != Time{} && at >= 1 && at < 6 && clock_.now() - back > seconds(2);
  });
  EXPECT_NEAR(to_seconds(player.played().at - player.played().from), 5, 0.7);
}

TEST_F(ReplayPlayerTest, StandsStillWhileItIsPaused) {
  ReplayPlayer player(file_, options_, clock_);
  std::optional<Time> held;
  Time since{};
  player.play([&] {
    if (!held && to_seconds(player.played().at - player.played().from) > 2) {
      player.steer(R"({"play": false})");
      held = player.played().at;
      since = clock_.now();
    }
    return held && clock_.now() - since > seconds(5);
  });
  EXPECT_EQ(player.played().at, *held);
}

TEST_F(ReplayPlayerTest, SaysWhatItExpects) {
  ReplayPlayer player(file_, options_, clock_);
  for (const char* bad : {"[]", "7", "{\"speed\": 0}", "{\"speed\": 1000}", "{\"at\": -1}", "{\"at\": \"x\"}",
                          "{\"rewind\": 1}", "{\"play\": 1}"})
    EXPECT_THAT(player.steer(bad), HasSubstr("\"ok\":false")) << bad;
  EXPECT_THAT(player.steer("{\"at\": 1e300}"), HasSubstr("\"ok\":true")) << "no farther than its end";
  EXPECT_THROW(ReplayPlayer(folder_ / "none.mcap", options_, clock_), InputError);
}

}  // namespace
}  // namespace headway::app
