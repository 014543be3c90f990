// headway calibrate as a user calls it: images of boards in, rig and neck files out.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/neck_file.h"
#include "app/pictures.h"
#include "app/robot_file.h"
#include "hal/angle.h"
#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "tests/vision/rendered_board.h"
#include "tests/vision/simulated_head.h"
#include "vision/rig_files.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

const fs::path kTree = source_dir();

using test::Outcome, test::says;

Outcome run_headway(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "calibrate");
  return test::run_headway(arguments);
}

nlohmann::json json_of(const fs::path& file) { return nlohmann::json::parse(read_text(file)); }

vision::CameraIntrinsics camera(double focal, double cx) {
  vision::CameraIntrinsics c;
  c.width = 320, c.height = 240, c.fx = c.fy = focal, c.cx = cx, c.cy = 121;
  return c;
}

/// Two cameras 0.1 m apart, turned a degree towards each other.
vision::StereoRig true_rig() {
  vision::StereoRig rig;
  rig.left = camera(350, 158), rig.right = camera(352, 161);
  rig.right_from_left.rotate(AngleAxisd(kDegree, Vector3d::UnitY()));
  rig.right_from_left.translation() << -0.1, 0.001, 0;
  return rig;
}

const vision::Board kBoard{9, 6, 0.03, {}};

/// A board held up in the i-th way.
Isometry3d held_up(const vision::Board& board, int i) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() << 0.05 + 0.04 * std::sin(2.1 * i), 0.035 * std::cos(1.7 * i),
      0.62 + 0.05 * std::sin(1.3 * i);
  pose.rotate(AngleAxisd(0.2 * std::sin(3.1 * i), Vector3d::UnitZ()) *
              AngleAxisd(0.5 * std::cos(2.3 * i), Vector3d::UnitY()) *
              AngleAxisd(0.5 * std::sin(0.9 * i + 1), Vector3d::UnitX()));
  return pose * Eigen::Translation3d(-0.5 * board.corner(board.corners() - 1));
}

void write_pairs(const fs::path& folder, const vision::Board& board, int count) {
  fs::create_directories(folder);
  const vision::StereoRig rig = true_rig();
  const vision::test::BoardRenderer left(rig.left), right(rig.right);
  const vision::test::BoardPrint print(board);
  for (int i = 0; i < count; ++i) {
    const Isometry3d pose = held_up(board, i);
    write_png(image_picture(left.render(print, pose)), folder / fmt::format("left{:02}.png", i));
    write_png(image_picture(right.render(print, rig.right_from_left * pose)),
              folder / fmt::format("right{:02}.png", i));
  }
}

class Calibrate : public testing::Test {
 protected:
  /// Rendered once for all tests.
  static void SetUpTestSuite() {
    images_ = new TemporaryFolder;
    write_pairs(images_->path() / "chess", kBoard, 10);
  }
  static void TearDownTestSuite() {
    delete images_;
    images_ = nullptr;
  }

  static Outcome run(const std::vector<std::string>& paths, const fs::path& out,
                     const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = paths;
    arguments.insert(arguments.end(), {"--board", "9x6", "--square", "0.03", "--out", out.string()});
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }
  static std::string chess() { return (images_->path() / "chess").string(); }
  /// A copy that may be damaged.
  fs::path copy() {
    const fs::path to = folder_ / fmt::format("copy{}", copies_++);
    fs::copy(chess(), to);
    return to;
  }

  static TemporaryFolder* images_;
  TemporaryFolder folder_;
  int copies_ = 0;
};
TemporaryFolder* Calibrate::images_ = nullptr;

TEST_F(Calibrate, FindsTheRigThatTookTheImages) {
  const Outcome outcome = run({chess()}, folder_ / "out", {"--name", "pair", "--near", "0.4", "--far", "3"});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const vision::StereoRig found = vision::read_rig(folder_ / "out/rig.yaml"), truth = true_rig();
  EXPECT_EQ(found.name, "pair");
  EXPECT_EQ(found.nearest, 0.4);
  EXPECT_EQ(found.farthest, 3);
  EXPECT_NEAR(found.baseline(), truth.baseline(), 0.001);
  EXPECT_NEAR(found.left.fx, truth.left.fx, 2);
  EXPECT_NEAR(found.right.cx, truth.right.cx, 2);
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_EQ(report["pairs_used"], 10);
  EXPECT_LT(report["rms_px"], 0.15);
  EXPECT_LT(report["epipolar_px"]["mean"], 0.1);
  EXPECT_NEAR(report["square"]["mean"], 1, 0.003);
  EXPECT_GT(report["coverage"]["left"], 0.3);
  EXPECT_LT(report["coverage"]["left"], 1);
  EXPECT_GT(report["estimates"]["left.fx"]["sigma"], 0);
  const cv::Mat picture = cv::imread((folder_ / "out/coverage.png").string());
  EXPECT_GT(picture.cols, 2 * 320);
}

