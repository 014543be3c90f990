// Plans of faults: what is written is what is read, what is wrong is named, and what is drawn is even.
#include "sim_hal/fault_file.h"

#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "sim_hal/fault_schedule.h"
#include "sim_hal/random_faults.h"
#include "tests/source_dir/source_dir.h"

namespace headway::sim {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

FaultPlan read(const std::string& text) { return faults_from(config::Section::parse(text, "f.yaml")); }

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& fault) {
    return fault.what();
  }
  return "";
}

/// As a person would write it down.
std::string written(const FaultPlan& plan) {
  std::string text = "faults:\n";
  for (const Fault& f : plan) {
    const FaultTraits& kind = traits(f.kind);
    text += fmt::format("  - kind: {}\n    begin_s: {}\n", kind.name, to_seconds(f.begin));
    if (f.after == FaultClock::kFirstStep) text += "    after: first_step\n";
    if (kind.uses.length) text += fmt::format("    length_s: {}\n", to_seconds(f.length));
    if (kind.uses.share) text += fmt::format("    share: {}\n", f.share);
    if (kind.uses.id && f.id != kAnyId) text += fmt::format("    id: {}\n", f.id);
    if (kind.uses.delay) text += fmt::format("    delay_s: {}\n", to_seconds(f.delay));
    if (kind.uses.noise) text += fmt::format("    noise: {}\n", f.noise);
    if (kind.uses.light) text += fmt::format("    light: {}\n", f.light);
    if (kind.uses.jump) text += fmt::format("    jump_s: {}\n", to_seconds(f.jump));
  }
  return plan.empty() ? "faults: []\n" : text;
}

bool same(const Fault& a, const Fault& b) {
  return a.kind == b.kind && a.after == b.after && a.begin == b.begin && a.length == b.length &&
         a.share == b.share && a.id == b.id && a.delay == b.delay && a.noise == b.noise &&
         a.light == b.light && a.jump == b.jump;
}

RC_GTEST_PROP(FaultFile, IsReadAsItIsWritten, ()) {
  FaultPlan plan = random_faults(*rc::gen::arbitrary<std::uint64_t>(), {.fewest = 0, .most = 8});
  for (Fault& fault : plan) {
    if (*rc::gen::arbitrary<bool>()) fault.after = FaultClock::kPowerOn;
    if (traits(fault.kind).uses.id && *rc::gen::arbitrary<bool>())
      fault.id = static_cast<std::uint32_t>(*rc::gen::inRange(0, 0x800));
  }
  const FaultPlan again = read(written(plan));
  RC_ASSERT(again.size() == plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) RC_ASSERT(same(again[i], plan[i]));
}

RC_GTEST_PROP(FaultFile, NamesTheLineOfAKeyThatIsMisspelt, ()) {
  const FaultPlan plan = random_faults(*rc::gen::arbitrary<std::uint64_t>(), {.fewest = 1, .most = 5});
  std::string text = written(plan);
  const auto count = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  const int line = *rc::gen::inRange(1, count);  // not the first, which is the list's
  std::size_t at = 0;
  for (int i = 0; i < line; ++i) at = text.find('\n', at) + 1;
  text.insert(text.find(':', at), "x");
  const std::string what = complaint(text);
  RC_ASSERT(what.starts_with(fmt::format("f.yaml:{}: faults[", line + 1)));
  RC_ASSERT(what.find("did you mean") != what.npos);
}

TEST(FaultFile, NamesAKindThatThereIsNot) {
  EXPECT_THAT(
      complaint("faults:\n  - {kind: drak, begin_s: 1, length_s: 1, light: 0}\n"),
      StartsWith("f.yaml:2: faults[0].kind: 'drak' (did you mean 'dark'?), expected one of: frame_loss, "));
}

TEST(FaultFile, TakesNoKeyThatItsKindDoesNotRead) {
  EXPECT_THAT(complaint("faults:\n  - {kind: bus_off, begin_s: 1, length_s: 1, light: 0}\n"),
              AllOf(StartsWith("f.yaml:2: faults[0].light: is not a key here"), HasSubstr("length_s")));
}

