// The command characterise as a user calls it.
#include <algorithm>
#include <map>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/mesh_files.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "tests/vision/scene.h"
#include "vision/head_file.h"
#include "vision/rig_files.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kConfig = source_dir() / "config";

using test::Outcome, test::run_headway;

class Characterise : public testing::Test {
 protected:
  Outcome run(const fs::path& rig, std::vector<std::string> more = {},
              const fs::path& robot = kConfig / "hrp2/robot.yaml") {
    std::vector<std::string> arguments{"characterise", rig.string(), "--robot", robot.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_text(folder_ / "out/report.json")); }
  std::string out() const { return (folder_ / "out").string(); }

  TemporaryFolder folder_;
  const fs::path rig_ = kConfig / "hrp2/rigs/bottom.yaml";
};

TEST_F(Characterise, TellsWhatTheRobotsRigSees) {
  const Outcome outcome = run(rig_);
  EXPECT_EQ(outcome.code, kSuccess) << outcome.error;
  for (const char* part : {"half-spaces", "Quickhull", "250", "132", "field of view", "resolution", "views"})
    EXPECT_THAT(outcome.said, HasSubstr(part));
}

TEST_F(Characterise, ReportsTheFieldInNumbers) {
  ASSERT_EQ(run(rig_, {"--out", out()}).code, kSuccess);
  const auto r = report();
  EXPECT_EQ(r["half_spaces"]["rectified"],
            nlohmann::json::parse(R"({"no_limit":4,"near":5,"near_and_far":6,"corners":8})"));
  EXPECT_EQ(r["field"]["rows"].size(), 6U);
  EXPECT_EQ(r["field"]["corners_m"].size(), 8U);
  EXPECT_TRUE(r["pixel_pairs"]["verified"]);
  EXPECT_LT(r["pixel_pairs"]["minimal_half_spaces"], r["pixel_pairs"]["hull_facets"]);
  // What is measured is what the formula says, within what 2000 draws tell.
  for (const auto& s : r["resolution"]) {
    EXPECT_NEAR(s["measured_mm"].get<double>() / s["on_axis_mm"].get<double>(), 1, 0.05);
    EXPECT_GE(s["worst_mm"], s["on_axis_mm"]);
  }
  double farthest = 0;
  for (const auto& f : r["fields_for_a_resolution"]) {
    EXPECT_GT(f["farthest_m"], farthest);
    farthest = f["farthest_m"];
  }
  for (const auto& tour : r["viewpoints"])
    EXPECT_LE(tour["gaze_covered"]["at_1_m"], tour["gaze_covered"]["far"]);
}

TEST_F(Characterise, WritesWhatItNames) {
  ASSERT_EQ(run(rig_, {"--out", out(), "--resolution", "0.01"}).code, kSuccess);
  const auto files = report()["files"];
  EXPECT_THAT(files,
              testing::IsSupersetOf({"field.ply", "field.obj", "field_10mm.ply", "points.ply", "field.png",
                                     "sections.png", "resolution.png", "angles.png", "viewpoints.png"}));
  for (const std::string file : files) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
    if (!file.ends_with(".png")) continue;
    EXPECT_FALSE(cv::imread((folder_ / "out" / file).string()).empty()) << file;
  }
}

TEST_F(Characterise, WritesTheSameBytesTwice) {
  const auto bytes = [&] {
    EXPECT_EQ(run(rig_, {"--out", out()}).code, kSuccess);
    const nlohmann::json files = report()["files"];
    std::string all;
    for (const std::string file : files) all += read_text(folder_ / "out" / file);
    return all + read_text(folder_ / "out/report.json");
  };
  EXPECT_EQ(bytes(), bytes());
}

TEST_F(Characterise, ShowsTheSurfaceOfAPairAndSaysWhatIsWrongWithIt) {
  const hal::StereoFrame wall = vision::test::plane_seen_by(vision::read_rig(rig_), {0.1, 0, 1}, 2);
  const auto write = [&](const hal::GrayImage& image, const char* name) {
    const cv::Mat1b grey(image.height, image.width);
    std::copy(image.pixels.begin(), image.pixels.end(), grey.data);
    write_png(grey, folder_ / name);
    return (folder_ / name).string();
  };
  const std::string left = write(wall.left, "left.png"), right = write(wall.right, "right.png");
  const Outcome outcome = run(rig_, {"--out", out(), "--pair", left, right});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_TRUE(fs::exists(folder_ / "out/surface.png"));
  EXPECT_TRUE(report()["sight"]["findings"].empty());
  const Outcome swapped = run(rig_, {"--out", out(), "--pair", right, left});
  EXPECT_EQ(swapped.code, kNotReached);
  EXPECT_THAT(swapped.error, HasSubstr("right.png"));
  EXPECT_THAT(swapped.error,
              HasSubstr(": left and right are swapped: 100 % of the matches lie behind infinity"));
  EXPECT_EQ(report()["sight"]["findings"][0]["severity"], "fault");
  write_png(cv::Mat1b(100, 100, std::uint8_t{90}), folder_ / "left.png");
  const Outcome small = run(rig_, {"--out", out(), "--pair", left, right});
  EXPECT_EQ(small.code, kBadInput);
  EXPECT_THAT(small.error, HasSubstr("left.png"));
  EXPECT_EQ(small.said, "");
  EXPECT_TRUE(fs::exists(folder_ / "out/surface.png")) << "of the run before";
}

