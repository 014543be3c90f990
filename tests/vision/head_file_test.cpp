#include "vision/head_file.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "tests/source_dir/source_dir.h"
#include "vision/rectify.h"
#include "vision/rig_files.h"

namespace headway::vision {
namespace {

using testing::HasSubstr;

const std::filesystem::path kConfig = source_dir() / "config/hrp2";

const HeadRig& rig_named(const CameraHead& head, const std::string& name) {
  for (const HeadRig& rig : head.rigs)
    if (rig.rig.name == name) return rig;
  throw std::logic_error("no rig " + name);
}

TEST(CameraHead, OfHrp2HasFourCamerasAndTwoPairs) {
  for (const auto& [file, field] : {std::pair("head.yaml", 25.0), {"head_33.yaml", 33.0}}) {
    const CameraHead head = read_head(kConfig / file);
    ASSERT_EQ(head.cameras.size(), 4U);
    const StereoRig &bottom = rig_named(head, "bottom").rig, &top = rig_named(head, "top").rig;
    EXPECT_NEAR(bottom.baseline(), 0.144, 1e-12);
    EXPECT_NEAR(top.baseline(), 0.058, 1e-12);
    EXPECT_NEAR(2 * std::atan(170 / bottom.left.fx), field * kDegree, 1e-9);
    EXPECT_NEAR(2 * std::atan(170 / top.right.fx), 90 * kDegree, 1e-9);
  }
}

TEST(CameraHead, AgreesWithTheRobotsOwnRig) {
  const HeadRig bottom = rig_named(read_head(kConfig / "head_33.yaml"), "bottom");
  const StereoRig calibrated = read_rig(kConfig / "rigs/bottom.yaml");
  EXPECT_NEAR(bottom.rig.left.fx, calibrated.left.fx, 0.02);
  EXPECT_NEAR(bottom.rig.baseline(), calibrated.baseline(), 1e-5);
  // As in robot.yaml: tilt_from_camera and camera_down_deg.
  EXPECT_EQ(bottom.head_from_left.translation(), Eigen::Vector3d(0.035, 0.072, 0.045));
  const Eigen::Vector3d axis = bottom.head_from_left.linear().col(2);
  EXPECT_NEAR(std::asin(-axis.z()), 10 * kDegree, 1e-12);
  EXPECT_NEAR(axis.y(), 0, 1e-12);
}

// A wide camera beside a narrow one: what both see is what the narrow one sees.
TEST(CameraHead, RectifiesTheUnequalPairToTheNarrowField) {
  const StereoRig top = rig_named(read_head(kConfig / "head.yaml"), "top").rig;
  const PinholeCamera c = Rectifier(top).camera();
  EXPECT_NEAR(c.focal, top.left.fx, 0.01 * top.left.fx);
  EXPECT_NEAR(2 * std::atan(c.width / 2.0 / c.focal), 25 * kDegree, 0.5 * kDegree);
}

std::string message_of(const std::string& from, const std::string& to) {
  std::ifstream in(kConfig / "head.yaml");
  std::string text(std::istreambuf_iterator<char>(in), {});
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the file has no '" + from + "'");
  const auto file = testing::TempDir() + "head.yaml";
  std::ofstream(file) << text.replace(at, from.size(), to);
  try {
    read_head(file);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(CameraHead, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(message_of("rigs:", "rigs:"), "");
  EXPECT_THAT(
      message_of("left: bottom_left", "left: bottom"),
      HasSubstr(
          "head.yaml:14: rigs[0].left: 'bottom', expected one of the cameras: bottom_left, bottom_right"));
  EXPECT_THAT(message_of("left: bottom_left, right: bottom_right", "left: bottom_right, right: bottom_left"),
              HasSubstr("head.yaml:14: rigs[0].right: puts the right camera to the left"));
  EXPECT_THAT(message_of("field_deg: 90", "field_deg: 190"),
              HasSubstr("head.yaml:12: cameras[3].field_deg: '190'"));
  EXPECT_THAT(message_of("down_deg: 10", "down: 10"), HasSubstr("did you mean 'down_deg'?"));
  EXPECT_THAT(message_of("nearest: 0.8", "nearest: 0.1"),
              HasSubstr("head.yaml:14: rigs[0].nearest: 0.1 m: images"));
  EXPECT_THAT(message_of("size: [340, 480]", "size: [340.5, 480]"),
              HasSubstr("head.yaml:7: cameras[0].size: 340.5, expected whole numbers"));
  for (const char* name : {"/bottom", "../bottom", "..", "'two words'", "\"bottom\\nof it\""})
    EXPECT_THAT(message_of("name: bottom,", std::string("name: ") + name + ","),
                HasSubstr("head.yaml:14: rigs[0].name: '"))
        << name;
  EXPECT_THAT(message_of("name: top,", "name: bottom,"),
              HasSubstr("head.yaml:15: rigs[1].name: 'bottom' is taken"));
  EXPECT_THAT(message_of("name: top_left,", "name: bottom_left,"),
              HasSubstr("cameras[2].name: 'bottom_left' is taken"));
  EXPECT_THAT(message_of("name: HRP-2", "colour: red\nname: HRP-2"), HasSubstr("colour: is not a key here"));
}

}  // namespace
}  // namespace headway::vision
