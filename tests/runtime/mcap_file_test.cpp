// MCAP files: what is written is read, what is cut or damaged is read as far as it is whole, and nothing does
// harm.
#include <algorithm>
#include <random>
#include <tuple>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "runtime/recording/mcap_reader.h"
#include "runtime/recording/mcap_writer.h"
#include "runtime/recording/ros_messages.h"
#include "tests/runtime/memory_sink.h"

namespace headway::recording {
namespace {

using Bytes = std::vector<std::byte>;

/// One message, as it is compared.
using Said = std::tuple<std::uint16_t, std::uint32_t, Time, Bytes>;

McapReader reader_of(const Bytes& bytes) {
  return McapReader(std::make_unique<MemorySource>(bytes), "test.mcap");
}

std::vector<Said> messages_of(McapReader& reader, const std::set<std::uint16_t>& channels = {}) {
  std::vector<Said> all;
  reader.for_each(channels, [&](const McapMessage& m) {
    all.emplace_back(m.channel, m.sequence, m.log_time, Bytes(m.bytes.begin(), m.bytes.end()));
  });
  return all;
}

/// A file with messages of two topics, an attachment and metadata in between.
struct Written {
  MemorySink sink;
  std::vector<Said> said;
  std::vector<std::size_t> in_chunk;  ///< how many messages were there when each chunk had been handed over
  std::vector<std::uint64_t> chunk_ends;
  Bytes attached{std::byte{1}, std::byte{2}, std::byte{3}};
};

void write(Written& w, std::uint64_t seed, std::size_t count, bool finish = true) {
  std::mt19937_64 dice(seed);
  McapWriter writer(w.sink, {.chunk_bytes = 2000, .chunk_time = seconds(0.5), .level = 1, .library = "test"});
  const std::array channels{writer.add_channel<ros::Time>("/one"), writer.add_channel<ros::Header>("/two")};
  writer.add_metadata("facts", {{"robot", "HRP-2"}, {"empty", ""}});
  Time t{};
  std::uint64_t size = writer.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i == count / 2) writer.attach("rig.yaml", "application/yaml", t, w.attached);
    size = writer.size();
    t += Duration(static_cast<Duration::rep>(dice() % 50'000'000));
    Bytes data(dice() % 400);
    for (std::byte& b : data) b = static_cast<std::byte>(dice() % 7);
    const std::uint16_t channel = channels[dice() % 2];
    writer.write(channel, static_cast<std::uint32_t>(i), t, t, data);
    if (writer.size() != size) {  // a chunk was handed over: with this message, or before it
      w.in_chunk.push_back(writer.waiting() == 0 ? i + 1 : i);
      w.chunk_ends.push_back(writer.size());
    }
    w.said.emplace_back(channel, static_cast<std::uint32_t>(i), t, std::move(data));
  }
  if (finish) writer.finish();
}

RC_GTEST_PROP(McapFile, GivesBackWhatWasWritten, (std::uint64_t seed)) {
  Written w;
  write(w, seed, seed % 200);
  McapReader reader = reader_of(w.sink.bytes);
  RC_ASSERT(reader.has_end());
  RC_ASSERT(reader.profile() == "ros2");
  RC_ASSERT(reader.library() == "test");
  RC_ASSERT(messages_of(reader) == w.said);
  RC_ASSERT(reader.sum_is_right() == true);
  RC_ASSERT(reader.losses().empty());
  RC_ASSERT(reader.statistics()->messages == w.said.size());
  RC_ASSERT(reader.channels().at(0).topic == "/one");
  RC_ASSERT(reader.schemas().at(reader.channels().at(1).schema).name == ros::Header::kName);
  RC_ASSERT(reader.metadata("facts") ==
            (std::map<std::string, std::string>{{"robot", "HRP-2"}, {"empty", ""}}));
  if (!w.said.empty()) RC_ASSERT(reader.attachment("rig.yaml")->data == w.attached);
  std::vector<Said> of_one;
  std::ranges::copy_if(w.said, std::back_inserter(of_one), [](const Said& s) { return std::get<0>(s) == 0; });
  if (!w.said.empty()) RC_ASSERT(messages_of(reader, {0}) == of_one);
}

