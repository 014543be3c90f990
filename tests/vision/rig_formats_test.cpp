// Calibrations as ROS, Kalibr, OpenCV and EuRoC's tools write them: read back right, refused clearly.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core/eigen.hpp>
#include <opencv2/core/persistence.hpp>
#include <rapidcheck/gtest.h>

#include "random_rig.h"
#include "same_rig.h"
#include "tests/source_dir/source_dir.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

namespace fs = std::filesystem;
using test::any_lens;
using test::random_rig;
using test::same;
using testing::HasSubstr;
using testing::StartsWith;

fs::path scratch(const std::string& name) { return fs::path(testing::TempDir()) / name; }

fs::path written(const std::string& name, const std::string& text) {
  std::ofstream(scratch(name), std::ios::binary) << text;
  return scratch(name);
}

std::string message_of(const fs::path& path, const RigDefaults& defaults = {}) {
  try {
    read_rig(path, defaults);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the text has no '" + from + "'");
  return text.replace(at, from.size(), to);
}

// ROS, as camera_calibration writes each camera of a stereo pair.
std::string camera_info(const std::string& side, double shift) {
  return fmt::format(R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/{}
camera_matrix:
  rows: 3
  cols: 3
  data: [500.5, 0.     , 319.5,
         0.     , 501.5, 239.5,
         0.     , 0.     , 1.     ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.25, 0.06, 0.001, -0.002, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1., 0., 0., 0., 1., 0., 0., 0., 1.]
projection_matrix:
  rows: 3
  cols: 4
  data: [450., 0.     , 320., {},
         0.     , 450., 240., 0.     ,
         0.     , 0.     , 1.     , 0.     ]
)",
                     side, shift);
}

const std::string kKalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.003, 0.0008, -0.001, 0.0002]
  distortion_model: equidistant
  intrinsics: [190.97, 190.96, 254.93, 256.89]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9999, 0.0, -0.014142, -0.101]
  - [0.0, 1.0, 0.0, 0.002]
  - [0.014142, 0.0, 0.9999, 0.001]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.25, 0.05, 0.001, -0.001]
  distortion_model: radtan
  intrinsics: [290.4, 290.3, 252.6, 255.3]
  resolution: [512, 512]
  rostopic: /cam1/image_raw
)";

std::string sensor(double x) {
  return fmt::format(R"(%YAML:1.0
# General sensor definitions.
sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0.0, 0.0, 1.0, 0.0,
         -1.0, 0.0, 0.0, {},
         0.0, -1.0, 0.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.6, 457.3, 367.2, 248.4] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.283, 0.074, 0.0002, 1.8e-05]
)",
                     x);
}

// OpenCV's own writer.
void write_opencv(const StereoRig& rig, const fs::path& intrinsics, const fs::path& extrinsics,
                  bool with_size) {
  const auto matrix = [](const CameraIntrinsics& c) {
    return cv::Mat(cv::Matx33d(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1));
  };
  const auto coefficients = [](const CameraIntrinsics& c) -> cv::Mat {
    if (c.lens == LensModel::kEquidistant) return (cv::Mat_<double>(4, 1) << c.k1, c.k2, c.k3, c.k4);
    if (c.lens == LensModel::kRadialTangential)
      return (cv::Mat_<double>(1, 5) << c.k1, c.k2, c.p1, c.p2, c.k3);
    return (cv::Mat_<double>(1, 14) << c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6, 0, 0, 0, 0, 0, 0);
  };
  cv::Mat r, t;
  cv::eigen2cv(Eigen::Matrix3d(rig.right_from_left.linear()), r);
  cv::eigen2cv(Eigen::Vector3d(rig.right_from_left.translation()), t);
  cv::FileStorage in(intrinsics.string(), cv::FileStorage::WRITE);
  if (with_size) in << "image_width" << rig.left.width << "image_height" << rig.left.height;
  if (rig.left.lens == LensModel::kEquidistant) in << "fisheye_model" << 1;
  in << "M1" << matrix(rig.left) << "D1" << coefficients(rig.left);
  in << "M2" << matrix(rig.right) << "D2" << coefficients(rig.right);
  if (extrinsics == intrinsics) {
    in << "R" << r << "T" << t;
    return;
  }
  cv::FileStorage ex(extrinsics.string(), cv::FileStorage::WRITE);
  ex << "R" << r << "T" << t;
}

