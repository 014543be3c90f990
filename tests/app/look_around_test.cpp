#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "app/robot_file.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "vision/rectify.h"
#include "vision/viewpoints.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;

const fs::path kConfig = source_dir() / "config/hrp2";

class LookAround : public testing::Test {
 protected:
  LookAround() {
    fs::create_directories(folder_ / "rigs");
    fs::copy_file(kConfig / "rigs/bottom.yaml", folder_ / "rigs/bottom.yaml");
  }
  /// The robot with that line in place of the field of its views.
  Robot robot(const std::string& line) {
    std::string text = read_text(kConfig / "robot.yaml");
    const auto at = text.find("  look_around_field_deg:");
    text.replace(at, text.find('\n', at) - at, line);
    write_text(folder_ / "robot.yaml", text);
    return read_robot(folder_ / "robot.yaml");
  }
  TemporaryFolder folder_;
};

TEST_F(LookAround, TakesTheFieldThatTheFileNames) {
  EXPECT_EQ(robot("  look_around_field_deg: [33, 33]").mission.viewpoints.size(), 9U);
  EXPECT_EQ(robot("  look_around_field_deg: [90, 75]").mission.viewpoints.size(), 1U);
}

TEST_F(LookAround, TakesTheRigsOwnFieldOtherwise) {
  const Robot read = robot("");
  const double degree = std::numbers::pi / 180;
  const auto field = vision::field_angles(vision::Rectifier(read.rig).rig(), read.mission.look_distance);
  const double across = std::ceil(90 * degree / field.horizontal),
               down = std::ceil(75 * degree / field.vertical);
  EXPECT_EQ(static_cast<double>(read.mission.viewpoints.size()), across * down);
  EXPECT_GT(across, 3) << "near by the images overlap less than 33 deg";
}

}  // namespace
}  // namespace headway::app
