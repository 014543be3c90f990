#include "vision/rig.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/angle.h"
#include "random_rig.h"
#include "same_rig.h"
#include "tests/source_dir/source_dir.h"
#include "tests/vision/scene.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

using test::random_rig;
using test::same;
using testing::HasSubstr;

const std::filesystem::path kRigs = source_dir() / "config/hrp2/rigs";

std::string file_text(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::string message_of(const std::string& text) {
  try {
    const auto section = config::Section::parse(text, "rig.yaml");
    rig_from(section);
    section.finish();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the rig file has no '" + from + "'");
  return text.replace(at, from.size(), to);
}

std::string key_of(const StereoRig& rig) {
  const auto fault = fault_of(rig);
  return fault ? fault->key : "";
}

RC_GTEST_PROP(Rig, AcceptsAnyReasonableArrangement, ()) {
  RC_ASSERT(key_of(random_rig(test::any_lens())) == "");
}

RC_GTEST_PROP(Rig, RefusesSwappedCameras, ()) {
  StereoRig rig = random_rig();
  rig.right_from_left = rig.right_from_left.inverse();
  RC_ASSERT(key_of(rig) == "right_from_left");
}

RC_GTEST_PROP(Rig, ProjectsRaysBackToTheirPixel, ()) {
  const CameraIntrinsics camera = test::random_camera(200, 150);
  const double u = test::between(0, 199), v = test::between(0, 149), z = test::between(0.1, 10);
  RC_ASSERT((camera.project(z * test::ray(camera, u, v)) - Eigen::Vector2d(u, v)).norm() < 1e-6);
}

TEST(Rig, MayBeVergedWithinReason) {
  StereoRig rig = read_rig(kRigs / "bottom.yaml");
  const auto verged = [&](double degrees) {
    StereoRig turned = rig;
    const Eigen::Vector3d right(0.144, 0, 0);
    turned.right_from_left.linear() =
        Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
    turned.right_from_left.translation() = -(turned.right_from_left.linear() * right);
    return fault_of(turned);
  };
  EXPECT_FALSE(verged(12)) << "towards each other";
  EXPECT_FALSE(verged(-8));
  ASSERT_TRUE(verged(40));
  EXPECT_THAT(verged(40)->what, HasSubstr("40.0 deg apart"));
}

TEST(Rig, NeedsViewsThatOverlap) {
  StereoRig rig = read_rig(kRigs / "bottom.yaml");
  rig.left.cx = 339, rig.right.cx = 0;  // one looks to the left, the other to the right
  rig.nearest = 3;
  const auto fault = fault_of(rig);
  ASSERT_TRUE(fault);
  EXPECT_THAT(fault->what, HasSubstr("the cameras share 0 % of their images"));
}

TEST(Rig, NamesTheKeyOfEachFault) {
  const StereoRig good = read_rig(kRigs / "bottom.yaml");
  const auto fault_after = [&](auto change) {
    StereoRig rig = good;
    change(rig);
    return key_of(rig);
  };
  EXPECT_EQ(fault_after([](StereoRig&) {}), "");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.left.fx = 0; }), "left.focal");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right.fy = NAN; }), "right.focal");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.left.cx = -1; }), "left.centre");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right.width = 320; }), "size");
  EXPECT_EQ(fault_after(
                [](StereoRig& r) { r.left.width = r.left.height = r.right.width = r.right.height = 16384; }),
            "size");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.left.k1 = -3; }), "left.distortion");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right_from_left.translation() *= 0.1; }), "right_from_left");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right_from_left.translation() *= 1000; }), "right_from_left");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right_from_left.translation() << 0, -0.144, 0; }),
            "right_from_left");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.right_from_left.linear() *= 1.1; }), "right_from_left");
  EXPECT_EQ(fault_after([](StereoRig& r) {
              r.right_from_left.linear() =
                  Eigen::AngleAxisd(20 * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
            }),
            "right_from_left");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.nearest = 0.2; }), "nearest");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.farthest = 0.5; }), "farthest");
  EXPECT_EQ(fault_after([](StereoRig& r) { r.disparity_sigma = 0; }), "disparity_sigma");
}

TEST(RigFiles, DescribeTheBottomPairOfTheHead) {
  for (const char* name : {"bottom.yaml", "bottom_640.yaml"}) {
    const StereoRig rig = read_rig(kRigs / name);
    EXPECT_NEAR(rig.baseline(), 0.144, 1e-3);
    EXPECT_NEAR(2 * std::atan(rig.left.width / 2.0 / rig.left.fx), 33 * kDegree, 0.01 * kDegree);
    EXPECT_GT(std::acos((rig.right_from_left.linear().trace() - 1) / 2), 0.3 * kDegree)
        << "rectification has work";
  }
  EXPECT_EQ(disparity_range(Rectifier(read_rig(kRigs / "bottom.yaml")).rig()).count, 112);
  EXPECT_EQ(disparity_range(Rectifier(read_rig(kRigs / "bottom_640.yaml")).rig()).count, 192);
}

