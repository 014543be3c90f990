// Recordings that are begun and ended on the page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/operator_page.h"
#include "app/recording_folder.h"
#include "app/recording_info.h"
#include "app/recording_preface.h"
#include "hal/error.h"
#include "runtime/recorder.h"
#include "tests/app/served_robot.h"
#include "tests/runtime/memory_sink.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A simulated robot with its page, and a recorder that waits to be switched on.
struct Recorded {
  Recorded()
      : recorder(config(), recording_preface(robot, loop_setup(robot, room(), Served::options()), "sim"),
                 clock, Time{}),
        session(robot, room(), options()),
        page(page_options(), session.robot(), session.mapper().floor().grid, room().start, session.line(),
             clock) {
    page.offer_recording(recorder, folder / "rec");
  }
  runtime::RecorderConfig config() {
    runtime::RecorderConfig out;
    out.files.emplace().folder = folder / "rec";
    out.record_at_once = false;
    return out;
  }
  SimOptions options() {
    SimOptions out = Served::options();
    out.recorder = &recorder;
    return out;
  }
  static ServeOptions page_options() {
    ServeOptions out;
    out.serve = true;
    out.port = 0;
    return out;
  }
  void pass(double time) {
    const Time end = session.now() + seconds(time);
    session.run_while([&] {
      page.serve(session.status(), {}, session.now());
      return session.now() < end;
    });
  }
  std::string record(bool on) {
    return page.desk().answer(kSomebody, "record", Json{{"on", on}}.dump(), session.status(), session.now());
  }
  remote::OperatorStatus status() {
    remote::OperatorStatus out;
    page.desk().fill(out, session.status());
    return out;
  }
  /// The file of a recording of two seconds.
  fs::path recording() {
    EXPECT_THAT(record(true), HasSubstr(R"("ok":true)"));
    pass(2);
    const remote::OperatorStatus under_way = status();
    EXPECT_TRUE(under_way.recording);
    EXPECT_GT(under_way.record_mib, 0);
    EXPECT_THAT(record(false), HasSubstr(R"("ok":true)"));
    pass(0.1);
    // The page is told by the clock of the wall.
    for (const Time end = clock.now() + seconds(20); status().recording && clock.now() < end;)
      page.serve(session.status(), {}, session.now());
    EXPECT_FALSE(status().recording);
    EXPECT_EQ(status().record_fault, "");
    EXPECT_EQ(status().record_file, under_way.record_file);
    return status().record_file;
  }

  TemporaryFolder folder;
  Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  hal::MonotonicClock clock;
  runtime::Recorder recorder;
  SimSession session;
  OperatorPage page;
};

void expect_whole(const fs::path& file, double from, double to) {
  recording::McapReader reader(file);
  const RecordingInfo info = inspect(reader);
  EXPECT_TRUE(info.whole()) << file;
  EXPECT_NEAR(to_seconds(info.first.time_since_epoch()), from, 0.3);
  EXPECT_NEAR(to_seconds(info.last.time_since_epoch()), to, 0.3);
  EXPECT_EQ(info.drops, runtime::recorded::Drops{});
  EXPECT_TRUE(reader.attachment(kRobotFile));
  for (const char* topic : {"/can/received", "/can/sent", "/headway/bus", "/camera/depth", "/tf", "/map"})
    EXPECT_TRUE(std::ranges::any_of(info.topics, [&](const TopicInfo& in) {
      return in.topic == topic && in.messages > 0;
    })) << topic;
}

TEST(RecordingSwitch, EachTimeItIsOnMakesAFileThatIsWhole) {
  Recorded robot;
  robot.pass(1);
  EXPECT_FALSE(robot.status().recording);
  EXPECT_EQ(robot.status().record_folder, (robot.folder / "rec").string());
  EXPECT_FALSE(fs::exists(robot.folder / "rec")) << "nobody asked for a recording";
  const fs::path first = robot.recording();
  robot.pass(1);
  const fs::path second = robot.recording();
  EXPECT_NE(first, second);
  expect_whole(first, 1, 3);
  expect_whole(second, 4.1, 6.1);
}

TEST(RecordingSwitch, ARecordingThatIsUnderWayIsEndedWithTheProgram) {
  fs::path file;
  TemporaryFolder kept;
  {
    Recorded robot;
    robot.pass(0.5);
    robot.record(true);
    robot.pass(1);
    file = robot.status().record_file;
    robot.recorder.stop();
    fs::copy(file, kept / "kept.mcap");
  }
  expect_whole(kept / "kept.mcap", 0.5, 1.5);
}

TEST(RecordingSwitch, SaysWhyItCannotBegin) {
  Recorded robot;
  robot.pass(0.1);
  std::ofstream(robot.folder / "rec") << "no folder";
  const std::string refusal = robot.record(true);
  EXPECT_THAT(refusal, HasSubstr(R"("ok":false)"));
  EXPECT_THAT(refusal, HasSubstr((robot.folder / "rec").string()));
  robot.pass(0.1);
  EXPECT_FALSE(robot.status().recording);
}

TEST(RecordingSwitch, WhereTooLittleRoomIsLeftNoneIsBegun) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(require_room_to_record(folder / "new", 1));
  try {
    require_room_to_record(folder.path(), UINT64_MAX);
    FAIL();
  } catch (const Error& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("make room"));
  }
}

/// Writes to a disk of memory, which may be full.
class Disk final : public recording::ByteSink {
 public:
  explicit Disk(recording::MemorySink& memory) : memory_(memory) {}
  void write(std::span<const std::byte> bytes) override { memory_.write(bytes); }
  void sync() override { memory_.sync(); }
  void cut(std::uint64_t size) override { memory_.cut(size); }

 private:
  recording::MemorySink& memory_;
};

TEST(RecordingSwitch, AFullDiskEndsItWithTheReasonAndAnotherMayBegin) {
  const TemporaryFolder folder;
  hal::ManualClock clock;
  recording::MemorySink memory;
  runtime::RecorderConfig config;
  config.record_at_once = false;
  config.files.emplace().folder = folder.path();
  config.files->make = [&](const fs::path&) {
    memory.bytes.clear();
    return std::make_unique<Disk>(memory);
  };
  runtime::Recorder recorder(config, {}, clock, {});
  runtime::RecordingState state;
  const auto frames = [&](int count) {
    for (int i = 0; i < count; ++i) {
      clock.advance(seconds(0.01));
      recorder.bus().received({.id = 0x511, .dlc = 8, .data = {}, .stamp = clock.now()});
      recorder.pump();
    }
    recorder.look(state);
  };
  memory.room = 40'000;
  recorder.record(true);
  frames(100);
  EXPECT_TRUE(state.on) << state.fault;
  frames(20'000);
  EXPECT_FALSE(state.on);
  EXPECT_THAT(state.fault, HasSubstr("the disk is full"));
  memory.room = SIZE_MAX;
  recorder.record(true);
  frames(100);
  EXPECT_TRUE(state.on);
  EXPECT_EQ(state.fault, "");
  EXPECT_THAT(state.file, HasSubstr("recording_"));
  recorder.record(false);
  frames(1);
  EXPECT_FALSE(state.on);
  recording::McapReader reader(std::make_unique<recording::MemorySource>(memory.bytes), "memory");
  EXPECT_TRUE(inspect(reader).whole());
}

}  // namespace
}  // namespace headway::app