TEST_F(Calibrate, UnderstandsCharucoBoards) {
  const vision::Board board{8, 6, 0.03, vision::BoardMarkers{"4X4_100", 0.022}};
  write_pairs(folder_ / "in", board, 8);
  const Outcome outcome =
      run_headway({(folder_ / "in").string(), "--board", "8x6", "--square", "0.03", "--charuco", "4X4_100",
                   "--marker", "0.022", "--out", (folder_ / "out").string()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  EXPECT_NEAR(vision::read_rig(folder_ / "out/rig.yaml").baseline(), true_rig().baseline(), 0.001);
  EXPECT_EQ(json_of(folder_ / "out/report.json")["board"]["markers"]["dictionary"], "4X4_100");
}

TEST_F(Calibrate, NamesThePairThatDoesNotFit) {
  const fs::path in = copy();
  // One camera was hit: the right image of pair 4 lies three rows lower.
  cv::Mat image = cv::imread((in / "right04.png").string()), lower = image.clone();
  image.rowRange(0, image.rows - 3).copyTo(lower.rowRange(3, image.rows));
  write_png(lower, in / "right04.png");
  run({in.string()}, folder_ / "out");
  EXPECT_EQ(json_of(folder_ / "out/report.json")["outliers"], nlohmann::json({"04"}));
}

TEST_F(Calibrate, EndsWithOneWhenRowsDoNotAgree) {
  const fs::path in = copy();
  for (int i = 0; i < 10; ++i) {  // every right image slips by another number of rows
    const fs::path file = in / fmt::format("right{:02}.png", i);
    cv::Mat image = cv::imread(file.string()), slipped = image.clone();
    const int rows = 2 + i % 3 * 2;
    if (i % 2 == 0) image.rowRange(0, image.rows - rows).copyTo(slipped.rowRange(rows, image.rows));
    if (i % 2 != 0) image.rowRange(rows, image.rows).copyTo(slipped.rowRange(0, image.rows - rows));
    write_png(slipped, file);
  }
  const Outcome outcome = run({in.string()}, folder_ / "out");
  EXPECT_EQ(outcome.code, kNotReached);
  EXPECT_NE(outcome.error.find("rows differ by"), std::string::npos) << outcome.error;
  EXPECT_TRUE(fs::exists(folder_ / "out/report.json"));
}

TEST_F(Calibrate, PassesOverPairsWithoutABoardAndSaysSo) {
  const fs::path in = copy();
  write_png(canvas(320, 240, {90, 90, 90}), in / "left03.png");
  ASSERT_EQ(run({in.string()}, folder_ / "out").code, kSuccess);
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_EQ(report["pairs_used"], 9);
  EXPECT_EQ(report["skipped"], nlohmann::json({"03: no board in left03.png"}));
}

TEST_F(Calibrate, SaysWhatIsWrong) {
  const fs::path out = folder_ / "out";
  EXPECT_TRUE(says(run({(folder_ / "none").string()}, out), {"none", "expected one folder"}));
  fs::create_directories(folder_ / "empty");
  EXPECT_TRUE(says(run({(folder_ / "empty").string()}, out), {"empty", "no images left"}));
  EXPECT_TRUE(
      says(run({chess() + "/l*.png", chess() + "/x*.png"}, out), {"x*.png", "no image has such a name"}));
  fs::path in = copy();
  fs::remove(in / "right05.png");
  EXPECT_TRUE(says(run({in.string()}, out), {"left05.png", "no partner", "10 left and 9 right"}));
  in = copy();
  write_png(canvas(100, 80, {90, 90, 90}), in / "right02.png");
  EXPECT_TRUE(says(run({in.string()}, out), {"right02.png", "100 x 80", "320 x 240", "left00.png"}));
  in = copy();
  for (int i = 3; i < 10; ++i) {
    fs::remove(in / fmt::format("left{:02}.png", i));
    fs::remove(in / fmt::format("right{:02}.png", i));
  }
  EXPECT_TRUE(says(run({in.string()}, out), {"seen in 3 views", "expected at least 4"}));
  const fs::path alone = folder_ / "alone";
  for (const char* name : {"left.png", "right.png"}) {
    fs::create_directories(alone);
    write_png(canvas(100, 80, {90, 90, 90}), alone / name);
  }
  EXPECT_TRUE(says(run({alone.string()}, out),
                   {"both images of the only pair (left and right: no board in left.png)"}));
  EXPECT_FALSE(fs::exists(out)) << "a run that failed leaves something behind";
  in = copy();
  write_text(in / "left01.png", "no image");
  EXPECT_TRUE(says(run({in.string()}, out), {"left01.png"}));
  in = copy();
  for (int i = 0; i < 10; ++i) {
    const fs::path left = in / fmt::format("left{:02}.png", i), right = in / fmt::format("right{:02}.png", i);
    fs::rename(left, in / "swap.png");
    fs::rename(right, left);
    fs::rename(in / "swap.png", right);
  }
  EXPECT_TRUE(says(run({in.string()}, out), {"swap the cameras"}));
  const auto board = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {chess(), "--out", out.string()});
    return run_headway(more);
  };
  EXPECT_TRUE(says(board({"--board", "7x5", "--square", "0.03"}),
                   {"no chessboard of 7 x 5 inner corners", "10 pairs", "--board"}));
  EXPECT_TRUE(says(board({"--board", "9by6", "--square", "0.03"}), {"--board '9by6'", "as 9x6"}));
  EXPECT_TRUE(says(board({"--board", "9x6", "--square", "30"}), {"--square: is 30", "0.001 to 1"}));
  EXPECT_TRUE(says(board({"--board", "9x6", "--square", "0.03", "--charuco", "8X8", "--marker", "0.02"}),
                   {"dictionary: '8X8'", "4X4_50"}));
  EXPECT_EQ(board({"--board", "9x6", "--square", "0.03", "--charuco", "4X4_50"}).code, kBadInput);
  EXPECT_EQ(board({"--board", "9x6"}).code, kBadInput);
  for (const char* option : {"--square", "--near", "--far"})
    EXPECT_TRUE(says(board({"--board", "9x6", option, "nan"}),
                     {"headway: calibrate: " + std::string(option) + ": is nan"}));
  EXPECT_TRUE(says(run({(folder_ / "none").string()}, out, {"--near", "4", "--far", "3"}), {"--near 4 and"}))
      << "before any image is looked for";
  write_text(folder_ / "file", "");
  EXPECT_TRUE(says(run({chess()}, folder_ / "file/out"), {"file"}));
}