RC_GTEST_PROP(McapFile, CutAnywhereGivesAllUpToItsLastWholeChunk, (std::uint64_t seed)) {
  Written w;
  write(w, seed, 100 + seed % 100);
  const std::size_t cut = seed / 7 % w.sink.bytes.size();
  const Bytes front(w.sink.bytes.begin(), w.sink.bytes.begin() + static_cast<std::ptrdiff_t>(cut));
  std::size_t whole = 0;  // messages that lie in chunks that lie whole before the cut, indexes and all
  for (std::size_t i = 0; i < w.chunk_ends.size(); ++i)
    if (w.chunk_ends[i] <= cut) whole = w.in_chunk[i];
  try {
    McapReader reader = reader_of(front);
    const std::vector<Said> read = messages_of(reader);
    RC_ASSERT(read.size() >= whole);
    RC_ASSERT(std::equal(read.begin(), read.end(), w.said.begin()));
    RC_ASSERT(!reader.has_end());
    RC_ASSERT(!reader.losses().empty());
  } catch (const InputError&) {
    RC_ASSERT(whole == 0U);
    RC_ASSERT(cut < 60U);  // within the header
  }
}

RC_GTEST_PROP(McapFile, WithDamagedBytesGivesNoMessageThatWasNotWritten, (std::uint64_t seed)) {
  Written w;
  write(w, seed, 100);
  std::mt19937_64 dice(seed);
  Bytes bytes = w.sink.bytes;
  for (std::size_t i = 0; i < 1 + seed % 4; ++i)
    bytes[dice() % bytes.size()] ^= static_cast<std::byte>(1 + dice() % 255);
  try {
    McapReader reader = reader_of(bytes);
    for (const Said& said : messages_of(reader)) RC_ASSERT(std::ranges::find(w.said, said) != w.said.end());
    if (const auto file = reader.attachment("rig.yaml")) RC_ASSERT(file->data == w.attached);
  } catch (const InputError&) {
  }
}

RC_GTEST_PROP(McapFile, NoBytesDoHarm, (std::vector<std::uint8_t> noise)) {
  Written w;
  write(w, noise.size(), 5);
  Bytes bytes(w.sink.bytes.begin(), w.sink.bytes.begin() + 100);
  for (const std::uint8_t b : noise) bytes.push_back(static_cast<std::byte>(b));
  McapReader reader = reader_of(bytes);
  messages_of(reader);
}

TEST(McapFile, ADamagedChunkIsLeftOutAndNamed) {
  Written w;
  write(w, 3, 200);
  McapReader whole = reader_of(w.sink.bytes);
  ASSERT_GT(whole.chunks().size(), 3U);
  const McapChunkIndex chunk = whole.chunks()[1];
  w.sink.bytes[static_cast<std::size_t>(chunk.at + chunk.bytes) - 3] ^= std::byte{0x10};
  McapReader reader = reader_of(w.sink.bytes);
  const std::vector<Said> read = messages_of(reader);
  EXPECT_EQ(read.size(), w.said.size() - (w.in_chunk[1] - w.in_chunk[0]));
  ASSERT_EQ(reader.losses().size(), 1U);
  EXPECT_EQ(reader.losses().front().at, chunk.at);
  EXPECT_NE(reader.losses().front().what.find("damaged chunk"), std::string::npos);
  EXPECT_EQ(reader.sum_is_right(), false);
}

TEST(McapFile, WithADamagedSummaryIsReadFromItsStart) {
  Written w;
  write(w, 4, 150);
  w.sink.bytes[w.sink.bytes.size() - 60] ^= std::byte{0x01};
  McapReader reader = reader_of(w.sink.bytes);
  EXPECT_FALSE(reader.has_end());
  EXPECT_EQ(messages_of(reader), w.said);
  ASSERT_EQ(reader.losses().size(), 1U);
  EXPECT_NE(reader.losses().front().what.find("index"), std::string::npos);
}

TEST(McapFile, ThatIsNoneIsRefusedInOneLine) {
  for (const char* text :
       {"", "MCAP", "\x89MCAP0\r\n", "\x89MCAP1\r\nsomething that is long enough to be one"}) {
    const std::string bytes = text;
    const Bytes raw(std::as_bytes(std::span(bytes)).begin(), std::as_bytes(std::span(bytes)).end());
    try {
      reader_of(raw);
      FAIL() << "was taken";
    } catch (const InputError& fault) {
      EXPECT_EQ(std::string(fault.what()),
                "test.mcap: is no recording, expected an MCAP file of version 0 (.mcap)");
    }
  }
}

