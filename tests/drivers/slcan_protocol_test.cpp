// The lines of the slcan protocol: what is written is read again, and no garbage spoils what follows it.
#include "drivers/slcan_protocol.h"

#include <cctype>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

using Event = SlcanReader::Event;
using ::testing::ElementsAre;

hal::CanFrame any_frame() {
  hal::CanFrame frame{.id = *rc::gen::inRange<std::uint32_t>(0, 0x800),
                      .dlc = *rc::gen::inRange<std::uint8_t>(0, 9)};
  for (std::size_t i = 0; i < frame.dlc; ++i) frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
  return frame;
}

bool same(const hal::CanFrame& a, const hal::CanFrame& b) {
  return a.id == b.id && a.dlc == b.dlc && a.data == b.data;
}

std::string line_of(const hal::CanFrame& frame) { return std::string(SlcanLine(frame).text()); }

std::vector<Event> events_of(std::string_view text) {
  SlcanReader reader;
  std::vector<Event> events;
  for (const char c : text)
    if (const Event e = reader.feed(c); e != Event::kNone) events.push_back(e);
  return events;
}

TEST(SlcanLine, IsWrittenAsTheManualSays) {
  EXPECT_EQ(line_of({.id = 0x100, .dlc = 0}), "t1000\r");
  EXPECT_EQ(line_of({.id = 0x7FF, .dlc = 8, .data = {0xA0, 0x1B, 2, 3, 4, 5, 6, 7}}),
            "t7FF8A01B020304050607\r");
}

TEST(SlcanReader, ReadsWhatTheManualShows) {
  EXPECT_THAT(events_of("t10021133\r"), ElementsAre(Event::kFrame));
  EXPECT_THAT(events_of("t10021133ABCD\r"), ElementsAre(Event::kFrame)) << "with a time stamp";
  EXPECT_THAT(events_of("t7ff1ab\r"), ElementsAre(Event::kFrame)) << "in small letters";
  EXPECT_THAT(events_of("\r\az\rZ\r"),
              ElementsAre(Event::kDone, Event::kRefused, Event::kDone, Event::kDone));
  EXPECT_THAT(events_of("T0000010021133\rr1002\rR000001002\r"),
              ElementsAre(Event::kUnusable, Event::kUnusable, Event::kUnusable));
}

TEST(SlcanReader, TakesNoLineThatIsNearlyAFrame) {
  for (const char* line :
       {"t", "t10", "t100", "t8000", "t1009", "t100g", "tx000", "t1002113", "t100211333", "t10021g33",
        "t10021133ABC", "t10021133ABCG", "t100A", "1002", "t10021133\n", "V1013", "t100 0"})
    EXPECT_THAT(events_of(std::string(line) + "\r"), ElementsAre(Event::kUnusable)) << line;
}

RC_GTEST_PROP(SlcanReader, ReadsEveryFrameThatIsWritten, ()) {
  SlcanReader reader;
  for (int i = 0; i < 20; ++i) {
    const hal::CanFrame frame = any_frame();
    Event last = Event::kNone;
    for (const char c : line_of(frame)) {
      RC_ASSERT(last == Event::kNone);
      last = reader.feed(c);
    }
    RC_ASSERT(last == Event::kFrame);
    RC_ASSERT(same(reader.frame(), frame));
  }
}

RC_GTEST_PROP(SlcanReader, IsInStepAgainAfterTheNextCarriageReturn, ()) {
  SlcanReader reader;
  for (const char c : *rc::gen::arbitrary<std::string>()) reader.feed(c);
  reader.feed('\r');
  const hal::CanFrame frame = any_frame();
  Event last = Event::kNone;
  for (const char c : line_of(frame)) last = reader.feed(c);
  RC_ASSERT(last == Event::kFrame);
  RC_ASSERT(same(reader.frame(), frame));
}

RC_GTEST_PROP(SlcanReader, TakesOnlyWhatWouldBeWrittenForTheFrame, ()) {
  std::string line = line_of(any_frame());
  line.pop_back();
  const std::size_t at = *rc::gen::inRange<std::size_t>(0, line.size());
  const std::string spoilt =
      *rc::gen::container<std::string>(rc::gen::elementOf(std::string("0189AFafgtrTz \n")));
  line.replace(at, *rc::gen::inRange<std::size_t>(0, 4), spoilt);
  SlcanReader reader;
  Event last = Event::kNone;
  for (const char c : line + "\r") last = reader.feed(c);
  if (last != Event::kFrame) return;
  for (std::size_t i = 1; i < line.size(); ++i) line[i] = static_cast<char>(std::toupper(line[i]));
  const std::string written = line_of(reader.frame());
  const std::string plain = written.substr(0, written.size() - 1);
  RC_ASSERT(line.starts_with(plain));
  RC_ASSERT(line.size() == plain.size() || line.size() == plain.size() + 4);  // an adapter's stamp
}

TEST(SlcanReader, ATooLongLineIsOneUnusableLine) {
  EXPECT_THAT(events_of(std::string(1000, 't') + "\rt1000\r"), ElementsAre(Event::kUnusable, Event::kFrame));
}

}  // namespace
}  // namespace headway::drivers