TEST_F(Calibrate, NamesThePairWhoseImagesDoNotBelongTogether) {
  const fs::path in = copy();
  fs::copy_file(in / "right07.png", in / "right04.png", fs::copy_options::overwrite_existing);
  EXPECT_TRUE(
      says(run({in.string()}, folder_ / "out"), {"pair 04: left and right image do not belong together"}));
}

TEST_F(Calibrate, CountsTheCornersThatAPairIsShort) {
  const vision::Board board{8, 6, 0.03, vision::BoardMarkers{"4X4_100", 0.022}};
  const fs::path in = folder_ / "in";
  write_pairs(in, board, 4);
  EXPECT_TRUE(says(run_headway({in.string(), "--board", "8x6", "--square", "0.03", "--charuco", "4X4_100",
                                "--marker", "0.022", "--out", (folder_ / "out").string()}),
                   {"only 3 of 4 pairs can be used", "expected at least 4",
                    "01: both cameras see 2 of the same corners, expected 6 or more"}));
}

/// OpenCV's chessboard pairs; empty where they are not.
fs::path opencv_pairs() {
  const char* data = std::getenv("HEADWAY_DATA");
  const fs::path own = fs::path(data ? data : "") / "stereo/chess",
                 debian = "/usr/share/doc/opencv-doc/examples/data";
  if (data && fs::exists(own / "left01.jpg")) return own;
  return fs::exists(debian / "left01.jpg") ? debian : fs::path();
}

