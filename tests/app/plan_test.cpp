// headway plan as a user calls it.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/commands.h"
#include "app/floor_svg.h"
#include "nav/floor_files.h"
#include "nav/octomap_files.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using testing::HasSubstr;

/// Free floor of 6 x 4 m, its lower left corner at (-1, -2).
nav::FloorMap hall() {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-1, -2}, 120, 80});
  std::fill(floor.cells.begin(), floor.cells.end(), nav::Floor::kFree);
  return floor;
}

void wall(nav::FloorMap& floor, double x) {
  const int column = floor.grid.cell({x, 0}).x();
  for (int y = 0; y < floor.grid.height; ++y)
    floor.cells[floor.grid.index({column, y})] = nav::Floor::kBlocked;
}

class PlanCommand : public testing::Test {
 protected:
  int run(const nav::FloorMap& floor, std::vector<std::string> more) {
    nav::write_map_server(floor, folder_.path());
    more.insert(more.begin(), (folder_ / "floor.yaml").string());
    return run(std::move(more));
  }
  int run(std::vector<std::string> more) {
    std::vector<std::string> arguments{"plan", "--robot", (source_dir() / "config/hrp2/robot.yaml").string(),
                                       "--out", (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::Outcome outcome = test::run_headway(arguments);
    said_ = outcome.said;
    complaint_ = outcome.error;
    return outcome.code;
  }
  nlohmann::json report() { return nlohmann::json::parse(read_text(folder_ / "out/report.json")); }
  TemporaryFolder folder_;
  std::string said_, complaint_;
};

TEST_F(PlanCommand, SetsTheFeetDownAtTheGoal) {
  ASSERT_EQ(run(hall(), {"--from", "0,0", "--to", "3,1,90"}), kSuccess) << complaint_ << said_;
  const auto r = report();
  EXPECT_TRUE(r["found"]);
  EXPECT_TRUE(r["walkable"]);
  EXPECT_GE(r["zmp"]["margin_m"], r["zmp"]["required_m"]);
  const auto& steps = r["steps"];
  ASSERT_GT(steps.size(), 10U);
  EXPECT_NE(steps[0]["foot"], steps[1]["foot"]);
  // The last two prints stand side by side around the goal, both facing left.
  const auto &a = steps[steps.size() - 1]["lands_at"], &b = steps[steps.size() - 2]["lands_at"];
  EXPECT_NEAR((a[0].get<double>() + b[0].get<double>()) / 2, 3, 0.03);
  EXPECT_NEAR((a[1].get<double>() + b[1].get<double>()) / 2, 1, 0.03);
  EXPECT_NEAR(std::abs(a[0].get<double>() - b[0].get<double>()), 0.19, 0.01);
  EXPECT_NEAR(a[2].get<double>(), 90, 0.2);
  EXPECT_THAT(said_, HasSubstr(" s of walking"));
  for (const char* name : {"plan.png", "zmp.png"})
    EXPECT_FALSE(cv::imread((folder_ / "out" / name).string()).empty()) << name;
  for (const char* part : {"free", "bodies", "left_feet", "right_feet", "path", "waist", "zmp", "goal"})
    EXPECT_THAT(read_text(folder_ / "out/plan.svg"), HasSubstr("<g id=\"" + std::string(part) + "\""));
}

TEST_F(PlanCommand, SaysWhyThereIsNoWay) {
  nav::FloorMap floor = hall();
  wall(floor, 1.5);
  EXPECT_EQ(run(floor, {"--from", "0,0", "--to", "3,1"}), kNotReached);
  EXPECT_THAT(said_, HasSubstr("no way to the goal"));
  EXPECT_THAT(said_, HasSubstr("with --near"));
  const auto r = report();
  EXPECT_FALSE(r["found"]);
  ASSERT_TRUE(r.contains("nearest"));
  EXPECT_LT(r["nearest"][0], 1.5);
  EXPECT_FALSE(r.contains("steps"));
}

TEST_F(PlanCommand, GoesAsNearAsItGetsWhenThatWillDo) {
  nav::FloorMap floor = hall();
  wall(floor, 1.5);
  ASSERT_EQ(run(floor, {"--from", "0,0", "--to", "3,1", "--near"}), kSuccess) << said_ << complaint_;
  EXPECT_THAT(said_, HasSubstr("m from the goal: obstacles close every way to the goal"));
  const auto r = report();
  EXPECT_TRUE(r["found"]);
  const double x = r["end"][0], y = r["end"][1];
  EXPECT_LT(x, 1.5);
  EXPECT_GT(x, 1.1);
  EXPECT_NEAR(r["short_of_goal_m"].get<double>(), std::hypot(3 - x, 1 - y), 2e-3);
  EXPECT_NEAR(r["steps"].back()["lands_at"][0].get<double>(), x, 0.15);
  ASSERT_EQ(run(floor, {"--from", "0,0", "--to", "1,1", "--near"}), kSuccess);
  EXPECT_FALSE(report().contains("short_of_goal_m")) << "a goal that can be reached is";
}

TEST_F(PlanCommand, AsksWhatUnseenFloorIs) {
  nav::FloorMap floor = hall();
  for (int x = 40; x < 60; ++x)
    for (int y = 0; y < floor.grid.height; ++y) floor.cells[floor.grid.index({x, y})] = nav::Floor::kUnseen;
  EXPECT_EQ(run(floor, {"--from", "0,0", "--to", "3,1", "--unseen", "blocked"}), kNotReached);
  EXPECT_EQ(run(floor, {"--from", "0,0", "--to", "3,1", "--unseen", "costly"}), kSuccess);
  const double costly = report()["cost_s"];
  EXPECT_EQ(run(floor, {"--from", "0,0", "--to", "3,1", "--unseen", "free"}), kSuccess);
  EXPECT_LT(report()["cost_s"], costly);
}

TEST_F(PlanCommand, ReadsMovingAiMaps) {
  std::string text = "type octile\nheight 40\nwidth 60\nmap\n";
  for (int y = 0; y < 40; ++y) text += std::string(60, '.') + "\n";
  write_text(folder_ / "a.map", text);
  const std::string map = (folder_ / "a.map").string();
  EXPECT_EQ(run({map, "--cell", "0.1", "--from", "1,1", "--to", "4,2"}), kSuccess) << complaint_;
  EXPECT_EQ(run({map, "--cell", "0.05", "--from", "1,1", "--to", "4,2"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--to: (4, 2) lies outside of the map, expected x from 0 to 3"));
}

TEST_F(PlanCommand, RefusesAStartWhereNoRobotCanStand) {
  nav::FloorMap floor = hall();
  wall(floor, 1.5);
  EXPECT_EQ(run(floor, {"--from", "1.52,0", "--to", "0,0"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--from: (1.52, 0) lies in an obstacle, expected free floor"));
  EXPECT_EQ(run(floor, {"--from", "1.4,0", "--to", "0,0"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--from: at (1.4, 0), facing 0 deg, the body meets an obstacle at (1.5"));
  EXPECT_EQ(run(floor, {"--from", "1,0", "--to", "0,0"}), kSuccess) << complaint_;
  EXPECT_EQ(run(floor, {"--from", "500,0", "--to", "0,0"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--from: (500, 0) lies outside of the map, expected x from -1 to 5"));
}

TEST_F(PlanCommand, RefusesAStartBesideAVoxelMap) {
  nav::VoxelMapConfig box;
  box.lowest = {-2, -2, -0.4};
  box.highest = {2, 2, 2};
  nav::VoxelMap map(box);
  map.edit(0)[0] = nav::log_odds::kHighest;
  map.settle(0, Time{});
  nav::write_bt(map, folder_ / "map.bt");
  EXPECT_EQ(run({(folder_ / "map.bt").string(), "--from", "500,0", "--to", "0,0"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--from: (500, 0) lies outside of the map, expected x from -3"));
}

TEST_F(PlanCommand, LeavesAUsersOwnFileAlone) {
  write_text(folder_ / "out/plan.svg", "mine");
  EXPECT_EQ(run(hall(), {"--from", "0,0", "--to", "3,1"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("out/plan.svg: is there already, and of no earlier 'headway plan'"));
  EXPECT_EQ(read_text(folder_ / "out/plan.svg"), "mine");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/plan.png"));
}

TEST_F(PlanCommand, NamesWhatCannotBeRead) {
  EXPECT_EQ(run({"absent.yaml", "--from", "0,0", "--to", "1,1"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("absent.yaml"));
  EXPECT_EQ(run({"map.png", "--from", "0,0", "--to", "1,1"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("map.png: has an unknown ending, expected a floor map"));
  const std::string robot = (source_dir() / "config/hrp2/robot.yaml").string();
  EXPECT_EQ(run({robot, "--from", "0,0", "--to", "1,1"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("robot.yaml: looks like a robot file, expected a floor map"));
  EXPECT_EQ(run(hall(), {"--from", "nan,0", "--to", "1,1"}), kBadInput);
  EXPECT_EQ(run(hall(), {"--from", "0,0"}), kBadInput);
  EXPECT_EQ(run({"--help"}), kSuccess);
}

TEST(FloorSvg, DrawsARunOfCellsAsOneRectangle) {
  nav::FloorMap floor = nav::unseen_floor({0.1, {0, 0}, 4, 1});
  floor.cells[1] = floor.cells[2] = nav::Floor::kBlocked;
  const std::string svg = floor_svg(floor, {}, "a < b & c");
  EXPECT_THAT(svg, HasSubstr("M10.00 0.00h20.00v10.00h-20.00z\"/>"));
  EXPECT_THAT(svg, HasSubstr("<title>a &lt; b &amp; c</title>"));
}

}  // namespace
}  // namespace headway::app
