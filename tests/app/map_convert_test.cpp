// headway map convert, as a user calls it.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/command_map_convert.h"
#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "nav/floor_columns.h"
#include "nav/floor_files.h"
#include "nav/octomap_files.h"
#include "tests/app/run_headway.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::AllOf, testing::EndsWith, testing::HasSubstr, testing::IsEmpty, testing::Not;

using test::Outcome;

Outcome convert(const fs::path& in, const fs::path& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"map", "convert", in.string(), out.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return test::run_headway(arguments);
}

/// A floor of 3 m by 2 m, free but for a box in the middle and a corner that was not seen.
nav::FloorMap box_on_a_floor() {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-1, 0.5}, 60, 40});
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 60; ++x) {
      const bool box = x > 25 && x < 35 && y > 15 && y < 25, corner = x < 10 && y < 10;
      if (!corner) floor.cells[floor.grid.index({x, y})] = box ? nav::Floor::kBlocked : nav::Floor::kFree;
    }
  }
  return floor;
}

class MapConvert : public testing::Test {
 protected:
  MapConvert() { nav::write_ot(map_, folder_ / "map.ot"); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      names.push_back(entry.path().filename().string());
    return names;
  }
  nav::ColdMap map_ = nav::raise_floor(box_on_a_floor(), 1.2);
  TemporaryFolder folder_;
};

TEST_F(MapConvert, KeepsAllThereIsInItsOwnFormatAndOctomaps) {
  EXPECT_EQ(convert(folder_ / "map.ot", folder_ / "map.hmap").code, kSuccess);
  EXPECT_TRUE(nav::read_map_file(folder_ / "map.hmap") == map_);
  const Outcome back = convert(folder_ / "map.hmap", folder_ / "again.ot");
  EXPECT_EQ(back.code, kSuccess);
  EXPECT_TRUE(nav::read_ot(folder_ / "again.ot") == map_);
  EXPECT_THAT(back.said, AllOf(HasSubstr(" occupied and "), HasSubstr("voxels of 0.05 m"),
                               EndsWith("again.ot: written\n")));
  EXPECT_THAT(files(), testing::UnorderedElementsAre("map.ot", "map.hmap", "again.ot"));
}

TEST_F(MapConvert, KeepsSurfacesInItsOwnFormatAndSaysWhereTheyAreLost) {
  nav::SurfacePoints surfaces(map_.resolution());
  ASSERT_TRUE(surfaces.restore({.key = 7, .weight = 100, .count = 2, .doubt = 0, .first = {}, .second = {}}));
  std::ofstream file(folder_ / "map.hmap", std::ios::binary);
  nav::write_map_file(map_, surfaces, file);
  file.close();
  EXPECT_THAT(convert(folder_ / "map.hmap", folder_ / "again.hmap").said, EndsWith("again.hmap: written\n"));
  EXPECT_TRUE(nav::read_saved_map(folder_ / "again.hmap").surfaces.saved() == surfaces.saved());
  EXPECT_THAT(convert(folder_ / "map.hmap", folder_ / "again.ot").said,
              EndsWith("again.ot: written, without where within voxels surfaces lie\n"));
  EXPECT_THAT(convert(folder_ / "map.hmap", folder_ / "again.bt").said,
              HasSubstr("surfaces lie, and without how sure"));
}

TEST_F(MapConvert, SaysInOneLineWhatIsLost) {
  EXPECT_THAT(convert(folder_ / "map.ot", folder_ / "map.bt").said,
              HasSubstr("map.bt: written, without how sure"));
  EXPECT_THAT(convert(folder_ / "map.ot", folder_ / "map.ply").said,
              HasSubstr("map.ply: written, without the empty"));
  EXPECT_THAT(convert(folder_ / "map.ot", folder_ / "map.pgm").said,
              HasSubstr("map.yaml: written, without heights"));
  EXPECT_THAT(convert(folder_ / "map.bt", folder_ / "again.bt").said, Not(HasSubstr("without")));
  std::size_t occupied = 0, points = 0;
  const auto count = [](const nav::ColdMap& map, std::size_t& n) {
    map.for_any([&](const nav::BrickKey&, const nav::BrickValues& values) {
      for (const nav::LogOdds v : values) n += v >= nav::log_odds::kOccupied;
    });
  };
  count(map_, occupied);
  EXPECT_EQ(convert(folder_ / "map.ply", folder_ / "points.hmap").code, kSuccess);
  count(nav::read_map_file(folder_ / "points.hmap"), points);
  EXPECT_EQ(points, occupied);
}

TEST_F(MapConvert, GivesTheFloorAsMapServerReadsItByEitherName) {
  EXPECT_EQ(convert(folder_ / "map.ot", folder_ / "floor.yaml").code, kSuccess);
  EXPECT_EQ(convert(folder_ / "floor.pgm", folder_ / "raised.hmap", {"--height", "1.2"}).code, kSuccess);
  EXPECT_TRUE(nav::read_map_file(folder_ / "raised.hmap") == map_);
  const nav::FloorMap floor = nav::read_map_server(folder_ / "floor.yaml"), seen = box_on_a_floor();
  for (std::size_t i = 0; i < seen.cells.size(); ++i) {
    const Eigen::Vector2i cell(static_cast<int>(i) % 60, static_cast<int>(i) / 60);
    ASSERT_EQ(floor.at(floor.grid.cell(seen.grid.centre(cell))), seen.cells[i]);
  }
}

