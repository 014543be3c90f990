// What the recorder writes is what a reader that is not ours understands: sums, indexes, schemas and
// messages.
#include "tests/runtime/mcap_peer.h"

#include <gtest/gtest.h>

#include "runtime/recorded_values.h"
#include "runtime/recorder.h"
#include "tests/runtime/memory_sink.h"
#include "tests/temporary_folder.h"

namespace headway::runtime {
namespace {

namespace ros = recording::ros;

#define REQUIRE_PEER(answer) \
  if (!(answer))             \
  GTEST_SKIP() << "node or the packages of tests/runtime/mcap_peer are not installed; see scripts/setup"

/// One message of every topic, and what a file has besides.
std::filesystem::path write_all_topics(const std::filesystem::path& folder) {
  Preface preface;
  preface.files.push_back({"robot.yaml", "application/yaml", {std::byte{'a'}, std::byte{'b'}}});
  preface.facts["robot"] = "HRP-2";
  ros::CameraInfo info;
  info.width = 640;
  info.d = {0.1, -0.2};
  info.k = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  preface.messages.push_back({Topic::kLeftInfo, recording::to_cdr(info)});
  preface.messages.push_back({Topic::kRightInfo, recording::to_cdr(info)});
  FileTape tape({.folder = folder}, preface, at_seconds(1));
  const auto put = [&](Topic topic, const auto& message) {
    const auto cdr = recording::to_cdr(message);
    for (std::uint32_t i = 0; i < 3; ++i) tape.put({topic, i, at_seconds(1 + i), cdr});
  };
  put(Topic::kCanReceived,
      can_frame({.id = 0x123, .dlc = 3, .data = {1, 2, 3}, .stamp = {}}, at_seconds(2.5)));
  put(Topic::kCanSent, ros::CanFrame{});
  BusReport report;
  report.walk.phase_remaining = Duration(-7);
  report.control_clock = hal::ClockOffset{Duration(3), Duration(4)};
  report.committed.part = hal::PartOfOrder{{hal::WalkOrder::Kind::kArc, 1, 2, 3}, 9};
  put(Topic::kBus, to_recorded(report, false));
  put(Topic::kSteps, to_recorded(StepRecord{}));
  recorded::Work work;
  work.now_ns = 1'500'000'000;
  work.chest.push_back(to_recorded(hal::ChestSample{at_seconds(1), Pose2{1, 2, 3}.lifted(1)}));
  work.frame = {12};
  work.report.push_back(to_recorded(report));
  MotionOrder order;
  order.plan.count = 2;
  order.plan.steps[1].landing.x = 0.25;
  work.order.push_back(to_recorded(order));
  work.floor_sum = 0xFFFFFFFF;
  put(Topic::kWork, work);
  put(Topic::kGoal, to_recorded(nav::Goal{{1, 2}, 0.5, 0.1, true}));
  put(Topic::kMission, recorded::Mission{"walk", "an ö", 1, 2, 3, 4, 5});
  put(Topic::kDrops, recorded::Drops{1, 2, 3, 4, 5});
  ros::Image image;
  image.width = 3;
  image.height = 2;
  image.encoding = "mono8";
  image.data = {9, 8, 7, 6, 5, 4};
  for (const Topic topic : {Topic::kLeft, Topic::kRight, Topic::kDepth}) put(topic, image);
  put(Topic::kTf,
      ros::TfMessage{{{{ros::stamp(at_seconds(1)), "map"}, "chest", transform(Pose2{}.lifted(2))}}});
  put(Topic::kPose, pose_stamped({1, 2, 3}, at_seconds(1), "map"));
  put(Topic::kPath, ros::Path{{}, {pose_stamped({1, 2, 0}, at_seconds(1), "map")}});
  nav::FloorGrid grid;
  grid.width = 2;
  grid.height = 2;
  grid.origin = {-1, -2};
  nav::FloorMap floor = nav::unseen_floor(grid);
  floor.cells = {nav::Floor::kUnseen, nav::Floor::kFree, nav::Floor::kLow, nav::Floor::kBlocked};
  put(Topic::kMap, occupancy(floor, at_seconds(1)));
  tape.finish();
  return tape.file();
}

TEST(McapPeer, ReadsEveryTopicFromTheStartAndByTheIndexAndDecodesIt) {
  const TemporaryFolder folder;
  const auto said = testing::mcap_peer(write_all_topics(folder / "rec"));
  REQUIRE_PEER(said);
  ASSERT_FALSE(said->contains("error")) << said->dump();
  const auto &start = said->at("start"), &index = said->at("index");
  EXPECT_EQ(start.at("done"), true);
  EXPECT_EQ(index.at("profile"), "ros2");
  for (const TopicKind& topic : kTopics) {
    const int expected = topic.name.ends_with("camera_info") ? 1 : 3;
    EXPECT_EQ(start.at("counts").value(std::string(topic.name), 0), expected) << topic.name;
    EXPECT_EQ(index.at("counts").value(std::string(topic.name), 0), expected) << topic.name;
  }
  EXPECT_EQ(index.at("messages"), 3 * (kTopics.size() - 2) + 2);
  EXPECT_EQ(start.at("attachments"), nlohmann::json::parse(R"([{"name": "robot.yaml", "bytes": 2}])"));
  EXPECT_EQ(index.at("attachments"), nlohmann::json::parse(R"(["robot.yaml"])"));
  EXPECT_EQ(index.at("metadata").at(0).at("robot"), "HRP-2");
  const auto& last = index.at("last");
  const auto at = [&](const char* topic, const char* pointer) {
    return last.at(topic).at(nlohmann::json::json_pointer(pointer));
  };
  EXPECT_EQ(at("/can/received", "/id"), 0x123);
  EXPECT_EQ(at("/can/received", "/data"), nlohmann::json::parse("[1,2,3,0,0,0,0,0]"));
  EXPECT_EQ(at("/can/received", "/header/stamp/nsec"), 500'000'000);
  EXPECT_EQ(at("/headway/bus", "/walk/phase_remaining_ns"), -7);
  EXPECT_EQ(at("/headway/bus", "/control_clock/0/uncertainty_ns"), 4);
  EXPECT_EQ(at("/headway/bus", "/committed/part/0/turn"), 3);
  EXPECT_EQ(at("/headway/bus", "/committed/newest"), nlohmann::json::array());
  EXPECT_EQ(at("/headway/work", "/report/0/committed/newest").size(), 12U);
  EXPECT_EQ(at("/headway/work", "/order/0/plan/steps/1/landing/x"), 0.25);
  EXPECT_EQ(at("/headway/work", "/chest/0/odom_from_chest/9"), 1);
  EXPECT_EQ(at("/headway/work", "/floor_sum"), 0xFFFFFFFF);
  EXPECT_EQ(at("/headway/goal", "/yaw/0"), 0.5);
  EXPECT_EQ(at("/headway/mission", "/reason"), "an ö");
  EXPECT_EQ(at("/camera/left/image", "/data"), nlohmann::json::parse("[9,8,7,6,5,4]"));
  EXPECT_EQ(at("/camera/left/camera_info", "/k/0"), 500);
  EXPECT_EQ(at("/tf", "/transforms/0/child_frame_id"), "chest");
  EXPECT_EQ(at("/tf", "/transforms/0/transform/translation/z"), 2);
  EXPECT_EQ(at("/plan", "/poses/0/pose/position/y"), 2);
  EXPECT_EQ(at("/map", "/data"), nlohmann::json::parse("[-1,0,50,100]"));
  EXPECT_EQ(at("/map", "/info/origin/position/x"), -1);
}

TEST(McapPeer, FindsTheSumsWrongWhereAByteIsAnother) {
  const TemporaryFolder folder;
  const auto file = write_all_topics(folder / "rec");
  std::string bytes = read_text(file);
  REQUIRE_PEER(testing::mcap_peer(file));
  for (const double share : {0.3, 0.6, 0.97}) {
    std::string damaged = bytes;
    damaged[static_cast<std::size_t>(share * static_cast<double>(bytes.size()))] ^= 1;
    write_text(folder / "damaged.mcap", damaged);
    const auto said = testing::mcap_peer(folder / "damaged.mcap");
    ASSERT_TRUE(said);
    EXPECT_TRUE(said->contains("error")) << share << ": " << said->dump().substr(0, 200);
  }
}

TEST(McapPeer, ReadsWhatADiskThatFilledUpLeft) {
  const TemporaryFolder folder;
  recording::MemorySink sink;
  const auto writer = begin_file(sink, {}, {}, {}, {.chunk_bytes = 3000});
  const auto cdr = recording::to_cdr(recorded::Work{});
  sink.room = sink.bytes.size() + 5000;
  try {
    for (std::uint32_t i = 0; i < 100'000; ++i)
      write(*writer, {Topic::kWork, i, Time(Duration(i * 7919)), cdr});
    FAIL() << "the disk did not fill up";
  } catch (const Error&) {
  }
  sink.room += 40'000;
  ASSERT_TRUE(writer->cut_short());
  write_text(folder / "full.mcap",
             std::string(reinterpret_cast<const char*>(sink.bytes.data()), sink.bytes.size()));
  const auto said = testing::mcap_peer(folder / "full.mcap");
  REQUIRE_PEER(said);
  ASSERT_FALSE(said->contains("error")) << said->dump();
  EXPECT_GT(said->at("index").at("messages"), 10);
  EXPECT_EQ(said->at("index").at("counts"), said->at("start").at("counts"));
}

}  // namespace
}  // namespace headway::runtime
