// Walks on which things go wrong: what the robot does about each, and whether the judge of that would notice
// if it did not.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "app/fault_check.h"
#include "app/fault_totals.h"
#include "app/sim_outputs.h"
#include "app/sim_session.h"
#include "sim_hal/random_faults.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using sim::Fault, sim::FaultClock, sim::FaultKind;
using test::run_headway;

const std::filesystem::path kTree = source_dir();

Robot hrp2() {
  Robot robot = read_robot(kTree / "config/hrp2/robot.yaml");
  robot.simulation.frame_rate = 5;
  return robot;
}

/// A corridor with nothing in it, 3 m to go.
sim::World corridor() {
  sim::World world;
  world.name = "corridor";
  sim::add_room(world, {0.5, 0}, {6, 3}, 2.2, 0);
  world.start = {-1, 0, 0};
  world.goal = sim::Goal2{{2, 0}, std::nullopt};
  return world;
}

SimOptions with(sim::FaultPlan plan, std::uint64_t seed = 1) {
  SimOptions options;
  options.range_mode = true;
  options.seed = seed;
  options.longest = seconds(200);
  options.faults = std::move(plan);
  return options;
}

/// As bad as it can be, for four seconds amid the walk.
Fault worst(FaultKind kind) {
  Fault fault{.kind = kind, .after = FaultClock::kFirstStep, .begin = seconds(3)};
  const sim::FaultParameters& uses = traits(kind).uses;
  if (uses.length) fault.length = seconds(4);
  if (uses.delay) fault.delay = seconds(1.5);
  if (uses.noise) fault.noise = 60;
  if (uses.light) fault.light = 0.01;
  if (uses.jump) fault.jump = seconds(-30);
  return fault;
}

void expect_safe(const SimSession& session, const SimOutcome& outcome, const std::string& what) {
  EXPECT_FALSE(outcome.collision) << what << ": " << outcome.reason;
  EXPECT_FALSE(outcome.fallen) << what << ": " << outcome.reason;
  EXPECT_NE(outcome.end, "time") << what;
  for (const FaultCheck::Row& row : session.faults().rows()) {
    EXPECT_TRUE(row.begun) << what;
    EXPECT_FALSE(is_late(row)) << what << ": " << session.faults().report().dump();
    EXPECT_EQ(row.late_steps, 0) << what;
  }
}

FaultCheck::Row row_of(FaultKind kind) {
  SimSession session(hrp2(), corridor(), with({worst(kind)}));
  const SimOutcome outcome = session.run();
  expect_safe(session, outcome, std::string(traits(kind).name));
  return session.faults().rows().at(0);
}

TEST(FaultCampaign, StopsWithinATenthOfASecondWithoutTheBus) {
  const FaultCheck::Row row = row_of(FaultKind::kBusOff);
  ASSERT_TRUE(row.walking && row.answered);
  EXPECT_LE(after(row, *row.answered), 0.115);
}

TEST(FaultCampaign, TakesNoFrozenPictureForANewOne) {
  const FaultCheck::Row row = row_of(FaultKind::kFrozenPicture);
  ASSERT_TRUE(row.walking && row.answered && row.noticed);
  EXPECT_EQ(row.noticed->what, "a picture that tells nothing");
  EXPECT_LE(after(row, *row.noticed), 0.4) << "two frames";
}

TEST(FaultCampaignSlow, AnswersEveryKindAtItsWorst) {
  for (const sim::FaultTraits& kind : sim::fault_kinds()) row_of(kind.kind);
}

TEST(FaultCampaign, RunsTheSameForTheSameSeed) {
  const auto report = [](std::uint64_t seed) {
    SimSession session(hrp2(), corridor(),
                       with({{.kind = FaultKind::kCanLoss,
                              .after = FaultClock::kFirstStep,
                              .begin = seconds(1),
                              .length = seconds(5),
                              .share = 0.2},
                             {.kind = FaultKind::kFrameLoss, .length = seconds(60), .share = 0.3}},
                            seed));
    const SimOutcome outcome = session.run();
    return sim_report(session, outcome).dump();
  };
  const std::string first = report(3);
  EXPECT_EQ(first, report(3));
  EXPECT_NE(first, report(4));
}

TEST(FaultCampaign, NamesEachFaultAndIsTheSameOnEveryRun) {
  const TemporaryFolder folder;
  const auto campaign = [&](const char* out) {
    return run_headway({"campaign", "--faults", "--worlds", "2", "--seed", "1", "--frame-rate", "5",
                        "--robot", (kTree / "config/hrp2/robot.yaml").string(), "--out",
                        (folder / out).string()});
  };
  const test::Outcome one = campaign("one"), two = campaign("two");
  EXPECT_EQ(one.code, kSuccess) << one.said << one.error;
  EXPECT_NE(one.said.find("reaction [s]"), std::string::npos) << one.said;
  EXPECT_EQ(read_text(folder / "one/report.json"), read_text(folder / "two/report.json"));
  const Json report = Json::parse(read_text(folder / "one/report.json"));
  for (const Json& row : report["rows"]) {
    ASSERT_GE(row["faults"].size(), 1U);
    for (const Json& fault : row["faults"]) {
      EXPECT_FALSE(fault["kind"].get<std::string>().empty());
      EXPECT_TRUE(fault["reaction"].is_string() || fault["reaction"].is_object()) << fault.dump();
    }
  }
}