TEST_F(Calibrate, SaysWhereTheBoardWasMissingWhenALensStaysOpen) {
  const fs::path folder = opencv_pairs();
  if (folder.empty()) GTEST_SKIP() << "neither HEADWAY_DATA nor Debian's opencv-doc is there";
  std::vector<std::string> some;
  for (const char* number : {"01", "02", "03", "04"})
    for (const char* side : {"left", "right"})
      some.push_back((folder / fmt::format("{}{}.jpg", side, number)).string());
  EXPECT_TRUE(says(run(some, folder_ / "out"), {"4 pairs do not determine the left camera's lens",
                                                "near the upper left, lower left of its image",
                                                "take more pairs with the board there", "coverage.png"}));
  EXPECT_TRUE(fs::exists(folder_ / "out/coverage.png"));
  EXPECT_FALSE(fs::exists(folder_ / "out/rig.yaml"));
}

TEST_F(Calibrate, OfOpenCvsPairsAsPublished) {
  const fs::path folder = opencv_pairs();
  if (folder.empty()) GTEST_SKIP() << "neither HEADWAY_DATA nor Debian's opencv-doc is there";
  const Outcome outcome =
      run_headway({(folder / "left??.jpg").string(), (folder / "right??.jpg").string(), "--board", "9x6",
                   "--square", "0.025", "--alike", "--out", (folder_ / "out").string()});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_EQ(report["pairs_used"], 13);
  EXPECT_NEAR(report["rms_px"], 0.305, 0.02);
  EXPECT_LE(report["epipolar_px"]["rms"], 0.31);
  EXPECT_NEAR(report["square"]["mean"], 0.997, 0.003);
  EXPECT_NEAR(report["baseline_squares"], 3.33, 0.01);
}

/// A head with planted errors watches a board; its images and head.csv lie in a folder.
class CalibrateHead : public testing::Test {
 protected:
  CalibrateHead() : head_(planted(), 7) {
    vision::CameraIntrinsics& c = head_.camera;
    c.k1 = c.k2 = c.p1 = c.p2 = 0;  // the renderer draws ideal images
    vision::StereoRig rig = vision::read_rig(kTree / "config/hrp2/rigs/bottom.yaml");
    rig.left = c;
    vision::write_rig(rig, folder_ / "rig.yaml");
  }

  static vision::test::PlantedErrors planted() {
    vision::test::PlantedErrors e;
    e.shift = {0.010, 0.010, -0.010};
    e.turn = {2 * kDegree, 0, 2 * kDegree};
    e.zero = {-2 * kDegree, 2 * kDegree};
    e.time_offset = 0.020;
    return e;
  }

  void record(const vision::test::Session& session) {
    fs::create_directories(folder_ / "in");
    const vision::test::BoardRenderer renderer(head_.camera);
    const vision::test::BoardPrint print(head_.board);
    const auto input = head_.record(
        session, [&](vision::HeadCalibrationInput& so_far, Time stamp, const Isometry3d& camera_from_board) {
          so_far.views.push_back({stamp, {}});
          const fs::path file = folder_ / "in" / fmt::format("{}.png", stamp.time_since_epoch().count());
          write_png(image_picture(renderer.render(print, camera_from_board)), file);
        });
    std::string table = "# stamp [ns], pan [deg], tilt [deg]\n";
    for (const vision::HeadSample& s : input.samples)
      table += fmt::format("{}, {:.3f}, {:.3f}\n", s.stamp.time_since_epoch().count(), s.angles.pan / kDegree,
                           s.angles.tilt / kDegree);
    write_text(folder_ / "in/head.csv", table);
  }

  Outcome run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{(folder_ / "in").string(),
                                       "--head",
                                       "--rig",
                                       (folder_ / "rig.yaml").string(),
                                       "--robot",
                                       (kTree / "config/hrp2/robot.yaml").string(),
                                       "--board",
                                       "12x8",
                                       "--square",
                                       "0.05",
                                       "--charuco",
                                       "4X4_100",
                                       "--marker",
                                       "0.036",
                                       "--out",
                                       (folder_ / "out").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }

  TemporaryFolder folder_;
  vision::test::SimulatedHead head_;
};

