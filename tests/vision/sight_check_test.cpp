// Plants each fault in healthy pairs, real and made, and asks for its name; and asks for silence on healthy
// ones.
#include "vision/sight_check.h"

#include <cmath>
#include <functional>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/source_dir/source_dir.h"
#include "tests/vision/scene.h"
#include "vision/cv_image.h"
#include "vision/image_files.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kConfig = source_dir() / "config";
const fs::path kExamples = "/usr/share/doc/opencv-doc/examples/data";

struct Scene {
  hal::GrayImage left, right;
  RectifiedRig rig;

  SightReport check() const { return check_sight(left, right, rig); }
};

// A pair that is rectified already; its focal length matters only together with the nearest disparity.
Scene rectified_pair(const fs::path& left, const fs::path& right, double largest_disparity) {
  StereoRig rig;
  Scene scene{read_gray(left), read_gray(right), {}};
  rig.left.width = scene.left.width, rig.left.height = scene.left.height;
  rig.left.fx = rig.left.fy = scene.left.width;
  rig.left.cx = (scene.left.width - 1) / 2.0, rig.left.cy = (scene.left.height - 1) / 2.0;
  rig.right = rig.left;
  rig.right_from_left.translation().x() = -0.1;
  rig.nearest = rig.left.fx * 0.1 / largest_disparity;
  rig.farthest = 100;
  scene.rig = Rectifier(rig).rig();
  return scene;
}

Scene seen_through(const StereoRig& rig, const hal::GrayImage& left, const hal::GrayImage& right) {
  const Rectifier rectifier(rig);
  Scene scene{{}, {}, rectifier.rig()};
  rectifier.rectify(left, right, scene.left, scene.right);
  return scene;
}

StereoRig bottom() { return read_rig(kConfig / "hrp2/rigs/bottom.yaml"); }

Scene plane(double distance) {
  const auto frame = test::plane_seen_by(bottom(), Eigen::Vector3d(0.1, -0.2, 1).normalized(), distance);
  return seen_through(bottom(), frame.left, frame.right);
}

fs::path euroc() { return test::data_folder() / "sequence/euroc"; }

Scene hall(const std::string& stamp) {
  return seen_through(read_euroc_rig(euroc()), read_gray(euroc() / "cam0/data" / (stamp + ".png")),
                      read_gray(euroc() / "cam1/data" / (stamp + ".png")));
}

// Nothing where the images are not installed.
std::optional<Scene> scene_named(const std::string& name) {
  const fs::path stereo = test::data_folder() / "stereo";
  if (name == "near plane") return plane(1);
  if (name == "far plane") return plane(5);
  if (name == "aloe")
    return fs::exists(kExamples / "aloeL.jpg")
               ? std::optional(rectified_pair(kExamples / "aloeL.jpg", kExamples / "aloeR.jpg", 260))
               : std::nullopt;
  if (test::data_folder().empty()) return std::nullopt;
  if (name == "tsukuba") return rectified_pair(stereo / "tsukuba/left.png", stereo / "tsukuba/right.png", 20);
  if (name == "hall") return hall("1403715274262142976");
  return seen_through(read_rig(kConfig / "rigs/middlebury_motorcycle.yaml"),
                      read_gray(stereo / "motorcycle/left.png"), read_gray(stereo / "motorcycle/right.png"));
}

hal::GrayImage changed(hal::GrayImage image, const std::function<void(cv::Mat&)>& change) {
  cv::Mat pixels = as_mat(image);
  change(pixels);
  return image;
}

hal::GrayImage blurred(const hal::GrayImage& image, double sigma) {
  return changed(image, [&](cv::Mat& m) { cv::GaussianBlur(m, m, {0, 0}, sigma); });
}

hal::GrayImage covered(const hal::GrayImage& image) {
  return changed(image, [](cv::Mat& m) {
    cv::RNG noise(7);
    noise.fill(m, cv::RNG::NORMAL, 20, 2);
  });
}

hal::GrayImage moved(const hal::GrayImage& image, const cv::Matx23d& by) {
  return changed(image, [&](cv::Mat& m) {
    cv::Mat out;
    cv::warpAffine(m, out, by, m.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    out.copyTo(m);
  });
}

hal::GrayImage lowered(const hal::GrayImage& image, double rows) {
  return moved(image, {1, 0, 0, 0, 1, rows});
}

class SightOf : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    auto scene = scene_named(GetParam());
    if (!scene)
      GTEST_SKIP() << "the images are not here: HEADWAY_DATA is not set, or opencv-doc not installed";
    scene_ = std::move(*scene);
  }
  Scene scene_;
};

