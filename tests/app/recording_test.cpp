// Recordings of whole simulated runs: what they hold, that the work done again is the same to the last bit,
// and that nothing that happens to the program or the file makes them useless.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/recording_info.h"
#include "app/replay_session.h"
#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "tests/app/robot_on_bus.h"
#include "tests/app/run_headway.h"
#include "tests/runtime/mcap_peer.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using test::Outcome, test::run_headway, test::says;

std::string world(const char* name) {
  return (source_dir() / "config/worlds" / (std::string(name) + ".yaml")).string();
}

/// A short run that is recorded; more options behind. Returns the recording.
fs::path record(const fs::path& folder, std::vector<std::string> options) {
  std::vector<std::string> arguments{"sim",      world("moving_box"),      "--out", (folder / "out").string(),
                                     "--record", (folder / "rec").string()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome outcome = run_headway(arguments);
  EXPECT_LE(outcome.code, kNotReached) << outcome.error;
  return folder / "rec/recording_0001_00.mcap";
}

Outcome replay(const fs::path& file) { return run_headway({"replay", file.string()}); }

TEST(Recording, HoldsAWholeRunAndDoesItsWorkAgainToTheLastBit) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--range", "--longest", "40"});
  recording::McapReader reader(file);
  const RecordingInfo info = inspect(reader);
  EXPECT_TRUE(info.whole());
  EXPECT_NEAR(to_seconds(info.last), 40, 0.5);
  std::map<std::string, TopicInfo> topics;
  for (const TopicInfo& topic : info.topics) topics[topic.topic] = topic;
  for (const char* name : {"/can/received", "/can/sent", "/headway/bus", "/headway/work", "/headway/goal",
                           "/headway/mission", "/headway/steps", "/camera/depth", "/camera/left/camera_info",
                           "/tf", "/headway/pose", "/plan", "/map"}) {
    EXPECT_GT(topics[name].messages, 0U) << name;
    EXPECT_EQ(topics[name].missing, 0U) << name;
  }
  EXPECT_NEAR(topics["/headway/bus"].rate(), 200, 2);
  EXPECT_EQ(topics["/headway/goal"].messages, 1U);
  EXPECT_EQ(*info.drops, runtime::recorded::Drops{});
  EXPECT_TRUE(reader.attachment(kRobotFile));

  const Outcome outcome = replay(file);
  EXPECT_EQ(outcome.code, kSuccess) << outcome.said << outcome.error;
  EXPECT_NE(outcome.said.find("the same, bit by bit"), std::string::npos) << outcome.said;

  if (const auto said = testing::mcap_peer(file)) {
    ASSERT_FALSE(said->contains("error")) << said->dump();
    for (const auto& [name, topic] : topics)
      EXPECT_EQ(said->at("index").at("counts").at(name), topic.messages) << name;
  } else {
    GTEST_SKIP() << "node or the packages of tests/runtime/mcap_peer are not installed; see scripts/setup";
  }
}

TEST(Recording, OfTwoCamerasHoldsTheirImagesAndDoesItsWorkAgain) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--longest", "6"});
  const Outcome outcome = replay(file);
  EXPECT_EQ(outcome.code, kSuccess) << outcome.said << outcome.error;
  recording::McapReader reader(file);
  const RecordingInfo info = inspect(reader);
  std::uint64_t left = 0, right = 0;
  for (const TopicInfo& topic : info.topics) {
    if (topic.topic == "/camera/left/image") left = topic.messages;
    if (topic.topic == "/camera/right/image") right = topic.messages;
  }
  EXPECT_GT(left, 30U);
  EXPECT_EQ(left, right);
}

TEST(Recording, OfOrdersInAMapFromBeforeDoesItsWorkAgain) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_headway({"sim", world("moving_box"), "--range", "--out", (folder / "first").string()}).code,
            kSuccess);
  const fs::path file = record(folder.path(), {"--range", "--longest", "40", "--execution", "orders", "--map",
                                               (folder / "first/map.hmap").string(), "--seed", "5"});
  const Outcome outcome = replay(file);
  EXPECT_EQ(outcome.code, kSuccess) << outcome.said << outcome.error;
}