RC_GTEST_PROP(OpenCvRig, IsReadAsOpenCvWroteIt, ()) {
  const StereoRig rig = random_rig(any_lens());
  const bool together = *rc::gen::arbitrary<bool>(), with_size = *rc::gen::arbitrary<bool>();
  const fs::path in = scratch("intrinsics_1.yml"), ex = together ? in : scratch("extrinsics_1.yml");
  write_opencv(rig, in, ex, with_size);
  RigDefaults defaults;
  defaults.nearest = rig.nearest, defaults.farthest = rig.farthest;
  if (!with_size) defaults.width = rig.left.width, defaults.height = rig.left.height;
  const StereoRig back = read_rig(together ? in : fs::path(in.string() + "," + ex.string()), defaults);
  RC_ASSERT(same(back.left, rig.left) && same(back.right, rig.right));
  RC_ASSERT(back.right_from_left.isApprox(rig.right_from_left, 1e-12));
  RC_ASSERT(back.nearest == rig.nearest && back.farthest == rig.farthest);
}

TEST(OpenCvRig, AsksForTheSizeThatTheSampleLeavesOut) {
  const StereoRig rig = read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml");
  const fs::path folder = scratch("opencv_sample");
  fs::create_directories(folder);
  write_opencv(rig, folder / "intrinsics.yml", folder / "extrinsics.yml", false);
  EXPECT_THAT(message_of(folder), HasSubstr("add image_width and image_height"));
  EXPECT_EQ(message_of(folder, {.width = 340, .height = 480}), "");
  EXPECT_THAT(message_of(folder / "extrinsics.yml"),
              HasSubstr("expected both files: intrinsics.yml,extrinsics.yml"));
}

TEST(OpenCvRig, SaysThatABaselineIsInSquares) {
  StereoRig rig = read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml");
  rig.right_from_left.translation() *= 3.33 / 0.144;
  write_opencv(rig, scratch("in_squares.yml"), scratch("in_squares.yml"), true);
  EXPECT_THAT(message_of(scratch("in_squares.yml")),
              testing::ContainsRegex("in_squares.yml:[0-9]+: T: the cameras are "
                                     "3.33 m apart"));
}

RC_GTEST_PROP(CameraInfo, IsReadBackAsItWasWritten, ()) {
  const StereoRig rig = random_rig(any_lens());
  const fs::path left = scratch("left_1.yaml"), right = scratch("right_1.yaml");
  write_camera_info(rig, left, right);
  const StereoRig back =
      read_rig(left.string() + "," + right.string(), {.nearest = rig.nearest, .farthest = rig.farthest});
  RC_ASSERT(same(back.left, rig.left) && same(back.right, rig.right));
  RC_ASSERT((back.right_from_left.matrix() - rig.right_from_left.matrix()).norm() < 1e-9);
}

TEST(CameraInfo, IsReadFromAFolderAsRosWroteIt) {
  const fs::path folder = scratch("ros");
  fs::create_directories(folder);
  written("ros/left.yaml", camera_info("left", 0)), written("ros/right.yaml", camera_info("right", -54));
  const StereoRig rig = read_rig(folder);
  EXPECT_DOUBLE_EQ(rig.baseline(), 0.12);
  EXPECT_DOUBLE_EQ(rig.right_from_left.translation().x(), -0.12);
  EXPECT_EQ(rig.left.width, 640);
  EXPECT_EQ(rig.left.fy, 501.5);
  EXPECT_EQ(rig.right.p2, -0.002);
  EXPECT_EQ(rig.nearest, 0.8);
}