INSTANTIATE_TEST_SUITE_P(Scenes, SightOf,
                         testing::Values("near plane", "far plane", "motorcycle", "aloe", "tsukuba", "hall"),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
                           return name;
                         });

TEST_P(SightOf, AHealthyPairHasNoFindings) {
  const SightReport report = scene_.check();
  for (const SightFinding& finding : report.findings) ADD_FAILURE() << finding.what;
  EXPECT_GT(report.pair.found, 0.4 * report.pair.looked_for);
  EXPECT_LT(report.pair.row_error, 0.2);
  EXPECT_LT(report.pair.behind_infinity, 0.1);
}

TEST_P(SightOf, SwappedCamerasIsNamed) {
  std::swap(scene_.left, scene_.right);
  const SightReport report = scene_.check();
  EXPECT_TRUE(report.has(SightFault::kSwapped));
  ASSERT_NE(report.fault(), nullptr);
  EXPECT_THAT(report.fault()->what, HasSubstr("swapped"));
}

TEST_P(SightOf, ACoveredCameraIsNamed) {
  const Scene whole = scene_;
  scene_.left = covered(whole.left);
  ASSERT_NE(scene_.check().fault(), nullptr);
  EXPECT_THAT(scene_.check().fault()->what, HasSubstr("the left camera shows nothing"));
  scene_ = whole;
  scene_.right = covered(whole.right);
  ASSERT_NE(scene_.check().fault(), nullptr);
  EXPECT_THAT(scene_.check().fault()->what, HasSubstr("the right camera shows nothing"));
}

TEST_P(SightOf, AHandBeforeMostOfACameraIsAWarning) {
  scene_.right = changed(scene_.right, [](cv::Mat& m) { m.colRange(0, m.cols * 6 / 10) = 8; });
  const SightReport report = scene_.check();
  EXPECT_TRUE(report.has(SightFault::kCovered));
  EXPECT_EQ(report.fault(), nullptr);
}

TEST_P(SightOf, ASaturatedCameraIsNamed) {
  scene_.right = changed(scene_.right, [](cv::Mat& m) { m *= 12; });
  const SightReport report = scene_.check();
  EXPECT_TRUE(report.has(SightFault::kSaturated));
  EXPECT_NE(report.fault(), nullptr);
  EXPECT_GT(report.right.white, 0.6);
  EXPECT_LT(report.left.white, 0.25);
}

TEST_P(SightOf, ADarkerCameraIsNoFault) {
  scene_.right = changed(scene_.right, [](cv::Mat& m) { m *= 0.5; });
  EXPECT_TRUE(scene_.check().findings.empty());
}

TEST_P(SightOf, ABlurredCameraIsNamedAndNothingElseIs) {
  const Scene sharp = scene_;
  for (const double sigma : {1.5, 3.0}) {
    scene_.left = blurred(sharp.left, sigma), scene_.right = sharp.right;
    SightReport report = scene_.check();
    ASSERT_NE(report.fault(), nullptr);
    EXPECT_THAT(report.fault()->what, HasSubstr("the left image is blurred"));
    EXPECT_FALSE(report.has(SightFault::kDecalibrated)) << sigma;
    scene_.left = sharp.left, scene_.right = blurred(sharp.right, sigma);
    report = scene_.check();
    ASSERT_NE(report.fault(), nullptr);
    EXPECT_THAT(report.fault()->what, HasSubstr("the right image is blurred"));
    EXPECT_FALSE(report.has(SightFault::kDecalibrated)) << sigma;
  }
}

TEST_P(SightOf, MotionBlurOfBothIsAWarning) {
  scene_.left = blurred(scene_.left, 3), scene_.right = blurred(scene_.right, 3);
  const SightReport report = scene_.check();
  EXPECT_TRUE(report.has(SightFault::kBlurred));
  EXPECT_EQ(report.fault(), nullptr);
}

TEST_P(SightOf, AShiftOfTheRowsIsMeasured) {
  const double before = scene_.check().pair.row_offset;
  const hal::GrayImage right = scene_.right;
  for (const double rows : {-12.0, -1.0, -0.5, 0.25, 0.5, 1.0, 5.0}) {
    scene_.right = lowered(right, rows);
    const SightReport report = scene_.check();
    EXPECT_NEAR(report.pair.row_offset, before + rows, 0.12);
    EXPECT_NEAR(report.pair.row_error, std::abs(before + rows), 0.2);
    EXPECT_EQ(report.has(SightFault::kDecalibrated), std::abs(rows) >= 0.5) << rows;
    EXPECT_EQ(report.fault() != nullptr, std::abs(rows) >= 1) << rows;
  }
}

