// The command camera as a user calls it, and what it says of scripted cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/camera_look.h"
#include "tests/app/run_headway.h"
#include "tests/drivers/scripted_camera.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

using drivers::PixelFormat, drivers::testing::ScriptedCamera;
using test::run_headway, test::says;
using testing::AllOf, testing::HasSubstr;

class CameraLookTest : public testing::Test {
 protected:
  CameraLookTest() {
    clock_.set(at_seconds(100));
    config_.left = config("left");
    config_.right = config("right");
  }
  drivers::V4l2CameraConfig config(const std::string& path) const {
    drivers::V4l2CameraConfig config;
    config.path = path;
    config.width = 32;
    config.height = 24;
    config.format = PixelFormat::kGrey;
    config.exposure = std::chrono::milliseconds(8);
    return config;
  }
  ScriptedCamera& add(const std::string& path) {
    return calls_.add(path, ScriptedCamera(PixelFormat::kGrey));
  }

  hal::ManualClock clock_;
  drivers::testing::ScriptedCalls calls_{clock_};
  drivers::StereoPairConfig config_;
};

TEST_F(CameraLookTest, SaysWhatOneCameraShows) {
  const ScriptedCamera& camera = add("left");
  const CameraLook look = look_through(config_.left, seconds(3), clock_, calls_);
  EXPECT_TRUE(look.is_well());
  ASSERT_EQ(look.eyes.size(), 1u);
  EXPECT_NEAR(look.eyes[0].rate, 30, 0.5);
  EXPECT_EQ(look.eyes[0].image.pixels.at(5), camera.made % 200);
  EXPECT_THAT(text_of(look),
              AllOf(HasSubstr("camera left: streaming; 32 x 24 px of GREY, 30 frames/s, exposure 8.0 ms"),
                    HasSubstr(" 0 lost")));
  EXPECT_EQ(json_of(look)["camera"]["exposure_ms"], 8);
  EXPECT_EQ(calls_.open_descriptors(), 0u);
}

TEST_F(CameraLookTest, SaysHowFarApartTheEyesExpose) {
  add("left");
  add("right").start_up += std::chrono::microseconds(3200);
  const CameraLook look = look_through(config_, seconds(3), clock_, calls_);
  EXPECT_TRUE(look.is_well());
  EXPECT_NEAR(look.pair->rate, 30, 1);
  EXPECT_THAT(text_of(look), HasSubstr("+3.0 to +3.5 ms after the left's"));
  EXPECT_EQ(json_of(look)["pair"]["pairs"], json_of(look)["pair"]["right_after_left_histogram"][17]);
  EXPECT_EQ(look.eyes[0].image.pixels, look.eyes[1].image.pixels);
}

TEST_F(CameraLookTest, IsNotWellWhenEyesAreOutOfStepOrOneIsSilent) {
  add("left");
  add("right").start_up += std::chrono::milliseconds(15);
  const CameraLook apart = look_through(config_, seconds(3), clock_, calls_);
  EXPECT_FALSE(apart.is_well());
  EXPECT_THAT(text_of(apart),
              AllOf(HasSubstr("pair: eyes out of step; 0 pairs"), HasSubstr("more than 5 ms apart")));
  // An image of each, so that one can see what they look at.
  EXPECT_EQ(apart.eyes[0].image.pixels.size(), 32u * 24);
  EXPECT_EQ(apart.eyes[1].image.pixels.size(), 32u * 24);
  add("right").silent = true;
  const CameraLook silent = look_through(config_, seconds(3), clock_, calls_);
  EXPECT_FALSE(silent.is_well());
  EXPECT_THAT(text_of(silent), HasSubstr("right right: silent"));
}

TEST_F(CameraLookTest, IsNotWellWhenEyesMeetOnlyNowAndThen) {
  add("left");
  add("right").rate = 29;  // they drift past each other once a second
  const CameraLook look = look_through(config_, seconds(6), clock_, calls_);
  EXPECT_GT(look.pair->stats.pairs, 0u);
  EXPECT_FALSE(look.is_well());
}

TEST(Camera, SaysWhatIsWrongWithADevice) {
  const TemporaryFolder folder;
  const std::string none = (folder / "video9").string(), file = (folder / "file").string();
  write_text(file, "no camera");
  EXPECT_TRUE(says(run_headway({"camera", "show", none}), {none, "plugged in", "camera list"}));
  EXPECT_TRUE(says(run_headway({"camera", "show", file}), {file, "no V4L2 device"}));
  EXPECT_TRUE(says(run_headway({"camera", "show", none, none}), {none, "one device for both eyes"}));
  EXPECT_TRUE(says(run_headway({"camera", "show", none, "--rate", "30", "--exposure", "50"}), {"exposure"}));
  EXPECT_EQ(run_headway({"camera", "show"}).code, kBadInput);
  EXPECT_EQ(run_headway({"camera", "show", "a", "b", "c"}).code, kBadInput);
  EXPECT_EQ(run_headway({"camera", "show", none, "--format", "H264"}).code, kBadInput);
  EXPECT_EQ(run_headway({"camera"}).code, kBadInput);
}

TEST(Camera, LeavesNoFolderBehindWhenThereIsNoCamera) {
  const TemporaryFolder folder;
  EXPECT_EQ(
      run_headway({"camera", "show", (folder / "video9").string(), "--out", (folder / "out").string()}).code,
      kBadInput);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Camera, ListsWhatThisMachineHasOrSaysThatItHasNone) {
  const auto outcome = run_headway({"camera", "list"});
  EXPECT_EQ(outcome.code, kSuccess);
  EXPECT_THAT(outcome.said, testing::AnyOf(HasSubstr("offers "), HasSubstr("plugged in")));
}

}  // namespace
}  // namespace headway::app