/// A run on threads and a real clock, twice as fast.
TEST(RecordingSlow, OfARunOnThreadsDoesItsWorkAgainAndHasNoDrops) {
  const TemporaryFolder folder;
  hal::ScaledClock clock(0.5);
  const Robot robot = hrp2();
  NodeSession node(robot, empty_room(), {}, true, clock.now());
  RobotOnBus wires(node, clock);
  Pictures pictures(wires);
  LiveOptions live{
      .start = {-0.8, 0, 0}, .floor = {8, 8}, .goal = nav::Goal{{0.7, 0.1}, {}}, .frame_rate = 10};
  LoopSetup setup = loop_setup(robot, live);
  setup.range_mode = true;
  runtime::RecorderConfig config;
  config.files.emplace().folder = folder / "rec";
  runtime::Recorder recorder(config, recording_preface(robot, setup, "run"), clock, clock.now());
  live.recorder = &recorder;
  Taps taps(&recorder);
  runtime::DepthEyes eyes(taps.camera(pictures), node.depth_eyes());
  const fs::path file = recorder.tape()->file();
  {
    LiveSession session(with(setup, robot), live, wires, eyes, clock);
    recorder.start();
    session.start();
    LiveStatus status;
    for (const Time end = clock.now() + seconds(60);
         clock.now() < end && status.state != runtime::MissionState::kArrived;) {
      session.look(status);
      clock.sleep_until(clock.now() + seconds(0.05));
    }
    session.stop();
    EXPECT_FALSE(session.failure());
  }
  recorder.stop();
  EXPECT_EQ(recorder.drops(), runtime::recorded::Drops{});
  const Outcome outcome = replay(file);
  EXPECT_EQ(outcome.code, kSuccess) << outcome.said << outcome.error;
  std::printf("%s", outcome.said.c_str());
}

/// Copies the rows of a recording, changed, into another file.
template <class Change>
void copy_changed(const fs::path& from, const fs::path& to, Change&& change) {
  recording::McapReader reader(from);
  recording::FileSink sink(to);
  runtime::Preface preface;
  for (const auto& index : std::vector(reader.attachments()))
    preface.files.push_back({index.name, index.media_type, reader.attachment(index)->data});
  preface.facts = *reader.metadata(runtime::kFactsName);
  const auto writer = runtime::begin_file(sink, preface, {}, {});
  reader.for_each({}, [&](const recording::McapMessage& message) {
    const auto topic = static_cast<runtime::Topic>(message.channel);
    std::vector<std::byte> cdr(message.bytes.begin(), message.bytes.end());
    if (change(topic, message.sequence, cdr))
      runtime::write(*writer, {topic, message.sequence, message.log_time, cdr});
  });
  writer->finish();
}

TEST(Replay, SaysTheFirstPlanThatIsAnother) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--range", "--longest", "12"});
  std::uint32_t changed = 0;
  copy_changed(file, folder / "changed.mcap", [&](runtime::Topic topic, std::uint32_t number, auto& cdr) {
    if (topic != runtime::Topic::kWork || changed > 0) return true;
    auto work = recording::from_cdr<runtime::recorded::Work>(cdr);
    if (number < 200 || work.order.empty()) return true;
    work.order[0].look.pan = std::nextafter(work.order[0].look.pan, 9.0);
    cdr = recording::to_cdr(work);
    changed = number;
    return true;
  });
  ASSERT_GT(changed, 0U);
  const Outcome outcome = replay(folder / "changed.mcap");
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_NE(outcome.said.find(fmt::format("another plan: work {} at", changed)), std::string::npos)
      << outcome.said;
  EXPECT_NE(outcome.said.find("the head's pan"), std::string::npos) << outcome.said;
}

TEST(Replay, ComesToAnotherPlanFromAnotherPicture) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--range", "--longest", "12"});
  copy_changed(file, folder / "changed.mcap", [&](runtime::Topic topic, std::uint32_t number, auto& cdr) {
    if (topic != runtime::Topic::kDepth || number < 20) return true;
    auto image = recording::from_cdr<recording::ros::Image>(cdr);
    for (std::size_t i = 0; i < image.data.size() / 4; ++i) {  // all farther away by a tenth
      float z = 0;
      std::memcpy(&z, image.data.data() + 4 * i, 4);
      z *= 1.1F;
      std::memcpy(image.data.data() + 4 * i, &z, 4);
    }
    cdr = recording::to_cdr(image);
    return true;
  });
  const Outcome outcome = replay(folder / "changed.mcap");
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_NE(outcome.said.find("another plan"), std::string::npos) << outcome.said;
}