TEST(CameraInfo, SaysWhatIsWrongAndWhere) {
  const std::string left = written("l.yaml", camera_info("left", 0)).string();
  const auto after = [&](const std::string& from, const std::string& to, double shift = -54) {
    return message_of(left + "," +
                      written("r.yaml", replaced(camera_info("right", shift), from, to)).string());
  };
  EXPECT_EQ(after("rows", "rows"), "");
  EXPECT_THAT(after("rows", "rows", 54),
              HasSubstr("r.yaml:19: projection_matrix: its [0, 3] is 54, expected less than 0"));
  EXPECT_THAT(after("rows", "rows", 0), HasSubstr("are left and right swapped?"));
  EXPECT_THAT(after("rows", "rows", -54000),
              HasSubstr("r.yaml:19: projection_matrix: the cameras are 120 m apart"));
  EXPECT_THAT(after("image_width: 640", "image_width: 641"),
              HasSubstr("r.yaml:1: image_width: left 640 x 480, right 641"));
  EXPECT_THAT(after("[1., 0., 0., 0., 1.", "[1., 0., 0., 0., 2."),
              HasSubstr("r.yaml:15: rectification_matrix: is not a rotation"));
  EXPECT_THAT(after("plumb_bob", "thin_prism"),
              HasSubstr("r.yaml:10: distortion_model: 'thin_prism', expected one of"));
  EXPECT_THAT(after("plumb_bob", "equidistant"), HasSubstr("5 coefficients, expected 4"));
  EXPECT_THAT(after("[-0.25, 0.06", "[0.06, -25"),
              HasSubstr("r.yaml:11: distortion_coefficients: folds the image"));
  EXPECT_THAT(message_of(left), HasSubstr("describes one camera, expected the files of both"));
  EXPECT_THAT(message_of(written("r.yaml", camera_info("right", -54)).string() + "," + left),
              HasSubstr("r.yaml:19: projection_matrix: its [0, 3] is -54, expected 0 of the left camera"));
}

TEST(KalibrChain, TakesPointsOfTheFirstCameraToTheSecond) {
  const StereoRig rig = read_rig(written("camchain.yaml", kKalibr));
  EXPECT_EQ(rig.left.lens, LensModel::kEquidistant);
  EXPECT_EQ(rig.left.k4, 0.0002);
  EXPECT_EQ(rig.right.lens, LensModel::kRadialTangential);
  EXPECT_EQ(rig.right.p2, -0.001);
  EXPECT_EQ(rig.right_from_left.translation(), Eigen::Vector3d(-0.101, 0.002, 0.001));
  EXPECT_NEAR(rig.right_from_left.linear()(2, 0), 0.014142, 1e-5);
}

TEST(KalibrChain, SaysWhatIsWrongAndWhere) {
  const auto after = [&](const std::string& from, const std::string& to) {
    return message_of(written("chain.yaml", replaced(kKalibr, from, to)));
  };
  EXPECT_THAT(after("-0.101]", "0.101]"),
              HasSubstr("chain.yaml:10: cam1.T_cn_cnm1: puts the right camera to the left"));
  EXPECT_THAT(after("0.0, -0.014142, -0.101]", "-0.101]"),
              HasSubstr("expected a list of 4 lists of 4 numbers"));
  EXPECT_THAT(after("0.0, 1.0]\n  cam_overlaps", "0.0, 2.0]\n  cam_overlaps"),
              HasSubstr("its last row is not 0 0 0 1"));
  EXPECT_THAT(after("pinhole", "omni"),
              HasSubstr("chain.yaml:3: cam0.camera_model: 'omni', expected one of: pinhole"));
  EXPECT_THAT(after("[512, 512]", "[512, 511]"), HasSubstr("chain.yaml:20: cam1.resolution: left 512 x 511"));
  EXPECT_THAT(after("cam1:", "cam2:"), HasSubstr("the key 'cam1' is missing"));
}