TEST(FaultCampaign, EndsWhenTheRobotStandsAndWaits) {
  SimSession session(
      hrp2(), corridor(),
      with(
          {{.kind = FaultKind::kStarvedFrameLoop, .after = FaultClock::kFirstStep, .length = seconds(300)}}));
  const SimOutcome outcome = session.run();
  EXPECT_EQ(outcome.end, "stopped");
  EXPECT_NE(outcome.reason.find("has stood for 30 s"), std::string::npos) << outcome.reason;
}

TEST(FaultFile, ThatIsWrongIsNamedInOneLine) {
  const TemporaryFolder folder;
  write_text(folder / "f.yaml", "faults:\n  - {kind: dark, begin_s: 1, lenght_s: 2, light: 0}\n");
  EXPECT_TRUE(says(run_headway({"sim", (kTree / "config/worlds/lab.yaml").string(), "--range", "--robot",
                                (kTree / "config/hrp2/robot.yaml").string(), "--out",
                                (folder / "out").string(), "--faults", (folder / "f.yaml").string()}),
                   {"f.yaml:2: faults[0].lenght_s", "did you mean 'length_s'?"}));
}

/// The judge by itself: a program that walks on and says nothing, whatever happens.
struct Stubborn {
  sim::FaultSchedule schedule;
  FaultCheck check;
  ProgramSigns signs;
  explicit Stubborn(const Fault& fault) : schedule({fault}), check({fault}, {}) {
    signs.committed.at_rest = false;
    signs.head = hal::HeadHealth::kReady;
    signs.control = hal::WalkerHealth::kReady;
  }
  /// Commits a step each 0.8 s until `stop`, when it stops.
  const FaultCheck::Row& run(Duration stop = Duration::max()) {
    for (Time now{}; now < at_seconds(20); now += seconds(0.005)) {
      if (now.time_since_epoch() % seconds(0.8) == Duration{} && !signs.committed.stopping)
        ++signs.committed.next_index;
      if (now.time_since_epoch() >= stop) signs.committed.stopping = true;
      check.look(now, schedule, signs);
    }
    return check.rows()[0];
  }
};

Fault lasting(FaultKind kind) {
  Fault fault = worst(kind);
  fault.after = FaultClock::kPowerOn;
  return fault;
}

TEST(FaultCheck, CallsAProgramLateThatDoesNothing) {
  int asking = 0;
  for (const sim::FaultTraits& kind : sim::fault_kinds()) {
    Stubborn program(lasting(kind.kind));
    const FaultCheck::Row row = program.run();
    ASSERT_TRUE(row.begun && row.walking);
    EXPECT_EQ(is_late(row), row.demand.has_value()) << kind.name;
    if (row.demand && row.demand->last_step) {
      EXPECT_GE(row.late_steps, 3) << kind.name;
    }
    FaultTotals totals;
    totals.add(program.check);
    EXPECT_EQ(totals.good(), !row.demand) << kind.name;
    asking += row.demand.has_value();
  }
  EXPECT_EQ(asking, 21) << "all but noise, stalls and a clock that jumps";
}

RC_GTEST_PROP(FaultCheck, MeasuresTheTimeFromTheBeginningToTheStop, ()) {
  const auto steps = *rc::gen::inRange(1, 400);
  Stubborn program(lasting(FaultKind::kBusOff));
  const Duration stop = seconds(3) + steps * seconds(0.005);
  const FaultCheck::Row row = program.run(stop);
  RC_ASSERT(row.answered.has_value());
  RC_ASSERT(std::abs(after(row, *row.answered) - to_seconds(stop - seconds(3))) < 1e-9);
  RC_ASSERT(is_late(row) == (stop - seconds(3) > seconds(0.11)));
}

TEST(FaultCheck, AsksNothingOfARobotThatStands) {
  Stubborn program(lasting(FaultKind::kBusOff));
  program.signs.committed.at_rest = program.signs.committed.stopping = true;
  const FaultCheck::Row row = program.run();
  EXPECT_FALSE(row.demand);
  EXPECT_FALSE(is_late(row));
  EXPECT_EQ(row.late_steps, 0);
}

TEST(FaultCheck, CountsTheStepsOfARobotThatSetsOffBlind) {
  Stubborn program(lasting(FaultKind::kDark));
  program.signs.committed.at_rest = true;
  const FaultCheck::Row row = program.run();
  EXPECT_FALSE(row.demand);
  EXPECT_GE(row.late_steps, 3);
  FaultTotals totals;
  totals.add(program.check);
  EXPECT_FALSE(totals.good());
}

TEST(FaultCheck, AsksNothingOfFaultsTooShortToMatter) {
  for (const sim::FaultTraits& kind : sim::fault_kinds()) {
    Fault fault = lasting(kind.kind);
    const auto demand = demand_of(fault, {}, {});
    if (!demand || !kind.uses.length || kind.kind == FaultKind::kRestartControl) continue;
    fault.length = demand->within - seconds(0.001);
    EXPECT_FALSE(demand_of(fault, {}, {})) << kind.name;
  }
}

}  // namespace
}  // namespace headway::app