TEST_F(MapConvert, SaysWhatIsWrong) {
  const auto message = [&](const std::string& in, const std::string& out,
                           const std::vector<std::string>& more = {}) {
    const Outcome outcome = convert(folder_ / in, folder_ / out, more);
    EXPECT_EQ(outcome.code, kBadInput);
    EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
    return outcome.error;
  };
  EXPECT_THAT(message("none.bt", "map.ot"), HasSubstr("none.bt: no such file"));
  EXPECT_THAT(message("none.pgm", "map.ot"), HasSubstr("none.yaml"));
  EXPECT_THAT(message("map.ot", "map.obj"), HasSubstr("map.obj: expected a name that ends with .hmap, .ot"));
  EXPECT_THAT(message("map", "map.bt"), HasSubstr("expected a name that ends with"));
  EXPECT_THAT(message("map.ot", "none/map.bt"), HasSubstr("none/map.bt: cannot be written"));
  EXPECT_THAT(message("map.ot", "none/map.hmap"), HasSubstr("none/map.hmap: cannot be written"));
  EXPECT_THAT(message("map.ot", "map.bt", {"--resolution", "0.2"}),
              HasSubstr("--resolution is for points (.ply), which "));
  EXPECT_THAT(message("map.ot", "map.bt", {"--height", "2"}), HasSubstr("--height is for IN a floor map"));
  EXPECT_THAT(message("map.ot", "map.bt", {"--floor", "2"}), HasSubstr("--floor is for OUT a floor map"));
  EXPECT_THAT(message("map.ot", "floor.pgm", {"--floor", "-40"}), HasSubstr("nothing was seen between"));
  const Outcome buried = convert(folder_ / "map.ot", folder_ / "low.pgm", {"--floor", "-0.5"});
  EXPECT_EQ(buried.code, kSuccess);
  EXPECT_THAT(buried.error, AllOf(HasSubstr("no cell of it is free"), HasSubstr("--floor")));
  std::ofstream(folder_ / "cloud.ply")
      << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float "
         "y\nproperty float z\nend_header\n";
  EXPECT_THAT(message("cloud.ply", "map.bt"), HasSubstr("resolution of the map must be given"));
  EXPECT_EQ(convert(folder_ / "cloud.ply", folder_ / "map.bt", {"--resolution", "0.1"}).code, kSuccess);
  EXPECT_EQ(convert(folder_ / "map.ot", folder_ / "map.bt", {"--resolution", "nan"}).code, kBadInput);
}

TEST_F(MapConvert, WritesOverNothingThatIsNotItsToWrite) {
  const auto text = [&](const char* name) {
    std::ifstream in(folder_ / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_EQ(convert(folder_ / "map.ot", folder_ / "floor.pgm").code, kSuccess);
  const std::string image = text("floor.pgm"), yaml = text("floor.yaml");
  for (const char* out : {"floor.yaml", "./floor.pgm"}) {
    EXPECT_THAT(convert(folder_ / "floor.pgm", folder_ / out, {"--floor", "-1"}).error,
                HasSubstr("would be written over IN"));
  }
  EXPECT_EQ(text("floor.pgm"), image);
  EXPECT_EQ(text("floor.yaml"), yaml);
  EXPECT_EQ(convert(folder_ / "map.ot", folder_ / "floor.pgm").code, kSuccess) << "a floor map of before";

  std::ofstream(folder_ / "robot.yaml") << "name: hrp2\n";
  EXPECT_THAT(convert(folder_ / "map.ot", folder_ / "robot.pgm").error,
              AllOf(HasSubstr("robot.yaml: would be written over"), HasSubstr("choose another name")));
  EXPECT_EQ(text("robot.yaml"), "name: hrp2\n");
  EXPECT_FALSE(fs::exists(folder_ / "robot.pgm"));
}

TEST_F(MapConvert, WritesBothFilesOfAFloorMapOrNeither) {
  nav::FloorMap floor = box_on_a_floor();
  fs::create_directory(folder_ / "a.yaml");
  EXPECT_THROW(nav::write_map_server(floor, folder_.path(), "a"), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "a.pgm"));
  fs::create_directory(folder_ / "b.pgm");
  EXPECT_THROW(nav::write_map_server(floor, folder_.path(), "b"), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "b.yaml"));
  EXPECT_THAT(files(), testing::UnorderedElementsAre("map.ot", "a.yaml", "b.pgm"));
}

TEST_F(MapConvert, ReadsWhatItWroteWhateverTheName) {
  for (const char* name : {"b: c#", "&a", "it's", "12", "null", "-", "~", "a b"}) {
    EXPECT_EQ(convert(folder_ / "map.ot", folder_ / (std::string(name) + ".yaml")).code, kSuccess);
    const Outcome back = convert(folder_ / (std::string(name) + ".yaml"), folder_ / "again.bt");
    EXPECT_EQ(back.code, kSuccess) << name << ": " << back.error;
  }
}

TEST_F(MapConvert, TeachesAndLeavesTheCommandAboveAsItWas) {
  EXPECT_THAT(convert("--help", "").said,
              AllOf(HasSubstr(".hmap"), HasSubstr(".pgm, .yaml"), HasSubstr("Examples:")));
  EXPECT_EQ(convert(folder_ / "map.ot", "").code, kBadInput);
}

}  // namespace
}  // namespace headway::app