TEST(Replay, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--range", "--longest", "8"});
  const auto without = [&](const char* name, runtime::Topic gone, std::uint32_t from, std::uint32_t to) {
    copy_changed(file, folder / name, [&](runtime::Topic topic, std::uint32_t number, auto&) {
      return topic != gone || number < from || number >= to;
    });
    const Outcome outcome = replay(folder / name);
    EXPECT_EQ(outcome.code, kNotReached) << name;
    return outcome.said;
  };
  EXPECT_NE(without("works.mcap", runtime::Topic::kWork, 300, 303).find("3 works before"), std::string::npos);
  EXPECT_NE(without("begin.mcap", runtime::Topic::kWork, 0, 9).find("begins with work 9"), std::string::npos);
  EXPECT_NE(without("pictures.mcap", runtime::Topic::kDepth, 7, 8).find("the picture of frame"),
            std::string::npos);
}

TEST(Replay, OfWhatIsNoRecordingOfOursIsRefusedInOneLine) {
  const TemporaryFolder folder;
  EXPECT_TRUE(says(replay(folder / "none.mcap"), {"none.mcap: cannot be opened", "expected a recording"}));
  write_text(folder / "text.mcap", "MCAP?");
  EXPECT_TRUE(says(replay(folder / "text.mcap"), {"text.mcap: is no recording"}));
  EXPECT_TRUE(says(replay(folder.path()), {"is no file"}));
  {
    recording::FileSink sink(folder / "other.mcap");
    recording::McapWriter(sink).finish();
  }
  EXPECT_TRUE(says(replay(folder / "other.mcap"), {"other.mcap: does not say how the loops were set up"}));
}

TEST(Record, InfoAndExtractSpeakOfAFileThatWasCut) {
  const TemporaryFolder folder;
  const fs::path file = record(folder.path(), {"--range", "--longest", "8"});
  const Outcome whole = run_headway({"record", "info", file.string()});
  EXPECT_EQ(whole.code, kSuccess);
  EXPECT_NE(whole.said.find("whole: every sum is right"), std::string::npos) << whole.said;
  const std::string bytes = read_text(file);
  write_text(folder / "cut.mcap", bytes.substr(0, bytes.size() * 2 / 3));
  const Outcome cut = run_headway({"record", "info", (folder / "cut.mcap").string(), "--json"});
  EXPECT_EQ(cut.code, kNotReached);
  const auto json = nlohmann::json::parse(cut.said);
  EXPECT_EQ(json.at("whole"), false);
  EXPECT_EQ(json.at("lost").size(), 1U);
  EXPECT_GT(json.at("topics").size(), 8U);

  const Outcome extracted = run_headway(
      {"record", "extract", (folder / "cut.mcap").string(), "--out", (folder / "parts").string()});
  EXPECT_EQ(extracted.code, kSuccess) << extracted.error;
  EXPECT_NE(extracted.said.find("lost: "), std::string::npos);
  EXPECT_TRUE(fs::exists(folder / "parts/depth_000000.png"));
  EXPECT_TRUE(fs::exists(folder / "parts/map_0000.yaml"));
  EXPECT_EQ(read_text(folder / "parts/attached_robot.yaml"),
            read_text(source_dir() / "config/hrp2/robot.yaml"));
  const Outcome dump = run_headway({"can", "dump", "--log", (folder / "parts/can.log").string(), "--json"});
  EXPECT_EQ(dump.code, kSuccess) << dump.error;
  EXPECT_GT(std::count(dump.said.begin(), dump.said.end(), '\n'), 1000);
  // A replay of it comes as far as the file goes.
  EXPECT_EQ(replay(folder / "cut.mcap").code, kSuccess);
}

TEST(Recording, ThatIsNotToBeWrittenIsSaidBeforeTheRun) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  EXPECT_TRUE(says(run_headway({"sim", world("moving_box"), "--range", "--out", (folder / "out").string(),
                                "--record", (folder / "file/rec").string()}),
                   {"file/rec", "cannot be made"}));
}

/// Runs the program in a process of its own, what it says in FOLDER/said; `also` is done there first.
template <class Also>
pid_t fork_headway(const fs::path& folder, const std::vector<std::string>& arguments, Also&& also) {
  const pid_t child = fork();
  if (child != 0) return child;
  also();
  if (!std::freopen("/dev/null", "w", stdout) || !std::freopen((folder / "said").c_str(), "w", stderr))
    _exit(99);
  std::vector<const char*> argv{"headway"};
  for (const std::string& a : arguments) argv.push_back(a.c_str());
  _exit(run_program(static_cast<int>(argv.size()), argv.data()));
}

