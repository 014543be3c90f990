// The recorder and the black box: nothing makes a loop wait, what is dropped is counted, what is written can
// be read.
#include "runtime/recorder.h"

#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "runtime/bus_loop.h"
#include "runtime/recording/mcap_reader.h"
#include "tests/heap_count.h"
#include "tests/runtime/fake_robot.h"
#include "tests/runtime/memory_sink.h"
#include "tests/temporary_folder.h"

namespace headway::runtime {
namespace {

namespace fs = std::filesystem;

hal::CanFrame frame(std::uint32_t id, Time stamp = {}) {
  return {.id = id, .dlc = 2, .data = {1, 2}, .stamp = stamp};
}

/// A sink that hands what it gets to a file on a disk made of memory.
class SharedSink final : public recording::ByteSink {
 public:
  explicit SharedSink(recording::MemorySink& disk) : disk_(disk) {}
  void write(std::span<const std::byte> bytes) override { disk_.write(bytes); }
  void sync() override { disk_.sync(); }
  void cut(std::uint64_t size) override { disk_.cut(size); }

 private:
  recording::MemorySink& disk_;
};

struct Bench {
  TemporaryFolder folder;
  hal::ManualClock clock;
  recording::MemorySink disk;

  RecorderConfig on_disk_of_memory() {
    RecorderConfig config;
    config.files.emplace().folder = folder.path();
    config.files->make = [this](const fs::path&) { return std::make_unique<SharedSink>(disk); };
    return config;
  }
  RecorderConfig on_files(std::uint64_t rotate) {
    RecorderConfig config;
    config.files.emplace().folder = folder / "rec";
    config.files->rotate = rotate;
    return config;
  }
};

std::map<std::string, std::uint64_t> counts(recording::McapReader& reader) {
  std::map<std::string, std::uint64_t> out;
  reader.for_each({}, [&](const recording::McapMessage& m) { ++out[reader.channels().at(m.channel).topic]; });
  return out;
}

recording::McapReader reader_of(const std::vector<std::byte>& bytes) {
  return {std::make_unique<recording::MemorySource>(bytes), "disk"};
}

template <recording::CdrMessage T>
std::vector<T> all_of(recording::McapReader& reader, Topic topic) {
  std::vector<T> out;
  reader.for_each({*reader.channel(kind(topic).name)},
                  [&](const recording::McapMessage& m) { out.push_back(recording::from_cdr<T>(m.bytes)); });
  return out;
}

TEST(Recorder, WritesWhatTravelsOnTheBusBothWays) {
  Bench bench;
  SilentBus silent;
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  TappedBus bus(silent, recorder.bus(), bench.clock);
  bench.clock.set(at_seconds(2));
  bus.send(frame(0x211));
  recorder.bus().received(frame(0x511, at_seconds(1.5)));
  recorder.stop();
  recording::McapReader reader = reader_of(bench.disk.bytes);
  const auto sent = all_of<recording::ros::CanFrame>(reader, Topic::kCanSent),
             received = all_of<recording::ros::CanFrame>(reader, Topic::kCanReceived);
  ASSERT_EQ(sent.size(), 1U);
  ASSERT_EQ(received.size(), 1U);
  EXPECT_EQ(sent[0].id, 0x211U);
  EXPECT_EQ(recording::ros::time_of(sent[0].header.stamp), at_seconds(2));
  EXPECT_EQ(received[0].id, 0x511U);
  EXPECT_EQ(recording::ros::time_of(received[0].header.stamp), at_seconds(1.5));
  EXPECT_TRUE(reader.has_end());
}

TEST(Recorder, TakesNoMemoryInTheBusCycle) {
  Bench bench;
  SilentBus silent;
  FakeHead head;
  FakeWalker walker;
  const auto links = std::make_unique<Links>();
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  TappedBus bus(silent, recorder.bus(), bench.clock);
  BusLoop loop({.stance = hal::Stance::parallel({}, 0.19), .steps = {}}, bus, head, walker, *links);
  loop.show(recorder.bus());
  const auto before = heap_allocations();
  for (int i = 1; i <= 5000; ++i) {  // more than the queues hold
    bench.clock.advance(seconds(0.005));
    bus.send(frame(0x80));
    loop.cycle(bench.clock.now());
  }
  EXPECT_EQ(heap_allocations(), before);
  recorder.stop();
  EXPECT_GT(recorder.drops().can_frames, 0U);
  EXPECT_GT(recorder.drops().bus_reports, 0U);
}

TEST(Recorder, ASlowDiskCostsRowsThatAreCountedAndNeverALoopsTime) {
  Bench bench;
  std::atomic<bool> stuck{true};
  bench.disk.on_write = [&] {
    while (stuck) std::this_thread::yield();
  };
  stuck = false;
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  stuck = true;
  recorder.start();
  constexpr std::uint64_t kFrames = 100'000;
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    bench.clock.advance(std::chrono::milliseconds(1));
    recorder.bus().received(frame(i % 0x700, bench.clock.now()));  // comes back whatever the disk does
  }
  stuck = false;
  recorder.stop();
  recording::McapReader reader = reader_of(bench.disk.bytes);
  const auto drops = all_of<recorded::Drops>(reader, Topic::kDrops);
  ASSERT_FALSE(drops.empty());
  EXPECT_GT(drops.back().can_frames, 0U);
  const std::uint64_t written = counts(reader)["/can/received"];
  EXPECT_EQ(written + drops.back().can_frames, kFrames);
  // The gaps in the numbers are what was dropped.
  std::uint64_t missing = 0, next = 0;
  reader.for_each({*reader.channel("/can/received")}, [&](const recording::McapMessage& m) {
    missing += m.sequence - next;
    next = m.sequence + 1;
  });
  EXPECT_EQ(missing + (kFrames - next), drops.back().can_frames);
}

TEST(Recorder, AFullDiskEndsTheRecordingIsToldOnceAndLeavesAWholeFile) {
  Bench bench;
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  bench.disk.room = bench.disk.bytes.size() + 20'000;
  for (std::uint32_t i = 0; i < 30'000; ++i) {
    bench.clock.advance(std::chrono::milliseconds(1));
    recorder.bus().received(frame(i * 2654435761U % 0x700, bench.clock.now()));
    if (i % 1000 == 0) recorder.pump();
  }
  recorder.stop();
  std::string news, more;
  ASSERT_TRUE(recorder.news(news));
  EXPECT_EQ(news, "the recording ends here: the disk is full");
  EXPECT_FALSE(recorder.news(more)) << more;
  recording::McapReader reader = reader_of(bench.disk.bytes);
  EXPECT_GT(counts(reader)["/can/received"], 100U);
  EXPECT_TRUE(reader.losses().empty() || !reader.has_end());
}

TEST(Recorder, BeginsAnotherFileWhenOneIsLargeAndEachIsWholeByItself) {
  Bench bench;
  Preface preface;
  preface.files.push_back({"robot.yaml", "application/yaml", {std::byte{'x'}}});
  preface.facts["robot"] = "HRP-2";
  Recorder recorder(bench.on_files(60'000), preface, bench.clock, {});
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    bench.clock.advance(std::chrono::milliseconds(1));
    recorder.bus().received(frame(i * 2654435761U % 0x700, bench.clock.now()));
    if (i % 100 == 0) recorder.pump();
  }
  recorder.stop();
  std::uint64_t frames = 0;
  int files = 0;
  for (;; ++files) {
    const fs::path file = bench.folder / "rec" / fmt::format("recording_0001_{:02}.mcap", files);
    if (!fs::exists(file)) break;
    recording::McapReader reader(file);
    EXPECT_TRUE(reader.has_end());
    EXPECT_EQ(reader.sum_is_right(), true);
    EXPECT_TRUE(reader.attachment("robot.yaml"));
    EXPECT_EQ(reader.metadata(kFactsName)->at("part"), std::to_string(files));
    frames += counts(reader)["/can/received"];
  }
  EXPECT_GT(files, 2);
  EXPECT_EQ(frames, 20'000U);
  // The next one writes over none of them.
  Recorder next(bench.on_files(60'000), preface, bench.clock, {});
  EXPECT_EQ(next.tape()->file().filename(), "recording_0002_00.mcap");
}

TEST(Recorder, LeavesNoFileWhereNothingHappened) {
  Bench bench;
  fs::path file;
  {
    Recorder recorder(bench.on_files(1 << 20), {}, bench.clock, {});
    file = recorder.tape()->file();
    EXPECT_TRUE(fs::exists(file));
  }
  EXPECT_FALSE(fs::exists(file));
}

TEST(Recorder, KeepsPicturesBeforeTheWorkThatTookThem) {
  Bench bench;
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  FrameTap& tap = recorder.frames();
  hal::DepthFrame picture;
  picture.width = picture.height = 8;
  picture.depth.assign(64, 1.5F);
  for (std::uint64_t i = 0; i < 50; ++i) {
    tap.begins(at_seconds(0.1 * static_cast<double>(i)), FrameLevel::kFull);
    picture.sequence = i;
    tap.took(picture);
    tap.ends(nullptr, {}, true);
    if (i % 7 == 0) recorder.pump();
  }
  recorder.stop();
  recording::McapReader reader = reader_of(bench.disk.bytes);
  std::uint64_t pictures = 0, works = 0;
  reader.for_each({}, [&](const recording::McapMessage& m) {
    if (m.channel == *reader.channel("/camera/depth")) ++pictures;
    if (m.channel == *reader.channel("/headway/work")) {
      EXPECT_EQ(pictures, ++works);
    }
  });
  EXPECT_EQ(works, 50U);
}

TEST(Recorder, LeavesOutWorksThatChangedNothing) {
  Bench bench;
  Recorder recorder(bench.on_disk_of_memory(), {}, bench.clock, {});
  FrameTap& tap = recorder.frames();
  const auto work = [&](bool takes, bool waits) {
    tap.begins(bench.clock.now(), FrameLevel::kFull);
    if (takes) tap.takes(HeadSample{});
    tap.ends(nullptr, {}, waits);
  };
  work(false, false);  // the first counts
  work(false, false);
  work(true, false);
  work(false, true);
  work(false, false);  // a frame was at hand before
  work(false, false);
  recorder.stop();
  recording::McapReader reader = reader_of(bench.disk.bytes);
  EXPECT_EQ(counts(reader)["/headway/work"], 4U);
}

RC_GTEST_PROP(RowRing, HoldsTheNewestRowsThatFit, (std::vector<std::uint8_t> sizes)) {
  constexpr std::size_t kBytes = 600, kRows = 12;
  RowRing ring(kBytes, kRows);
  std::vector<std::vector<std::byte>> put;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    put.emplace_back(sizes[i], static_cast<std::byte>(i));
    RC_ASSERT(ring.put({Topic::kBus, static_cast<std::uint32_t>(i), Time(Duration(i)), put.back()}));
    RC_ASSERT(ring.size() >= 1U && ring.size() <= kRows);
    // The newest without a gap, as they were put in; of small rows no fewer than half the room holds.
    std::size_t bytes = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const std::size_t number = i + 1 - ring.size() + k;
      const Row row = ring.at(k);
      RC_ASSERT(row.sequence == number);
      RC_ASSERT(std::equal(row.cdr.begin(), row.cdr.end(), put[number].begin(), put[number].end()));
      bytes += row.cdr.size();
    }
    RC_ASSERT(bytes <= kBytes);
    const bool lost_some = ring.size() < std::min(i + 1, kRows);
    if (lost_some) RC_ASSERT(bytes + 2 * 255 > kBytes / 2);
  }
  const std::vector<std::byte> too_long(kBytes + 1);
  const std::size_t before = ring.size();
  RC_ASSERT(!ring.put({Topic::kBus, 0, {}, too_long}));
  RC_ASSERT(ring.size() == before);
}

struct BoxBench : Bench {
  RecorderConfig boxed() {
    RecorderConfig config;
    config.black_box.emplace().folder = folder / "box";
    config.black_box->picture_bytes = 100'000;
    return config;
  }
  std::vector<fs::path> boxes() const {
    std::vector<fs::path> all;
    if (!fs::exists(folder / "box")) return all;
    for (const auto& entry : fs::directory_iterator(folder / "box")) all.push_back(entry.path());
    std::sort(all.begin(), all.end());
    return all;
  }
  /// A second of the robot's life, with ten pictures.
  void live(Recorder& recorder, int seconds_long, hal::HeadHealth head = hal::HeadHealth::kReady) {
    for (int i = 0; i < 200 * seconds_long; ++i) {
      clock.advance(std::chrono::milliseconds(5));
      BusReport report;
      report.stamp = clock.now();
      report.head.health = head;
      report.walker = hal::WalkerHealth::kReady;
      recorder.bus().reported(report);
      if (i % 20 == 0) {
        hal::StereoFrame pair;
        pair.left = pair.right = {40, 30, std::vector<std::uint8_t>(1200)};
        recorder.frames().begins(clock.now(), FrameLevel::kFull);
        recorder.frames().took(pair);
        recorder.frames().ends(nullptr, {}, true);
      }
      recorder.pump();
    }
  }
};

TEST(BlackBox, WritesTheHalfMinuteBeforeAFaultAndASecondAfterIt) {
  BoxBench bench;
  Recorder recorder(bench.boxed(), {}, bench.clock, {});
  bench.live(recorder, 60);
  EXPECT_TRUE(bench.boxes().empty());
  const Time fault = bench.clock.now();
  bench.live(recorder, 3, hal::HeadHealth::kFault);
  ASSERT_EQ(bench.boxes().size(), 1U);
  recording::McapReader reader(bench.boxes().front());
  EXPECT_TRUE(reader.has_end());
  EXPECT_EQ(reader.metadata(kFactsName)->at("fault"), "a drive of the head is at fault");
  const auto reports = all_of<recorded::BusReport>(reader, Topic::kBus);
  ASSERT_FALSE(reports.empty());
  const Time first{Duration(reports.front().stamp_ns)}, last{Duration(reports.back().stamp_ns)};
  EXPECT_NEAR(to_seconds(fault - first), 29, 0.1);
  EXPECT_NEAR(to_seconds(last - fault), 1, 0.1);
  std::string news;
  ASSERT_TRUE(recorder.news(news));
  EXPECT_NE(news.find(bench.boxes().front().string()), std::string::npos) << news;
}

TEST(BlackBox, ThinsPicturesInPairsToWhatItsMemoryHoldsOfTheWholeTime) {
  BoxBench bench;
  Recorder recorder(bench.boxed(), {}, bench.clock, {});
  bench.live(recorder, 60);
  recorder.fault("asked for");
  bench.live(recorder, 2);
  ASSERT_EQ(bench.boxes().size(), 1U);
  recording::McapReader reader(bench.boxes().front());
  auto n = counts(reader);
  EXPECT_EQ(n["/camera/left/image"], n["/camera/right/image"]);
  EXPECT_GE(n["/camera/left/image"], 30U);
  EXPECT_LE(n["/camera/left/image"] * 2 * 1200, 100'000U);
  Time first = Time::max();
  reader.for_each({*reader.channel("/camera/left/image")},
                  [&](const recording::McapMessage& m) { first = std::min(first, m.log_time); });
  EXPECT_LT(to_seconds(first), 62 - 27) << "the oldest picture is of the time's beginning";
}

TEST(BlackBox, IsWrittenOncePerFaultAndNotForEachOfMany) {
  BoxBench bench;
  Recorder recorder(bench.boxed(), {}, bench.clock, {});
  bench.live(recorder, 5);
  bench.live(recorder, 10, hal::HeadHealth::kFault);  // stays
  EXPECT_EQ(bench.boxes().size(), 1U);
  for (int i = 0; i < 10; ++i) {
    recorder.fault("again");
    bench.live(recorder, 1);
  }
  EXPECT_EQ(bench.boxes().size(), 1U);
  bench.live(recorder, 20);
  recorder.fault("much later");
  bench.live(recorder, 2);
  EXPECT_EQ(bench.boxes().size(), 2U);
}

TEST(BlackBox, IsWrittenAtTheEndWhereAFaultEndsTheProgram) {
  BoxBench bench;
  {
    Recorder recorder(bench.boxed(), {}, bench.clock, {});
    bench.live(recorder, 3);
    recorder.fault("a loop broke");
  }
  ASSERT_EQ(bench.boxes().size(), 1U);
  recording::McapReader reader(bench.boxes().front());
  EXPECT_EQ(reader.metadata(kFactsName)->at("fault"), "a loop broke");
}

TEST(BlackBox, TakesNoMemoryOnceItIsMade) {
  TemporaryFolder folder;
  BlackBox box({.folder = folder.path(), .bytes = 10'000, .picture_bytes = 10'000}, {});
  const std::vector<std::byte> row(700), picture(3000);
  const auto before = heap_allocations();
  for (int i = 0; i < 1000; ++i) {
    box.put({Topic::kBus, 0, at_seconds(i), row});
    box.put({Topic::kLeft, 0, at_seconds(i), picture});
  }
  EXPECT_EQ(heap_allocations(), before);
}

TEST(NewFault, IsADriveTheControlComputerOrAWalkThatTheyEnded) {
  BusReport before, now;
  before.walker = now.walker = hal::WalkerHealth::kReady;
  before.head.health = now.head.health = hal::HeadHealth::kReady;
  EXPECT_FALSE(new_fault(before, now));
  const auto with = [&](auto change) {
    BusReport report = now;
    change(report);
    EXPECT_FALSE(new_fault(report, report)) << "it is told once";
    return new_fault(before, report).has_value();
  };
  EXPECT_TRUE(with([](BusReport& r) { r.walk.state = hal::WalkState::kFault; }));
  EXPECT_TRUE(with([](BusReport& r) { r.walker = hal::WalkerHealth::kLost; }));
  EXPECT_TRUE(with([](BusReport& r) { r.head.health = hal::HeadHealth::kFault; }));
  using enum nav::StackStop;
  for (const nav::StackStop stop : {kRejected, kLost, kNoStart, kEnded, kRestarted})
    EXPECT_TRUE(with([&](BusReport& r) { r.last_stop = stop; }));
  for (const nav::StackStop stop : {kNone, kAsked, kMissed, kStale})  // a walk's own ways to end
    EXPECT_FALSE(with([&](BusReport& r) { r.last_stop = stop; }));
}

}  // namespace
}  // namespace headway::runtime
