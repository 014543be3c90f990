#include "tests/hil/emulated_uvc.h"

#include <algorithm>
#include <chrono>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::hil {
namespace {

using namespace std::chrono_literals;

constexpr EmulatedUvc::Config kSmall{.serial = "C1", .width = 16, .height = 4};
constexpr std::uint32_t kInterval = 666'666;  // 100 ns
constexpr auto kPeriod = Duration(std::int64_t{kInterval} * 100);

class Bench {
 public:
  Bench() { start(); }

  void start() {
    Bytes commit{1, 0, 1, 1};
    append_le(commit, kInterval, 4);
    commit.resize(26);
    camera.request({.request_type = 0x21, .request = 1, .value = 0x0200, .index = 1, .length = 26}, commit);
  }
  std::optional<Bytes> read(std::size_t room = 16384) { return camera.send(EmulatedUvc::kIn, room); }

  hal::ManualClock clock;
  Bytes filmed = Bytes(64, 7);
  int frames = 0;
  EmulatedUvc camera{kSmall,
                     [this] {
                       ++frames;
                       return ByteSpan(filmed);
                     },
                     clock};
};

bool ends_frame(const Bytes& payload) { return (payload[1] & 2) != 0; }
int parity(const Bytes& payload) { return payload[1] & 1; }

RC_GTEST_PROP(EmulatedUvc, SendsFramesWholeInPayloadsOfAnyRoom, ()) {
  Bench bench;
  int before = -1;
  for (int i = 0; i < 3; ++i, bench.clock.advance(kPeriod)) {
    bench.filmed = *rc::gen::container<Bytes>(64, rc::gen::arbitrary<std::uint8_t>());
    Bytes read;
    for (bool last = false; !last;) {
      const auto room = *rc::gen::inRange<std::size_t>(3, 100);
      const auto payload = bench.read(room);
      RC_ASSERT(payload && payload->size() <= room && payload->size() > 2 && (*payload)[0] == 2);
      RC_ASSERT(parity(*payload) != before);
      read.insert(read.end(), payload->begin() + 2, payload->end());
      last = ends_frame(*payload);
      if (last) before = parity(*payload);
    }
    RC_ASSERT(read == bench.filmed);
  }
}

TEST(EmulatedUvc, FilmsAtTheRateThatWasAgreedAndCatchesUpWithNothing) {
  Bench bench;
  EXPECT_TRUE(bench.read());
  EXPECT_FALSE(bench.read());
  EXPECT_EQ(bench.camera.due(), Time(kPeriod));
  bench.clock.advance(kPeriod - 1ns);
  EXPECT_FALSE(bench.read());
  bench.clock.advance(1ns);
  EXPECT_TRUE(bench.read());

  bench.clock.advance(10 * kPeriod);
  EXPECT_TRUE(bench.read());
  EXPECT_TRUE(bench.read()) << "due at once";
  EXPECT_FALSE(bench.read()) << "and no burst";
  EXPECT_EQ(bench.frames, 4);
}

TEST(EmulatedUvc, CutsOneFrameInHalf) {
  Bench bench;
  bench.camera.cut_next_frame();
  const auto half = bench.read();
  EXPECT_EQ(half->size(), 2u + 32u);
  EXPECT_TRUE(ends_frame(*half));
  bench.clock.advance(kPeriod);
  EXPECT_EQ(bench.read()->size(), 2u + 64u);
}

TEST(EmulatedUvc, SendsAJpegImageAsLongAsItIs) {
  hal::ManualClock clock;
  Bytes image(20, 7);
  EmulatedUvc camera(
      {.width = 16, .height = 4, .format = EmulatedUvc::Config::Format::kMjpeg},
      [&] { return ByteSpan(image); }, clock);
  Bytes commit{1, 0, 1, 1};
  append_le(commit, kInterval, 4);
  commit.resize(26);
  camera.request({.request_type = 0x21, .request = 1, .value = 0x0200, .index = 1, .length = 26}, commit);
  EXPECT_EQ(camera.send(EmulatedUvc::kIn, 16384)->size(), 2u + 20u);
}

TEST(EmulatedUvc, SendsNothingWhilePaused) {
  Bench bench;
  bench.camera.pause(true);
  EXPECT_FALSE(bench.read());
  EXPECT_FALSE(bench.camera.due());
  bench.camera.pause(false);
  EXPECT_TRUE(bench.read());
}

TEST(EmulatedUvc, StopsWhenTheHaltIsClearedAndBeginsWithAWholeFrame) {
  Bench bench;
  bench.read(10);
  bench.camera.halt_cleared(EmulatedUvc::kIn);
  EXPECT_FALSE(bench.read());
  bench.start();
  EXPECT_EQ(bench.read()->size(), 2u + 64u);
}

TEST(EmulatedUvc, RefusesASizeThatNoFormatHas) {
  hal::ManualClock clock;
  EXPECT_THROW(EmulatedUvc(
                   {.width = 15}, [] { return ByteSpan(); }, clock),
               InputError);
}

}  // namespace
}  // namespace headway::hil
