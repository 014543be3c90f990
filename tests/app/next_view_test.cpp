// headway next-view as a user calls it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/commands.h"
#include "app/map_file.h"
#include "hal/error.h"
#include "nav/octomap_files.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A floor 4 m across whose left half (y > 0) is known to be free, and the air over it.
nav::VoxelMap half_known() {
  nav::VoxelMapConfig config;
  config.lowest = {-2, -2, -0.4};
  config.highest = {2, 2, 2};
  nav::VoxelMap map(config);
  for (std::size_t b = 0; b < map.brick_count(); ++b) {
    const nav::VoxelMap::Index first = 8 * map.brick_at(b);
    for (int i = 0; i < 512; ++i) {
      const nav::VoxelMap::Index at(i & 7, i >> 3 & 7, i >> 6);
      const Eigen::Vector3d p = map.centre(first + at);
      if (p.y() < 0) continue;
      map.edit(b)[static_cast<std::size_t>(nav::VoxelMap::in_brick(at.x(), at.y(), at.z()))] =
          p.z() < 0.05 ? nav::log_odds::kHighest : nav::log_odds::kLowest;
    }
    map.settle(b, Time{});
  }
  return map;
}

class NextViewCommand : public testing::Test {
 protected:
  NextViewCommand() { nav::write_bt(half_known(), folder_ / "map.bt"); }
  int run(std::vector<std::string> more, std::string map = "map.bt") {
    std::vector<std::string> arguments{"next-view", (folder_ / map).string(),
                                       "--robot",   (source_dir() / "config/hrp2/robot.yaml").string(),
                                       "--out",     (folder_ / "out").string()};
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

TEST_F(NextViewCommand, LooksToTheSideThatIsUnseen) {
  ASSERT_EQ(run({"--at", "-1,0", "--most", "2"}), kSuccess) << complaint_;
  const auto r = report();
  ASSERT_FALSE(r["turns"].empty());
  EXPECT_LT(r["turns"][0]["pan_deg"], -10) << "to the right";
  EXPECT_GT(r["turns"][0]["gain_m3"], 0.1);
  EXPECT_EQ(r["best"].size(), 2U);
  EXPECT_LE(r["walks"].size(), 2U);
  EXPECT_THAT(said_, HasSubstr("m3 in"));
  EXPECT_FALSE(cv::imread((folder_ / "out/next_view.png").string()).empty());
}

TEST_F(NextViewCommand, SaysWhenNothingIsLeftToGain) {
  EXPECT_EQ(run({"--at", "-1,1", "--stay", "--least-gain", "900"}), kNotReached);
  EXPECT_THAT(said_, HasSubstr("nothing is left to gain"));
  EXPECT_TRUE(report()["best"].empty());
}

TEST_F(NextViewCommand, RefusesAPlaceOrALookThatCannotBe) {
  for (const char* at : {"1000,0", "-2000,2000"}) {
    EXPECT_EQ(run({"--at", at}), kBadInput);
    EXPECT_THAT(complaint_, HasSubstr(") lies outside of the map, expected x from -3")) << at;
  }
  EXPECT_EQ(run({"--head", "180,180"}), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--head: (180, 180) is more than the head turns, expected pan from -45"));
  nav::VoxelMap map = half_known();
  for (double z = 0.1; z < 1; z += 0.05) {
    const nav::VoxelMap::Index voxel = map.index({0.52, 1.02, z});
    const std::size_t brick = map.brick_index(voxel / 8);
    map.edit(brick)[static_cast<std::size_t>(
        nav::VoxelMap::in_brick(voxel.x() & 7, voxel.y() & 7, voxel.z() & 7))] = nav::log_odds::kHighest;
    map.settle(brick, Time{});
  }
  nav::write_bt(map, folder_ / "pole.bt");
  EXPECT_EQ(run({"--at", "0.52,1.02"}, "pole.bt"), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("--at: (0.52, 1.02) lies in an obstacle, expected free floor"));
}

TEST_F(NextViewCommand, NamesAMapThatCannotBeRead) {
  EXPECT_EQ(run({}, "absent.bt"), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("absent.bt: "));
  write_text(folder_ / "map.txt", "no map");
  EXPECT_EQ(run({}, "map.txt"), kBadInput);
  EXPECT_THAT(complaint_, HasSubstr("unknown ending"));
  EXPECT_EQ(run({"--at", "nan,0"}), kBadInput);
  EXPECT_EQ(run({"--help"}), kSuccess);
}

TEST(MapFile, IsTheMapThatWasWritten) {
  const TemporaryFolder folder;
  const nav::VoxelMap map = half_known();
  nav::write_bt(map, folder / "map.bt");
  nav::write_ot(map, folder / "map.ot");
  for (const char* name : {"map.bt", "map.ot"}) {
    nav::VoxelMapConfig like = map.config();
    const nav::VoxelMap read = read_map(folder / name, like);
    ASSERT_EQ(read.size(), map.size()) << name;
    std::size_t different = 0;
    for (int z = 0; z < map.size().z(); ++z)
      for (int y = 0; y < map.size().y(); ++y)
        for (int x = 0; x < map.size().x(); ++x) different += read.value({x, y, z}) != map.value({x, y, z});
    EXPECT_EQ(different, 0U) << name;
  }
}

}  // namespace
}  // namespace headway::app