TEST(FaultFile, WantsWhatItsKindNeeds) {
  EXPECT_THAT(complaint("faults:\n  - {kind: frame_delay, begin_s: 1, length_s: 1}\n"),
              AllOf(StartsWith("f.yaml:2: faults[0]"), HasSubstr("'delay_s' is missing")));
  EXPECT_THAT(
      complaint("faults:\n  - {kind: can_loss, begin_s: -1, length_s: 1}\n"),
      AllOf(StartsWith("f.yaml:2: faults[0].begin_s: '-1', expected a number from 0"), HasSubstr(" s")));
  EXPECT_THAT(complaint("fault:\n  - {kind: bus_off, begin_s: 1, length_s: 1}\n"),
              AllOf(StartsWith("f.yaml:1: fault: "), HasSubstr("did you mean 'faults'?")));
  EXPECT_THAT(complaint("{}\n"), HasSubstr("the key 'faults' is missing"));
}

TEST(FaultFile, ThatIsGivenAsAnExampleCanBeRead) {
  EXPECT_EQ(read_faults(source_dir() / "config/faults/three.yaml").size(), 3U);
}

TEST(FaultKinds, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (const FaultTraits& kind : fault_kinds()) names.insert(kind.name);
  EXPECT_EQ(names.size(), fault_kinds().size());
}

RC_GTEST_PROP(FaultSchedule, IsOnFromItsBeginningUpToItsEnd, ()) {
  const auto ms = [](int low, int high) { return std::chrono::milliseconds(*rc::gen::inRange(low, high)); };
  const Time power_on = Time(ms(0, 5000)), step = power_on + ms(0, 9000);
  const Fault fault{.kind = FaultKind::kDark,
                    .after = *rc::gen::arbitrary<bool>() ? FaultClock::kFirstStep : FaultClock::kPowerOn,
                    .begin = ms(0, 3000),
                    .length = ms(0, 3000)};
  FaultSchedule schedule({fault}, power_on);
  const bool waits = fault.after == FaultClock::kFirstStep;
  RC_ASSERT(schedule.begin(0).has_value() != waits);
  schedule.first_step(step);
  schedule.first_step(step + seconds(1));  // only the first counts
  const Time from = (waits ? step : power_on) + fault.begin, now = Time(ms(0, 22000));
  RC_ASSERT(schedule.on(0, now) == (now >= from && now < from + fault.length));
  RC_ASSERT(schedule.any(FaultKind::kDark, now) == schedule.on(0, now));
  RC_ASSERT(!schedule.any(FaultKind::kNoise, now));
}

TEST(RandomFaults, DrawEveryKindAsOftenAsAnyOther) {
  std::map<FaultKind, int> drawn;
  int all = 0;
  std::map<std::size_t, int> sizes;
  for (std::uint64_t seed = 0; seed < 5000; ++seed) {
    const FaultPlan plan = random_faults(seed);
    ++sizes[plan.size()];
    for (const Fault& fault : plan) ++drawn[fault.kind], ++all;
  }
  EXPECT_EQ(sizes.size(), 3U);
  EXPECT_EQ(sizes.begin()->first, 1U);
  // Chi squared of 24 degrees of freedom exceeds 51.2 once in a thousand times.
  const double expected = all / static_cast<double>(fault_kinds().size());
  double chi = 0;
  for (const FaultTraits& kind : fault_kinds()) chi += std::pow(drawn[kind.kind] - expected, 2) / expected;
  EXPECT_LT(chi, 51.2);
}

RC_GTEST_PROP(RandomFaults, AreTheSameForTheSameSeedAndLieWithinTheWalk, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  const Duration walk = seconds(*rc::gen::inRange(1, 40));
  const FaultPlan plan = random_faults(seed, {.walk = walk}), again = random_faults(seed, {.walk = walk});
  RC_ASSERT(plan.size() == again.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    RC_ASSERT(same(plan[i], again[i]));
    RC_ASSERT(plan[i].begin <= walk + seconds(0.001) && plan[i].after == FaultClock::kFirstStep);
  }
  validate(plan);
}

}  // namespace
}  // namespace headway::sim