TEST(RigFiles, PointAtTheLineOfAFault) {
  const std::string good = file_text(kRigs / "bottom.yaml");
  ASSERT_EQ(message_of(good), "");
  const auto after = [&](const char* from, const char* to) { return message_of(replaced(good, from, to)); };
  EXPECT_THAT(after("nearest: 0.8", "nearest: none"),
              HasSubstr("rig.yaml:21: nearest: 'none', expected a number"));
  EXPECT_THAT(after("nearest: 0.8", "nearest: 0.1"),
              HasSubstr("rig.yaml:21: nearest: 0.1 m: images as near"));
  EXPECT_THAT(after("nearest: 0.8", "nearset: 0.8"),
              HasSubstr("nearset: is not a key here, did you mean 'nearest'?"));
  EXPECT_THAT(after("name: bottom", "name: bottom\ncolour: red"), HasSubstr("colour: is not a key here"));
  EXPECT_THAT(after("translation: [-", "translation: ["),
              HasSubstr("rig.yaml:17: right_from_left: puts the right"));
  EXPECT_THAT(after("focal: [573.91, 573.91]", "focal: [573.91]"), HasSubstr("left.focal: a list of 1"));
  EXPECT_THAT(after("distortion: [-0.080", "distortion: [-8.0"),
              HasSubstr("left.distortion: folds the image over"));
}

RC_GTEST_PROP(RigFiles, ReadBackWhatTheyWrote, ()) {
  StereoRig rig = random_rig(test::any_lens());
  rig.name = "it's a rig: #1";
  rig.disparity_sigma = 0.1;
  const std::filesystem::path file = testing::TempDir() + "written_rig.yaml";
  write_rig(rig, file);
  const StereoRig back = read_rig(file);
  RC_ASSERT(back.name == rig.name);
  RC_ASSERT(same(back.left, rig.left) && same(back.right, rig.right));
  RC_ASSERT(back.right_from_left.isApprox(rig.right_from_left, 1e-12));
  RC_ASSERT(back.right_from_left.translation() == rig.right_from_left.translation());
  RC_ASSERT(back.nearest == rig.nearest && back.farthest == rig.farthest);
  RC_ASSERT(back.disparity_sigma == rig.disparity_sigma);
}

TEST(RigFiles, RefuseToWriteWhatCannotBeReadBack) {
  StereoRig rig = read_rig(kRigs / "bottom.yaml");
  EXPECT_THROW(write_rig(rig, "no/such/folder/rig.yaml"), InputError);
  rig.nearest = 0;
  EXPECT_THROW(write_rig(rig, testing::TempDir() + "unusable_rig.yaml"), InputError);
}

TEST(RigFiles, SayWhenTheFileIsMissing) {
  EXPECT_THROW(read_rig("no/such/rig.yaml"), InputError);
  EXPECT_THROW(read_euroc_rig("no/such/folder"), InputError);
}

RC_GTEST_PROP(RigFiles, NeverDoWorseThanAnInputErrorOnDamagedText, ()) {
  static const std::string good = file_text(kRigs / "bottom.yaml");
  std::string text = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size() + 1));
  for (int i = *rc::gen::inRange(0, 6); i > 0 && !text.empty(); --i)
    text[*rc::gen::inRange<std::size_t>(0, text.size())] = static_cast<char>(*rc::gen::inRange(0, 256));
  try {
    const auto section = config::Section::parse(text, "rig.yaml");
    const StereoRig rig = rig_from(section);
    RC_ASSERT(!fault_of(rig));
    Rectifier rectifier(rig);  // what was accepted can be used
  } catch (const InputError& e) {
    RC_ASSERT(std::string(e.what()).find('\n') == std::string::npos);
  }
}

TEST(RigFiles, ReadEurocCalibration) {
  if (test::data_folder().empty()) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const StereoRig rig = read_euroc_rig(test::data_folder() / "sequence/euroc");
  EXPECT_NEAR(rig.baseline(), 0.11007, 1e-4) << "as published for the VI sensor";
  EXPECT_EQ(rig.left.width, 752);
  EXPECT_DOUBLE_EQ(rig.left.fx, 458.654);
  EXPECT_DOUBLE_EQ(rig.right.p2, -3.555907e-05);
}

}  // namespace
}  // namespace headway::vision