TEST(McapFile, SizesThatCannotBeAreNotAllocated) {
  Written w;
  write(w, 5, 50, false);
  McapReader before = reader_of(w.sink.bytes);
  ASSERT_FALSE(before.chunks().empty());
  // The chunk's own size, and what it says that it will be unpacked.
  for (const std::uint64_t at : {before.chunks()[0].at + 1, before.chunks()[0].at + kRecordHead + 16}) {
    Bytes bytes = w.sink.bytes;
    for (std::size_t i = 0; i < 7; ++i) bytes[static_cast<std::size_t>(at) + i] = std::byte{0x7F};
    McapReader reader = reader_of(bytes);
    messages_of(reader);
    EXPECT_FALSE(reader.losses().empty());
  }
}

TEST(McapFile, ADiskThatFillsUpLeavesAFileThatIsWhole) {
  Written whole;
  write(whole, 6, 300);
  for (const double share : {0.2, 0.4, 0.6}) {
    MemorySink sink;
    sink.room = static_cast<std::size_t>(share * static_cast<double>(whole.sink.bytes.size()));
    McapWriter writer(sink, {.chunk_bytes = 2000, .chunk_time = seconds(0.5), .level = 1, .library = "test"});
    const std::uint16_t one = writer.add_channel<ros::Time>("/one"),
                        two = writer.add_channel<ros::Header>("/two");
    bool full = false;
    std::size_t i = 0;
    for (; i < whole.said.size() && !full; ++i) {
      const auto& [channel, sequence, time, data] = whole.said[i];
      try {
        writer.write(channel == 0 ? one : two, sequence, time, time, data);
      } catch (const Error&) {
        full = true;
      }
    }
    ASSERT_TRUE(full);
    sink.room += 4096;  // the end fits only where somebody made room, or left some
    EXPECT_TRUE(writer.cut_short());
    McapReader reader = reader_of(sink.bytes);
    EXPECT_TRUE(reader.has_end());
    EXPECT_EQ(reader.sum_is_right(), true);
    const std::vector<Said> read = messages_of(reader);
    EXPECT_TRUE(reader.losses().empty());
    EXPECT_GT(read.size(), i / 2);
    EXPECT_TRUE(std::equal(read.begin(), read.end(), whole.said.begin()));
  }
}

TEST(McapFile, ADiskThatLetsNothingBeMendedLeavesWhatWasWhole) {
  MemorySink sink;
  McapWriter writer(sink, {.chunk_bytes = 500, .chunk_time = seconds(0.5), .level = 1, .library = "test"});
  const std::uint16_t one = writer.add_channel<ros::Time>("/one");
  const Bytes data(200, std::byte{5});
  for (std::uint32_t i = 0; i < 9; ++i) writer.write(one, i, Time(Duration(i)), Time(Duration(i)), data);
  sink.room = sink.bytes.size() + 40;
  sink.cuts_refused = true;
  EXPECT_THROW(writer.finish(); writer.end_chunk(), Error);
  EXPECT_FALSE(writer.cut_short());
  McapReader reader = reader_of(sink.bytes);
  EXPECT_EQ(messages_of(reader).size(), 9U);
  EXPECT_FALSE(reader.losses().empty());
}

TEST(McapFile, AChunkEndsBySizeAndByTime) {
  MemorySink sink;
  McapWriter writer(sink);
  const std::uint16_t one = writer.add_channel<ros::Time>("/one");
  const Bytes small(10, std::byte{1}), large(1 << 20, std::byte{2});
  writer.write(one, 0, at_seconds(1), at_seconds(1), small);
  writer.write(one, 1, at_seconds(1.4), at_seconds(1.4), small);
  const std::uint64_t before = writer.size();
  writer.write(one, 2, at_seconds(1.6), at_seconds(1.6), small);
  EXPECT_GT(writer.size(), before) << "the first two are half a second older";
  const std::uint64_t then = writer.size();
  writer.write(one, 3, at_seconds(1.6), at_seconds(1.6), large);
  EXPECT_GT(writer.size(), then) << "a mebibyte is there";
  EXPECT_EQ(writer.waiting(), 0U);
  writer.finish();
  McapReader reader = reader_of(sink.bytes);
  EXPECT_EQ(reader.chunks().size(), 2U);
  EXPECT_EQ(messages_of(reader).size(), 4U);
}

}  // namespace
}  // namespace headway::recording
