// Oracle: can-calc-bit-timing of Debian's can-utils, which holds the Linux kernel's own calculation.
#include "drivers/bit_timing.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::drivers {
namespace {

constexpr std::uint32_t kCandleLightClock = 48'000'000;
constexpr BitTimingLimits kCandleLight{1, 16, 1, 8, 4, 1, 1024, 1};

/// The controllers that the tool knows, with their limits as the kernel's drivers have them.
const std::map<std::string, BitTimingLimits> kControllers = {
    {"sja1000", {1, 16, 1, 8, 4, 1, 64, 1}},
    {"flexcan", {4, 16, 2, 8, 4, 1, 256, 1}},
    {"mcp251x", {3, 16, 2, 8, 4, 1, 64, 1}},
    {"rcar_can", {4, 16, 2, 8, 4, 1, 1024, 1}},
};

std::string run(const std::string& command) {
  std::string said;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return said;
  char line[256];
  while (std::fgets(line, sizeof line, pipe) != nullptr) said += line;
  pclose(pipe);
  return said;
}

bool oracle_is_there() { return run("can-calc-bit-timing -l").find("sja1000") != std::string::npos; }

/// Nothing when the tool finds the bit rate impossible.
std::optional<BitTiming> oracle(const std::string& controller, std::uint32_t clock, std::uint32_t bitrate,
                                int sample_point_per_mille) {
  std::ostringstream command;
  command << "can-calc-bit-timing -q -b " << bitrate << " -s " << sample_point_per_mille << " -c " << clock
          << ' ' << controller;
  std::istringstream line(run(command.str()));
  std::uint32_t rate = 0, quantum_ns = 0;
  BitTiming t;
  line >> rate >> quantum_ns >> t.prop_seg >> t.phase_seg1 >> t.phase_seg2 >> t.sjw >> t.brp;
  if (!line) return std::nullopt;
  return t;
}

TEST(BitTiming, IsTheKernelsAt500KilobitOnACandleLight) {
  EXPECT_EQ(find_bit_timing(kCandleLight, kCandleLightClock, 500'000, 0.875), (BitTiming{6, 7, 2, 1, 6}));
}

TEST(BitTiming, IsTheKernelsWhereThatIsExactAndNeverWorse) {
  if (!oracle_is_there()) GTEST_SKIP() << "can-calc-bit-timing is not installed (Debian's can-utils)";
  int compared = 0, equal = 0;
  for (const auto& [name, limits] : kControllers) {
    for (const std::uint32_t clock : {8'000'000u, 16'000'000u, 24'000'000u, 36'000'000u, 40'000'000u,
                                      48'000'000u, 66'660'000u, 80'000'000u}) {
      for (const std::uint32_t bitrate :
           {20'000u, 50'000u, 125'000u, 250'000u, 500'000u, 800'000u, 1'000'000u}) {
        for (const int sample_point : {750, 800, 875}) {
          SCOPED_TRACE(name + " at " + std::to_string(clock) + " Hz, " + std::to_string(bitrate) +
                       " bit/s, " + std::to_string(sample_point));
          const auto theirs = oracle(name, clock, bitrate, sample_point);
          const auto ours = find_bit_timing(limits, clock, bitrate, sample_point / 1000.0);
          if (!theirs || std::abs(theirs->bitrate(clock) / bitrate - 1) > kBitRateTolerance) continue;
          ASSERT_TRUE(ours);
          ++compared;
          const double our_rate = std::abs(ours->bitrate(clock) - bitrate),
                       their_rate = std::abs(theirs->bitrate(clock) - bitrate);
          EXPECT_LE(our_rate, their_rate + 1e-6);
          if (our_rate < their_rate - 1e-6) continue;
          const double our_point = std::abs(ours->sample_point() - sample_point / 1000.0),
                       their_point = std::abs(theirs->sample_point() - sample_point / 1000.0);
          EXPECT_LE(our_point, their_point + 0.001);  // the tool counts in 0.1 %
          if (their_rate == 0 && their_point == 0) {
            ++equal;
            BitTiming with_their_jump = *ours;
            with_their_jump.sjw = theirs->sjw;  // the tool always says 1
            EXPECT_EQ(with_their_jump, *theirs);
          }
        }
      }
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(equal, 100);
}

RC_GTEST_PROP(BitTiming, KeepsTheLimitsWhateverTheController,
              (std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d, std::uint16_t e)) {
  BitTimingLimits l;
  l.tseg1_min = a % 8u;
  l.tseg1_max = l.tseg1_min + 2 + b % 64u;
  l.tseg2_min = c % 4u;
  l.tseg2_max = l.tseg2_min + 1 + d % 16u;
  l.sjw_max = 1 + d % 4u;
  l.brp_min = 1 + e % 3u;
  l.brp_increment = 1 + e % 2u;
  l.brp_max = l.brp_min + e % 512u;
  const auto clock = *rc::gen::inRange(1'000'000u, 200'000'000u);
  const auto bitrate = *rc::gen::element(10'000u, 125'000u, 500'000u, 1'000'000u);
  const double point = *rc::gen::inRange(500, 950) / 1000.0;
  const auto t = find_bit_timing(l, clock, bitrate, point);
  if (!t) return;
  const std::uint32_t tseg1 = t->prop_seg + t->phase_seg1;
  RC_ASSERT(tseg1 >= l.tseg1_min && tseg1 <= l.tseg1_max && t->prop_seg >= 1u);
  RC_ASSERT(t->phase_seg2 >= l.tseg2_min && t->phase_seg2 <= l.tseg2_max && t->phase_seg2 >= 1u);
  RC_ASSERT(t->sjw >= 1u && t->sjw <= l.sjw_max && t->sjw <= t->phase_seg2);
  RC_ASSERT(t->brp >= l.brp_min && t->brp <= l.brp_max && (t->brp - l.brp_min) % l.brp_increment == 0u);
  RC_ASSERT(std::abs(t->bitrate(clock) / bitrate - 1) <= kBitRateTolerance);
}

RC_GTEST_PROP(BitTiming, NeverMissesABitRateThatIsThere, (std::uint8_t a, std::uint8_t b, std::uint16_t c)) {
  BitTiming planted;
  planted.prop_seg = 1 + a % 8u;
  planted.phase_seg1 = 1 + a / 8u % 8u;
  planted.phase_seg2 = 1 + b % 8u;
  planted.brp = 1 + c % 1024u;
  const std::uint32_t bitrate = 10'000u + c;
  const std::uint32_t clock = bitrate * planted.brp * planted.quanta();
  RC_PRE(planted.bitrate(clock) == bitrate);
  const auto found = find_bit_timing(kCandleLight, clock, bitrate, planted.sample_point());
  RC_ASSERT(found.has_value());
  RC_ASSERT(found->bitrate(clock) == bitrate);
  RC_ASSERT(std::abs(found->sample_point() - planted.sample_point()) < 1e-12);
}

TEST(BitTiming, IsNotFoundWhereThereIsNone) {
  EXPECT_FALSE(find_bit_timing(kCandleLight, 1'000'000, 500'000, 0.875));  // two quanta a bit
  EXPECT_FALSE(find_bit_timing(kCandleLight, 11'111'111, 1'000'000, 0.875));
  EXPECT_FALSE(find_bit_timing(kCandleLight, kCandleLightClock, 0, 0.875));
  EXPECT_FALSE(find_bit_timing(kCandleLight, 0, 500'000, 0.875));
}

TEST(BitTiming, IsNotLookedForWithinLimitsOfNoController) {
  EXPECT_FALSE(find_bit_timing({}, kCandleLightClock, 500'000, 0.875));
  for (const auto member :
       {&BitTimingLimits::brp_min, &BitTimingLimits::brp_max, &BitTimingLimits::brp_increment,
        &BitTimingLimits::sjw_max, &BitTimingLimits::tseg1_max, &BitTimingLimits::tseg2_max}) {
    BitTimingLimits broken = kCandleLight;
    broken.*member = 0;
    EXPECT_FALSE(find_bit_timing(broken, kCandleLightClock, 500'000, 0.875));
  }
  BitTimingLimits endless = kCandleLight;
  endless.tseg1_max = 0xFFFFFFFF;
  EXPECT_FALSE(find_bit_timing(endless, kCandleLightClock, 500'000, 0.875));
}

}  // namespace
}  // namespace headway::drivers