TEST(Recording, OnADiskThatFillsUpTheRunEndsWithOneErrorAndTheFileIsWhole) {
  const TemporaryFolder folder;
  const pid_t child = fork_headway(folder.path(),
                                   {"sim", world("moving_box"), "--range", "--longest", "20", "--out",
                                    (folder / "out").string(), "--record", (folder / "rec").string()},
                                   [] {
                                     const rlimit limit{3'000'000, 3'000'000};
                                     setrlimit(RLIMIT_FSIZE, &limit);
                                     std::signal(SIGXFSZ, SIG_IGN);
                                   });
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_GE(WEXITSTATUS(status), kBadInput);  // the other files of the run meet the limit too
  ASSERT_TRUE(fs::exists(folder / "rec/recording_0001_00.mcap")) << read_text(folder / "said");
  recording::McapReader reader(folder / "rec/recording_0001_00.mcap");
  const RecordingInfo info = inspect(reader);
  EXPECT_GT(info.last, at_seconds(0.5));
  EXPECT_GT(info.topics.size(), 5U);
}

/// Kills recorded runs at random moments, and looks at what they leave. The moments are real time, for
/// a kill comes from outside whatever clock the program goes by: nothing is expected of how far it has come.
void kill_and_look(int times, unsigned seed) {
  std::mt19937 dice(seed);
  int ended = 0, recordings = 0, maps = 0;
  for (int i = 0; i < times; ++i) {
    const TemporaryFolder folder;
    const pid_t child = fork_headway(folder.path(),
                                     {"sim", world("moving_box"), "--range", "--longest", "30", "--out",
                                      (folder / "out").string(), "--record", (folder / "rec").string()},
                                     [] {});
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + dice() % 4000));
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    if (WIFEXITED(status)) ++ended;
    const fs::path file = folder / "rec/recording_0001_00.mcap";
    if (fs::exists(file) && fs::file_size(file) > 10'000) {
      recording::McapReader reader(file);
      const RecordingInfo info = inspect(reader);
      for (const recording::McapLoss& loss : info.losses)
        EXPECT_EQ(loss.what.find("damaged chunk"), std::string::npos) << loss.what;
      for (const TopicInfo& topic : info.topics) EXPECT_EQ(topic.missing, 0U) << topic.topic;
      // Whatever lies in whole chunks can be done again.
      ReplaySession session(reader);
      session.run(reader);
      EXPECT_FALSE(session.result().difference) << *session.result().difference;
      EXPECT_FALSE(session.result().missing) << *session.result().missing;
      if (session.result().orders > 0) ++recordings;
    }
    if (fs::exists(folder / "out/map.hmap")) {
      EXPECT_GT(nav::read_saved_map(folder / "out/map.hmap").map.size(), 0U);
      ++maps;
    }
  }
  std::printf("killed %d: %d had ended, %d left a recording with plans, %d a map\n", times, ended, recordings,
              maps);
  EXPECT_GT(recordings, times / 3);
}

TEST(Recording, AProgramThatIsKilledLeavesOneThatCanBeDoneAgain) { kill_and_look(4, 2008); }

/// HEADWAY_RECORDINGS says how often; without it, as often as a test should take.
int wanted_recordings(int few) {
  const char* wanted = std::getenv("HEADWAY_RECORDINGS");
  return wanted == nullptr ? few : std::stoi(wanted);
}

TEST(RecordingSlow, AProgramThatIsKilledLeavesOneThatCanBeDoneAgain) {
  kill_and_look(wanted_recordings(10), 1);
}

TEST(RecordingSlow, RunsAreDoneAgainToTheLastBit) {
  for (int seed = 1; seed <= wanted_recordings(4); ++seed) {
    const TemporaryFolder folder;
    std::vector<std::string> options{"--range", "--seed", std::to_string(seed), "--longest", "60"};
    if (seed % 4 == 1) options.insert(options.end(), {"--execution", "orders"});
    if (seed % 4 == 2) options.insert(options.end(), {"--drift", "2"});
    if (seed == 3) options = {"--seed", "3", "--longest", "25"};  // two cameras
    const fs::path file = record(folder.path(), options);
    const Outcome outcome = replay(file);
    EXPECT_EQ(outcome.code, kSuccess) << "seed " << seed << ": " << outcome.said << outcome.error;
  }
}

}  // namespace
}  // namespace headway::app
