// What is listed of cameras, from a folder that looks like /dev.
#include "drivers/v4l2_listing.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "tests/drivers/camera_bench.h"
#include "tests/temporary_folder.h"

namespace headway::drivers {
namespace {

namespace fs = std::filesystem;
using testing::ScriptedCamera;

class V4l2Listing : public ::testing::Test {
 protected:
  ScriptedCamera& add(const std::string& name, PixelFormat format = PixelFormat::kYuyv) {
    std::ofstream(devices_ / name);
    return calls_.add((devices_ / name).string(), ScriptedCamera(format));
  }
  ~V4l2Listing() override {
    EXPECT_EQ(calls_.open_descriptors(), 0u);
    EXPECT_TRUE(calls_.violations.empty());
  }

  TemporaryFolder devices_;
  hal::ManualClock clock_;
  testing::ScriptedCalls calls_{clock_};
};

TEST_F(V4l2Listing, NamesCamerasByNumberWithThePortTheyAreIn) {
  add("video10");
  add("video2");
  add("video3").capabilities = V4L2_CAP_META_CAPTURE;  // the second device file of a USB camera
  add("video4").unplug();
  add("videotape");
  fs::create_directories(devices_ / "v4l/by-path");
  fs::create_symlink("../../video2", devices_ / "v4l/by-path/pci-usb-1-video-index0");
  const std::vector<ListedCamera> cameras = list_cameras(calls_, devices_.path());
  ASSERT_EQ(cameras.size(), 2u);
  EXPECT_EQ(fs::path(cameras[0].path).filename(), "video2");
  EXPECT_EQ(fs::path(cameras[0].port_path).filename(), "pci-usb-1-video-index0");
  EXPECT_EQ(cameras[0].name, "Scripted camera");
  EXPECT_EQ(cameras[0].bus, "usb-script-1");
  EXPECT_EQ(fs::path(cameras[1].path).filename(), "video10");
  EXPECT_EQ(cameras[1].port_path, "");
}

TEST_F(V4l2Listing, IsEmptyWhereThereAreNoDevices) {
  EXPECT_TRUE(list_cameras(calls_, devices_ / "no/such").empty());
  EXPECT_TRUE(offered_formats(calls_, "/dev/none").empty());
  EXPECT_EQ(one_line({}), "nothing");
}

TEST_F(V4l2Listing, TellsFormatsSizesAndRates) {
  ScriptedCamera& camera = add("video0");
  camera.offers = {{V4L2_PIX_FMT_YUYV, 640, 480, 30},
                   {V4L2_PIX_FMT_YUYV, 1280, 720, 10},
                   {V4L2_PIX_FMT_H264, 1920, 1080, 30}};
  EXPECT_EQ(
      one_line(offered_formats(calls_, (devices_ / "video0").c_str())),
      "YUYV 640 x 480 (30, 15 /s), YUYV 1280 x 720 (10, 5 /s); in formats that Headway does not read: H264");
}

}  // namespace
}  // namespace headway::drivers