TEST_P(SightOf, ACameraThatRolledIsNamedThoughItsMeanRowIsRight) {
  const double c = std::cos(0.02), s = std::sin(0.02), u = scene_.right.width / 2.0,
               v = scene_.right.height / 2.0;
  scene_.right = moved(scene_.right, {c, -s, u - c * u + s * v, s, c, v - s * u - c * v});
  EXPECT_TRUE(scene_.check().has(SightFault::kDecalibrated));
  EXPECT_NE(scene_.check().fault(), nullptr);
}

TEST_P(SightOf, ImagesOfDifferentMomentsAreNamed) {
  scene_.right = changed(scene_.right, [](cv::Mat& m) { cv::flip(m, m, -1); });
  const SightReport report = scene_.check();
  EXPECT_TRUE(report.has(SightFault::kDifferent));
  EXPECT_NE(report.fault(), nullptr);
}

TEST_P(SightOf, TheSamePairGivesTheSameReport) {
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const SightReport one = scene_.check();
  cv::setNumThreads(4);
  const SightReport four = scene_.check();
  cv::setNumThreads(threads);
  EXPECT_EQ(one.pair.found, four.pair.found);
  EXPECT_EQ(one.pair.row_offset, four.pair.row_offset);
  EXPECT_EQ(one.pair.row_error, four.pair.row_error);
  EXPECT_EQ(one.left.sharpness, four.left.sharpness);
}

TEST(Sight, SaysNothingBeforeABlankWall) {
  Scene wall = plane(2);
  for (hal::GrayImage* image : {&wall.left, &wall.right})
    *image = changed(*image, [](cv::Mat& m) { m = 140; });
  EXPECT_TRUE(wall.check().findings.empty());
}

TEST(Sight, SaysThatBothCamerasAreDark) {
  Scene night = plane(2);
  for (hal::GrayImage* image : {&night.left, &night.right})
    *image = changed(*image, [](cv::Mat& m) { m *= 0.05; });
  ASSERT_NE(night.check().fault(), nullptr);
  EXPECT_THAT(night.check().fault()->what, HasSubstr("both cameras are dark"));
}

SightReport check_raw(const StereoRig& rig, const hal::GrayImage& left, const hal::GrayImage& right) {
  const Rectifier rectifier(rig);
  const Scene scene = seen_through(rig, left, right);
  hal::StereoFrame raw;
  raw.left = left, raw.right = right;
  return check_sight(rectifier, raw, scene.left, scene.right);
}

TEST(Sight, NamesARigThatBentSinceItWasCalibrated) {
  for (const double pitch : {0.002, -0.004, 0.03}) {
    StereoRig bent = bottom();
    bent.right_from_left.linear() =
        Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) * bent.right_from_left.linear();
    const auto frame = test::plane_seen_by(bent, Eigen::Vector3d(0.1, -0.2, 1).normalized(), 2);
    const SightReport report = check_raw(bottom(), frame.left, frame.right);
    ASSERT_EQ(report.findings.size(), 1U);
    EXPECT_EQ(report.findings[0].fault, SightFault::kDecalibrated);
    EXPECT_EQ(report.findings[0].severity, Severity::kFault);
    EXPECT_NEAR(report.pair.row_error, std::abs(pitch) * bent.left.fx, 0.3 + 0.05 * report.pair.row_error);
  }
}

void expect_swapped(const SightReport& report) {
  ASSERT_EQ(report.findings.size(), 1U);
  EXPECT_EQ(report.findings[0].fault, SightFault::kSwapped);
  EXPECT_THAT(report.findings[0].what, HasSubstr("left and right are swapped"));
}

TEST(Sight, NamesRawCamerasThatWereSwapped) {
  const auto frame = test::plane_seen_by(bottom(), Eigen::Vector3d::UnitZ(), 2);
  EXPECT_TRUE(check_raw(bottom(), frame.left, frame.right).findings.empty());
  expect_swapped(check_raw(bottom(), frame.right, frame.left));
}

// The cameras of the hall differ so much that exchanged images lie 26 rows apart, with disparities above
// zero.
TEST(Sight, NamesTheSwappedCamerasOfTheHall) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const auto left = read_gray(euroc() / "cam0/data/1403715274262142976.png"),
             right = read_gray(euroc() / "cam1/data/1403715274262142976.png");
  expect_swapped(check_raw(read_euroc_rig(euroc()), right, left));
}

TEST(Sight, IsHealthyInAllPairsOfTheHall) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  int pairs = 0;
  for (const auto& entry : fs::directory_iterator(euroc() / "cam0/data")) {
    const Scene scene = hall(entry.path().stem().string());
    for (const SightFinding& finding : scene.check().findings) ADD_FAILURE() << entry.path() << finding.what;
    ++pairs;
  }
  EXPECT_EQ(pairs, 14);
}

}  // namespace
}  // namespace headway::vision
