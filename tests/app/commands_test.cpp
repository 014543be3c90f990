// The commands as a user calls them.
#include "app/commands.h"

#include <algorithm>
#include <cstdlib>
#include <random>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/drawing.h"
#include "app/report.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

using test::Outcome, test::run_headway, test::says;

nlohmann::json json_of(const fs::path& file) { return nlohmann::json::parse(read_text(file)); }

/// Random dots on a wall, seen with one disparity; in the right image they lie `shift` pixels further left.
void write_dots(const fs::path& left, const fs::path& right, int width, int height, int shift) {
  std::mt19937 random(5);
  cv::Mat1b wide(height, width + shift);
  for (std::uint8_t& pixel : wide) pixel = static_cast<std::uint8_t>(random() % 256);
  write_png(wide(cv::Rect(0, 0, width, height)).clone(), left);
  write_png(wide(cv::Rect(shift, 0, width, height)).clone(), right);
}

class Reconstruct : public testing::Test {
 protected:
  Reconstruct() { write_dots(folder_ / "l.png", folder_ / "r.png", 160, 120, 10); }

  Outcome run(std::vector<std::string> more) {
    std::vector<std::string> arguments{"reconstruct", (folder_ / "l.png").string(),
                                       (folder_ / "r.png").string(), "--out", (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }
  TemporaryFolder folder_;
};

TEST_F(Reconstruct, FindsAWallWhereItsDisparitySays) {
  // 100 px * 0.2 m / 10 px = 2 m
  const Outcome outcome = run({"--focal", "100", "--baseline", "0.2", "--near", "1"});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const cv::Mat disparity = cv::imread((folder_ / "out/disparity.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(disparity.type(), CV_16U);
  EXPECT_NEAR(disparity.at<std::uint16_t>(60, 100), 2560, 60);
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_GT(report["density"], 0.8);
  EXPECT_GT(report["points"], 10000);
  for (const char* file :
       {"left.png", "depth.png", "uncertainty.png", "map_view.png", "cloud.ply", "map.bt", "timing.json"}) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
  }
}

TEST_F(Reconstruct, ComparesWithTheTruth) {
  write_png(cv::Mat(120, 160, CV_16U, cv::Scalar(2560)), folder_ / "truth.png");
  const Outcome outcome = run(
      {"--focal", "100", "--baseline", "0.2", "--near", "1", "--truth", (folder_ / "truth.png").string()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_LT(report["bad_2"], 0.02);
  EXPECT_GT(report["coverage_3_sigma"], 0.95);
  write_png(cv::Mat(120, 160, CV_16U, cv::Scalar(2560 + 5 * 256)), folder_ / "truth.png");
  run({"--focal", "100", "--baseline", "0.2", "--near", "1", "--truth", (folder_ / "truth.png").string()});
  EXPECT_GT(json_of(folder_ / "out/report.json")["bad_2"], 0.98);
}

TEST_F(Reconstruct, WritesTheSameBytesTwice) {
  const auto bytes = [&] {
    EXPECT_EQ(run({"--focal", "100", "--baseline", "0.2", "--near", "1"}).code, kSuccess);
    std::string all;
    for (const char* file : {"report.json", "depth.png", "map_view.png", "cloud.ply", "map.bt"}) {
      all += read_text(folder_ / "out" / file);
    }
    return all;
  };
  EXPECT_EQ(bytes(), bytes());
}

TEST_F(Reconstruct, RefusesOneImageForBothCameras) {
  fs::copy_file(folder_ / "l.png", folder_ / "r.png", fs::copy_options::overwrite_existing);
  EXPECT_TRUE(
      says(run({"--focal", "100", "--baseline", "0.2"}), {"l.png", "r.png", "both images are the same"}));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Reconstruct, MissesItsAimWithoutAPoint) {
  // The wall stands at 2 m.
  const Outcome outcome = run({"--focal", "100", "--baseline", "0.2", "--near", "0.5", "--far", "1"});
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_THAT(outcome.error, HasSubstr("no point was found from 0.5 to 1 m"));
}

TEST_F(Reconstruct, SaysWhatIsWrong) {
  EXPECT_TRUE(says(run({}), {"--rig", "--focal"}));
  EXPECT_TRUE(says(run({"--rig", (folder_ / "none.yaml").string()}), {"none.yaml"}));
  EXPECT_TRUE(says(run({"--focal", "100", "--baseline", "-0.2"}), {"baseline"}));
  const std::vector<std::string> good{"--focal", "100", "--baseline", "0.2", "--near", "1"};
  std::vector<std::string> with_truth = good;
  with_truth.insert(with_truth.end(), {"--truth", (folder_ / "t.png").string()});
  write_png(cv::Mat(10, 16, CV_16U, cv::Scalar(2560)), folder_ / "t.png");
  EXPECT_TRUE(says(run(with_truth), {"t.png", "16 x 10", "160 x 120"}));
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "a run that failed leaves something behind";
  write_text(folder_ / "out_file", "");
  EXPECT_TRUE(
      says(run_headway({"reconstruct", (folder_ / "l.png").string(), (folder_ / "r.png").string(), "--out",
                        (folder_ / "out_file/below").string(), "--focal", "100", "--baseline", "0.2"}),
           {"out_file"}));
  write_png(canvas(50, 40, {1, 2, 3}), folder_ / "r.png");
  EXPECT_TRUE(says(run(good), {"l.png", "50 x 40"}));
  std::string bytes = read_text(folder_ / "l.png");
  write_text(folder_ / "l.png", bytes.substr(0, bytes.size() / 2));
  EXPECT_TRUE(says(run(good), {"l.png", "truncated"}));
  fs::remove(folder_ / "l.png");
  EXPECT_TRUE(says(run(good), {"l.png"}));
}

/// A depth camera 1.5 m above a floor, that looks at a wall 2 m ahead; the poses' world is the camera's own
/// frame.
void write_room(const fs::path& folder, int frames) {
  write_text(folder / "camera-intrinsics.txt", "100 0 79.5\n0 100 59.5\n0 0 1\n");
  cv::Mat1w depth(120, 160);
  for (int v = 0; v < 120; ++v) {
    const double down = (v - 59.5) / 100;
    const double z = down > 0 ? std::min(2.0, 1.1 / down) : 2.0;
    for (int u = 0; u < 160; ++u) depth(v, u) = static_cast<std::uint16_t>(std::lround(1000 * z));
  }
  for (int i = 0; i < frames; ++i) {
    write_png(depth, folder / fmt::format("frame-{:06}.depth.png", i));
    write_text(folder / fmt::format("frame-{:06}.pose.txt", i), "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
}

TEST(Map, OfADepthSequenceHasItsFloorAtZeroAndTheWallAhead) {
  const TemporaryFolder folder;
  write_room(folder / "in", 3);
  const Outcome outcome =
      run_headway({"map", "--sequence", (folder / "in").string(), "--out", (folder / "out").string()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const auto report = json_of(folder / "out/report.json");
  EXPECT_EQ(report["layout"], "depth");
  EXPECT_NEAR(report["ground"]["first_camera_above_floor_m"], 1.1, 0.03);
  ASSERT_EQ(report["frames"].size(), 3U);
  EXPECT_EQ(report["frames"][0]["density"], 1.0);
  EXPECT_GT(report["frames"][0]["voxels_first_seen"], 1000);
  for (const auto& frame : report["frames"]) {
    for (const char* time : {"read_ms", "see_ms", "integrate_ms", "floor_ms"})
      EXPECT_GT(frame[time], 0) << time;
  }
  EXPECT_GT(report["floor_m2"]["free"], 0.1);
  EXPECT_GT(report["floor_m2"]["blocked"], 0.1);
  for (const char* file : {"depth_000.png", "uncertainty_002.png", "map_view.png", "map_above.png",
                           "floor.png", "cloud.ply", "map.bt", "floor.pgm", "floor.yaml"}) {
    EXPECT_TRUE(fs::exists(folder / "out" / file)) << file;
  }
}

TEST(Map, RefusesOptionsThatDepthImagesDoNotNeed) {
  const TemporaryFolder folder;
  write_room(folder / "in", 1);
  const auto map = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"map", "--out", (folder / "out").string(), "--sequence",
                                       (folder / "in").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  };
  const std::string rig = (source_dir() / "config/hrp2/rigs/bottom.yaml").string();
  EXPECT_TRUE(says(map({"--rig", rig}), {"--rig is for stereo pairs", "depth images"}));
  EXPECT_TRUE(says(map({"--matcher", "census"}), {"--matcher is for stereo pairs", "depth images"}));
  EXPECT_EQ(map({}).code, kSuccess);
}

TEST(Map, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto map = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"map", "--out", (folder / "out").string(), "--sequence"});
    return run_headway(more);
  };
  EXPECT_TRUE(says(map({(folder / "none").string()}), {"none", "no such folder"}));
  write_room(folder / "in", 2);
  EXPECT_TRUE(says(map({(folder / "in").string(), "--near", "3", "--far", "2"}), {"--near", "--far"}));
  EXPECT_TRUE(
      says(run_headway({"map", "--out", (folder / "in/").string(), "--sequence", (folder / "in").string()}),
           {"--out", "the sequence's own images"}));
  write_png(cv::Mat(10, 16, CV_16U, cv::Scalar(2560)), folder / "in/frame-000001.depth.png");
  EXPECT_TRUE(says(map({(folder / "in").string()}), {"frame-000001.depth.png", "16 x 10", "160 x 120"}));
  write_png(canvas(160, 120, {1, 2, 3}), folder / "in/frame-000001.depth.png");
  EXPECT_TRUE(says(map({(folder / "in").string()}), {"frame-000001.depth.png", "16 bits"}));
}

TEST(Map, HelpsAndRefusesWhatItDoesNotKnow) {
  EXPECT_EQ(run_headway({"map", "--help"}).code, kSuccess);
  EXPECT_EQ(run_headway({"reconstruct", "--help"}).code, kSuccess);
  EXPECT_EQ(run_headway({"map"}).code, kBadInput);
  EXPECT_EQ(run_headway({"map", "--sequence", "x", "--out", "y", "--resolution", "7"}).code, kBadInput);
}

/// All files in a folder but its report are those that the report lists.
void expect_complete_report(const fs::path& folder) {
  std::set<std::string> there, listed = json_of(folder / "report.json")["files"];
  for (const auto& entry : fs::directory_iterator(folder)) there.insert(entry.path().filename());
  there.erase("report.json");
  EXPECT_EQ(there, listed);
}

TEST_F(Reconstruct, ReportsEveryFileAndTheDisparitiesThatWereSearched) {
  // 1.4 m are 14.3 px here, but the census matcher looks up to 0.7 times as near: 20.4 px.
  for (const auto& [matcher, count] : {std::pair{"census", 32}, {"bm", 16}}) {
    ASSERT_EQ(run({"--focal", "100", "--baseline", "0.2", "--near", "1.4", "--matcher", matcher}).code,
              kSuccess);
    expect_complete_report(folder_ / "out");
    EXPECT_EQ(json_of(folder_ / "out/report.json")["disparities"]["count"], count) << matcher;
  }
}

TEST(Map, ReportsEveryFile) {
  const TemporaryFolder folder;
  write_room(folder / "in", 3);
  ASSERT_EQ(
      run_headway({"map", "--sequence", (folder / "in").string(), "--out", (folder / "out").string()}).code,
      kSuccess);
  expect_complete_report(folder / "out");
}

TEST(Report, KeepsTheOrderOfItsKeysAndRoundsItsNumbers) {
  const TemporaryFolder folder;
  write_json(folder / "a.json", {{"z", rounded(0.123456)}, {"a", rounded(-1e-9)}, {"n", rounded(NAN)}});
  EXPECT_EQ(read_text(folder / "a.json"), "{\n  \"z\": 0.1235,\n  \"a\": 0.0,\n  \"n\": null\n}\n");
}

/// All that two runs of the simulator with these options leave behind is the same, but for the time they
/// took.
void expect_same_bytes_twice(const std::vector<std::string>& options) {
  const TemporaryFolder folder;
  write_text(folder / "small.yaml",
             "name: small\nstart: [-0.9, 0, 0]\ngoal: [0.5, 0.2]\nroom: {size: [3.2, 2.6], height: 2}\n"
             "boxes: [{name: box, centre: [0.2, -0.9, 0.3], size: [0.4, 0.4, 0.6]}]\n");
  const auto run = [&](const char* out) {
    std::vector<std::string> arguments{"sim",     (folder / "small.yaml").string(),
                                       "--out",   (folder / out).string(),
                                       "--robot", (source_dir() / "config/hrp2/robot.yaml").string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = run_headway(arguments);
    EXPECT_LE(outcome.code, kNotReached) << outcome.error;
  };
  run("one");
  run("two");
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "one")) {
    const fs::path name = entry.path().filename();
    if (name == "timing.json") continue;
    ++files;
    EXPECT_TRUE(read_text(entry.path()) == read_text(folder / "two" / name)) << name;
  }
  EXPECT_GE(files, 7U);
  EXPECT_EQ(json_of(folder / "one/report.json")["files"].size(), files);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "two"), {}),
            static_cast<std::ptrdiff_t>(files) + 1);
}

TEST(SimSlow, WritesTheSameBytesForTheSameSeed) { expect_same_bytes_twice({"--range"}); }

TEST(SimSlow, WritesTheSameBytesForTheSameSeedThroughBothCameras) {
  expect_same_bytes_twice({"--longest", "4"});
}

fs::path data_folder() {
  const char* data = std::getenv("HEADWAY_DATA");
  return data == nullptr ? fs::path() : fs::path(data);
}

TEST(RealDataSlow, MotorcycleIsReconstructedPrecisely) {
  const fs::path data = data_folder();
  if (data.empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const TemporaryFolder folder;
  const fs::path pair = data / "stereo" / "motorcycle";
  const Outcome outcome =
      run_headway({"reconstruct", (pair / "left.png").string(), (pair / "right.png").string(), "--rig",
                   (source_dir() / "config/rigs/middlebury_motorcycle.yaml").string(), "--truth",
                   (pair / "gt16.png").string(), "--out", folder.path().string()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const auto report = json_of(folder / "report.json");
  EXPECT_LE(report["bad_2"], 0.06);
  EXPECT_GE(report["density"], 0.94);
  EXPECT_GE(report["coverage_3_sigma"], 0.95);
  EXPECT_LE(report["coverage_3_sigma"], 0.999);
}

TEST(RealDataSlow, TheExampleOfReconstructsHelpIsMotorcycle) {
  const fs::path pair = data_folder() / "stereo/motorcycle";
  if (!fs::exists(pair)) GTEST_SKIP() << "HEADWAY_DATA is not set, or has no stereo/motorcycle";
  testing::internal::CaptureStdout();
  const char* help[] = {"headway", "reconstruct", "--help"};
  run_program(3, help);
  const std::string text = testing::internal::GetCapturedStdout();
  std::istringstream words(text.substr(text.find("headway reconstruct left.png")));
  std::vector<std::string> arguments;
  for (std::string word; words >> word && word != "DIR";)
    if (word != "\\" && word != "headway") arguments.push_back(word);
  const TemporaryFolder folder;
  arguments[1] = (pair / "left.png").string(), arguments[2] = (pair / "right.png").string();
  arguments.insert(arguments.end(), {folder.path().string(), "--truth", (pair / "gt16.png").string()});
  const Outcome outcome = run_headway(arguments);
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_LE(json_of(folder / "report.json")["bad_2"], 0.06);
  EXPECT_GE(json_of(folder / "report.json")["density"], 0.94);
}

TEST(RealDataSlow, SequencesAreMapped) {
  const fs::path data = data_folder();
  if (data.empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const TemporaryFolder folder;
  const auto map = [&](const char* name) {
    const Outcome outcome = run_headway(
        {"map", "--sequence", (data / "sequence" / name).string(), "--out", folder.path().string()});
    EXPECT_EQ(outcome.code, kSuccess) << outcome.error;
    return json_of(folder / "report.json");
  };
  const auto room = map("depth_room");
  EXPECT_EQ(room["frames"].size(), 10U);
  EXPECT_NEAR(room["ground"]["first_camera_above_floor_m"], 1.5, 0.15);  // held in the hands
  const auto hall = map("euroc");
  EXPECT_EQ(hall["frames"].size(), 14U);
  EXPECT_GT(hall["floor_m2"]["free"], 1);
  for (const auto& frame : hall["frames"]) EXPECT_GT(frame["density"], 0.7);
  const auto living_room = map("iclnuim");
  EXPECT_EQ(living_room["frames"].size(), 3U);
  for (const auto& frame : living_room["frames"]) EXPECT_GT(frame["density"], 0.99);
}

}  // namespace
}  // namespace headway::app