TEST_F(Characterise, ShowsTheRigsOfAHeadTogether) {
  const Outcome outcome = run(kConfig / "hrp2/head.yaml", {"--out", out()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_TRUE(fs::exists(folder_ / "out/head.png"));
  for (const char* rig : {"bottom", "top"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / rig / "report.json")) << rig;
}

// The other way to say where the upper pair sits: a rig of its own on a robot whose camera is there.
TEST_F(Characterise, PlacesEachRigWhereTheHeadCarriesIt) {
  ASSERT_EQ(run(kConfig / "hrp2/head.yaml", {"--out", out()}).code, kSuccess);
  const auto on_head = nlohmann::json::parse(read_text(folder_ / "out/top/report.json"))["viewpoints"];
  for (const vision::HeadRig& rig : vision::read_head(kConfig / "hrp2/head.yaml").rigs)
    if (rig.rig.name == "top") vision::write_rig(rig.rig, folder_ / "top.yaml");
  fs::copy(kConfig / "hrp2", folder_ / "robot", fs::copy_options::recursive);
  std::string robot = read_text(folder_ / "robot/robot.yaml");
  const std::string lower = "tilt_from_camera: [0.035, 0.072, 0.045]";
  ASSERT_NE(robot.find(lower), std::string::npos);
  write_text(folder_ / "robot/robot.yaml",
             robot.replace(robot.find(lower), lower.size(), "tilt_from_camera: [0.010, 0.029, 0.115]"));
  const auto viewpoints_on = [&](const fs::path& robot_file) {
    const Outcome outcome = run(folder_ / "top.yaml", {"--out", (folder_ / "one").string()}, robot_file);
    EXPECT_EQ(outcome.code, kSuccess) << outcome.error;
    return nlohmann::json::parse(read_text(folder_ / "one/report.json"))["viewpoints"];
  };
  EXPECT_EQ(viewpoints_on(folder_ / "robot/robot.yaml"), on_head);
  EXPECT_NE(viewpoints_on(kConfig / "hrp2/robot.yaml"), on_head) << "where the lower pair sits";
}

TEST_F(Characterise, SaysWhatIsWrong) {
  for (const char* no_size : {"nan", "inf", "-1", "0.05m"})
    EXPECT_THAT(run(rig_, {"--resolution", no_size}).error, HasSubstr("--resolution")) << no_size;
  // A word that only begins like the key makes no head of a rig.
  write_text(folder_ / "odd.yaml", "# two\nrigs : [1]\n");
  EXPECT_THAT(run(folder_ / "odd.yaml").error, HasSubstr("odd.yaml:"));
  EXPECT_THAT(run(folder_ / "none.yaml").error, HasSubstr("none.yaml"));
  EXPECT_EQ(run(rig_, {"--resolution", "-1"}).code, kBadInput);
  EXPECT_EQ(run(rig_, {"--pair", "one.png"}).code, kBadInput);
  const Outcome missing = run(rig_, {"--out", out(), "--pair", "one.png", "two.png"});
  EXPECT_EQ(missing.code, kBadInput);
  EXPECT_THAT(missing.error, HasSubstr("one.png"));
  // A pair shows its surface only in a picture.
  EXPECT_THAT(run(rig_, {"--pair", "one.png", "two.png"}).error, HasSubstr("--out"));
}

TEST(MeshFiles, HoldAClosedSurface) {
  const TemporaryFolder folder;
  const vision::TriangleMesh cube = vision::hull_mesh(
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}});
  write_mesh(cube, "cube", folder / "cube.obj");
  write_mesh(cube, "cube", folder / "cube.ply");
  std::istringstream obj(read_text(folder / "cube.obj"));
  std::map<std::pair<int, int>, int> half_edges;
  int corners = 0, triangles = 0;
  for (std::string line; std::getline(obj, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    corners += kind == "v";
    if (kind != "f") continue;
    int a = 0, b = 0, c = 0;
    ASSERT_TRUE(words >> a >> b >> c);
    ++triangles;
    for (const auto& edge : {std::pair{a, b}, {b, c}, {c, a}}) ++half_edges[edge];
  }
  EXPECT_EQ(corners - static_cast<int>(half_edges.size()) / 2 + triangles, 2);
  for (const auto& [edge, count] : half_edges) EXPECT_EQ(half_edges.count({edge.second, edge.first}), 1U);
  EXPECT_THAT(read_text(folder / "cube.ply"), HasSubstr("element vertex 8\n"));
  EXPECT_THAT(read_text(folder / "cube.ply"), HasSubstr("element face 12\n"));
}

TEST(MeshFiles, KeepTheirCommentOnOneLine) {
  const TemporaryFolder folder;
  for (const char* name : {"point.ply", "point.obj"}) {
    write_mesh({{Eigen::Vector3d::Zero()}, {}}, "of a rig\nelement vertex 9", folder / name);
    EXPECT_THAT(read_text(folder / name), HasSubstr("of a rig element vertex 9\n")) << name;
  }
}

}  // namespace
}  // namespace headway::app