TEST_F(CalibrateHead, FindsPlantedErrorsInImages) {
  vision::test::Session session;
  session.images = 50;
  session.pan_span = 15 * kDegree, session.tilt_span = 18 * kDegree;
  record(session);
  const Vector3d corner = head_.measured_corner(0.001).place;
  const Outcome outcome = run(
      {"--corner", fmt::format("{},{},{}", corner.x(), corner.y(), corner.z()), "--corner-sigma", "0.001"});
  ASSERT_EQ(outcome.code, kSuccess) << outcome.error;
  const auto report = json_of(folder_ / "out/report.json");
  EXPECT_GT(report["views_used"], 35);
  const auto found = [&](const char* name) { return report["estimates"][name]["value"].get<double>(); };
  EXPECT_NEAR(found("camera.x"), 10, 1) << "mm";
  EXPECT_NEAR(found("camera.y"), 10, 1);
  EXPECT_NEAR(found("camera.z"), -10, 1);
  EXPECT_NEAR(found("camera.turn_x"), 2, 0.1) << "deg";
  EXPECT_NEAR(found("camera.turn_z"), 2, 0.1);
  EXPECT_NEAR(found("tilt_zero"), 2, 0.1);
  EXPECT_NEAR(found("pan_zero"), -2, 0.1);
  EXPECT_NEAR(found("time_offset"), 20, 2) << "ms";
  EXPECT_TRUE(fs::exists(folder_ / "out/views.png"));
  EXPECT_NE(read_text(folder_ / "out/neck.yaml").find("pan_zero_deg: -"), std::string::npos);
}

TEST_F(CalibrateHead, SaysWhatIsWrong) {
  EXPECT_TRUE(says(run(), {"in", "cannot be listed"}));
  vision::test::Session still;
  still.images = 5;
  still.pan_span = still.tilt_span = 0;
  record(still);
  EXPECT_TRUE(says(run(), {"do not determine", "time_offset", "while the head moves"}));
  const fs::path table = folder_ / "in/head.csv";
  const std::string good = read_text(table);
  write_text(table, good + "5, 1, 2\n");
  EXPECT_TRUE(says(run(), {"head.csv:", "not later"}));
  write_text(table, good + "1e30\n");
  EXPECT_TRUE(says(run(), {"head.csv:", "expected 3"}));
  write_text(table, "# nothing\n");
  EXPECT_TRUE(says(run(), {"head.csv", "no head samples"}));
  write_text(table, "1, 0, 0\n2, 0, 0\n");
  EXPECT_TRUE(says(run(), {"none of 5 images", "no head samples around it"}));
  fs::remove(table);
  EXPECT_TRUE(says(run(), {"head.csv", "no such file"}));
  write_text(table, good);
  write_png(canvas(340, 480, {9, 9, 9}), folder_ / "in/first.png");
  EXPECT_TRUE(says(run(), {"first.png", "not named by its stamp"}));
  fs::remove(folder_ / "in/first.png");
  EXPECT_TRUE(says(run_headway({(folder_ / "in").string(), "--head", "--board", "9x6", "--square", "0.03",
                                "--out", (folder_ / "out").string()}),
                   {"--head", "expected --rig"}));
  EXPECT_EQ(run({"--corner", "1,2"}).code, kBadInput);
}

TEST(NeckFile, GivesTheRobotFileTheNeckThatWasFound) {
  const TemporaryFolder folder;
  hal::HeadKinematics neck = read_robot(kTree / "config/hrp2/robot.yaml").mission.neck;
  neck.tilt_from_camera.translation() += Vector3d(0.01, -0.02, 0.003);
  neck.tilt_from_camera.linear() =
      AngleAxisd(0.06, Vector3d(1, 0.2, -1).normalized()) * neck.tilt_from_camera.linear();
  neck.zero = {0.03, -0.02};
  std::string robot = read_text(kTree / "config/hrp2/robot.yaml"), keys = neck_text(neck, seconds(0.012));
  for (const char* key : {"  tilt_from_camera:", "  camera_down_deg:"}) {
    const std::size_t at = robot.find(key);
    ASSERT_NE(at, std::string::npos);
    robot.erase(at, robot.find('\n', at) + 1 - at);
  }
  robot.replace(robot.find("neck:\n"), 6, keys);
  robot.replace(robot.find("rig: "), robot.find('\n', robot.find("rig: ")) - robot.find("rig: "),
                "rig: " + (kTree / "config/hrp2/rigs/bottom.yaml").string());
  write_text(folder / "robot.yaml", robot);
  EXPECT_EQ(read_robot(folder / "robot.yaml").camera_time_offset, seconds(0.012));
  const hal::HeadKinematics read = read_robot(folder / "robot.yaml").mission.neck;
  for (const hal::HeadAngles a : {hal::HeadAngles{0, 0}, hal::HeadAngles{0.4, -0.3}})
    EXPECT_TRUE(read.chest_from_camera(a).isApprox(neck.chest_from_camera(a), 1e-6));
}

}  // namespace
}  // namespace headway::app