TEST(EurocSensors, AreReadFromTheirFolder) {
  fs::create_directories(scratch("euroc/cam0")), fs::create_directories(scratch("euroc/cam1"));
  written("euroc/cam0/sensor.yaml", sensor(0.06)), written("euroc/cam1/sensor.yaml", sensor(-0.05));
  const StereoRig rig = read_rig(scratch("euroc"));
  EXPECT_NEAR((rig.right_from_left.translation() - Eigen::Vector3d(-0.11, 0, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(rig.left.fx, 458.6);
  written("euroc/cam0/sensor.yaml", sensor(-0.05)), written("euroc/cam1/sensor.yaml", sensor(0.06));
  EXPECT_THAT(message_of(scratch("euroc")),
              HasSubstr("sensor.yaml:4: T_BS: puts the right camera to the left"));
}

TEST(RigFiles, ReadAFolderWithOneRigFile) {
  const fs::path ours = source_dir() / "config/hrp2/rigs/bottom.yaml";
  fs::create_directories(scratch("calibrated"));
  fs::copy_file(ours, scratch("calibrated") / "rig.yaml", fs::copy_options::overwrite_existing);
  EXPECT_EQ(read_rig(scratch("calibrated")).left.fx, read_rig(ours).left.fx);
}

TEST(AnyRigFile, IsRefusedInOneLineWhenItIsAnImage) {
  const fs::path image = written("photo.jpg", std::string("\xff\xd8\xff\xe0\0\x10JFIF", 10));
  EXPECT_THAT(message_of(image), testing::EndsWith("photo.jpg: not a text file, expected YAML"));
}

TEST(AnyRigFile, IsRefusedInOneLineWhenItIsNoCalibration) {
  EXPECT_THAT(message_of(written("other.yaml", "width: 3\n")),
              HasSubstr("other.yaml:1: no calibration of two cameras"));
  EXPECT_THAT(message_of(written("empty.yaml", "")), HasSubstr("empty.yaml: holds nothing"));
  EXPECT_THAT(message_of("no/such/file.yaml"), HasSubstr("no/such/file.yaml: no such calibration file"));
  fs::create_directories(scratch("empty_folder"));
  EXPECT_THAT(message_of(scratch("empty_folder")),
              HasSubstr("empty_folder: holds no calibration, expected left.yaml"));
  const auto info = written("l2.yaml", camera_info("left", 0)), chain = written("c2.yaml", kKalibr);
  EXPECT_THAT(message_of(info.string() + "," + chain.string()), HasSubstr("c2.yaml:1: does not go with"));
}

// Whatever a file holds, reading ends with a usable rig or with one line that starts with the file.
RC_GTEST_PROP(AnyRigFile, NeverDoesWorseThanAnInputErrorThatNamesIt, ()) {
  const std::string chosen = *rc::gen::element<std::string>("kalibr", "ros", "euroc", "opencv");
  std::string text = kKalibr;
  if (chosen == "ros") text = camera_info("right", -54);
  if (chosen == "euroc") text = sensor(-0.05);
  if (chosen == "opencv") {
    static const StereoRig rig = read_rig(source_dir() / "config/hrp2/rigs/bottom.yaml");
    write_opencv(rig, scratch("m.yml"), scratch("m.yml"), true);
    std::ifstream in(scratch("m.yml"));
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  if (*rc::gen::arbitrary<bool>()) text.resize(*rc::gen::inRange<std::size_t>(0, text.size() + 1));
  for (int i = *rc::gen::inRange(0, 6); i > 0 && !text.empty(); --i)
    text[*rc::gen::inRange<std::size_t>(0, text.size())] = static_cast<char>(*rc::gen::inRange(0, 256));
  const fs::path damaged = written("damaged.yaml", text);
  fs::path path = damaged;
  if (chosen == "ros")
    path = written("whole_l.yaml", camera_info("left", 0)).string() + "," + damaged.string();
  if (chosen == "euroc") path = written("whole_s.yaml", sensor(0.06)).string() + "," + damaged.string();
  try {
    const StereoRig rig = read_rig(path);
    RC_ASSERT(!fault_of(rig));
    Rectifier rectifier(rig);  // what was accepted can be used
  } catch (const InputError& e) {
    const std::string message = e.what();
    RC_ASSERT(message.find('\n') == std::string::npos);
    RC_ASSERT(message.starts_with(damaged.string()) || message.starts_with(testing::TempDir() + "whole_") ||
              message.starts_with("rig " + path.string()));
  }
}

// A word in place of a number is found at its line, wherever it stands.
RC_GTEST_PROP(AnyRigFile, PointsAtTheLineOfAWordInPlaceOfANumber, ()) {
  std::vector<std::pair<std::size_t, std::size_t>> numbers;  // of lists that the reader needs
  const auto of_number = [](char c) { return c == '-' || c == '.' || (c >= '0' && c <= '9'); };
  for (auto end = kKalibr.begin(); end != kKalibr.end();) {
    const auto begin = std::find_if(end, kKalibr.end(), of_number);
    end = std::find_if_not(begin, kKalibr.end(), of_number);
    const bool decimal = std::count(begin, end, '.') == 1 && end - begin > 2;
    if (decimal) numbers.emplace_back(begin - kKalibr.begin(), end - begin);
  }
  const auto [at, length] = *rc::gen::elementOf(numbers);
  const auto line = 1 + std::count(kKalibr.begin(), kKalibr.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const std::string damaged = std::string(kKalibr).replace(at, length, "wide");
  const std::string message = message_of(written("word.yaml", damaged));
  // A matrix over several lines is named by its key.
  const auto named = line >= 11 && line <= 14 ? 10 : line;
  RC_ASSERT(message.find(fmt::format("word.yaml:{}: ", named)) != std::string::npos);
  RC_ASSERT(message.find("'wide', expected a number") != std::string::npos);
}

}  // namespace
}  // namespace headway::vision
