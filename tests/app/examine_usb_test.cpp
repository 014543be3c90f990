// The doctor at a USB that is made of files, as sysfs lays it out.
#include "app/examine_usb.h"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MadeUpUsb {
 public:
  fs::path root() const { return folder_.path(); }

  /// A bus with its root hub.
  void bus(int number, int speed) const { describe(fs::path("usb" + std::to_string(number)), number, speed); }
  /// A camera at `port` of a bus, as /dev/videoN; the kernel names it by its port as well.
  void camera(int video, const std::string& port, int bus, int speed) const {
    const fs::path device = fs::path("usb" + std::to_string(bus)) / port;
    describe(device, bus, speed);
    line(device / "product", "HD Camera");
    line(device / "bcdDevice", "0102");
    const fs::path interface = devices() / device / (port + ":1.0");
    const std::string name = "video" + std::to_string(video);
    fs::create_directories(interface / "video4linux" / name);
    link(root() / "sys/class/video4linux" / name / "device", interface);
    write_text(root() / "dev" / name, "");
    link(root() / "dev/v4l/by-path" / port, fs::path("../..") / name);
  }
  void adapter(const std::string& interface) const {
    camera(9, "1-9", 1, 12);
    link(root() / "sys/class/net" / interface / "device", devices() / "usb1/1-9/1-9:1.0");
  }

 private:
  fs::path devices() const { return root() / "sys/devices/pci0000:00"; }
  void line(const fs::path& file, const std::string& text) const {
    write_text(devices() / file, text + "\n");
  }
  void describe(const fs::path& device, int bus, int speed) const {
    line(device / "busnum", std::to_string(bus));
    line(device / "speed", std::to_string(speed));
  }
  static void link(const fs::path& from, const fs::path& to) {
    fs::create_directories(from.parent_path());
    fs::create_symlink(to, from);
  }
  TemporaryFolder folder_;
};

drivers::StereoPairConfig pair(const std::string& left, const std::string& right, double rate = 30) {
  drivers::StereoPairConfig pair;
  for (auto* eye : {&pair.left, &pair.right}) {
    eye->width = 1280;
    eye->height = 720;
    eye->format = drivers::PixelFormat::kYuyv;
    eye->rate = rate;
  }
  pair.left.path = left;
  pair.right.path = right;
  return pair;
}

Diagnosis examined(const MadeUpUsb& usb, const drivers::StereoPairConfig& cameras) {
  Diagnosis diagnosis;
  examine_usb_cameras(usb.root(), cameras, diagnosis);
  return diagnosis;
}

TEST(ExamineUsb, WarnsOfTwoCamerasThatOneBusDoesNotCarry) {
  const MadeUpUsb usb;
  usb.bus(1, 480);
  usb.camera(0, "1-1", 1, 480);
  usb.camera(1, "1-2", 1, 480);
  // 1280 x 720 pixels of 2 bytes, 15 times a second: 27.6 MB/s.
  const Diagnosis both = examined(usb, pair("/dev/video0", "/dev/v4l/by-path/1-2", 15));
  EXPECT_EQ(both.worst(), Verdict::kWarn);
  EXPECT_THAT(
      both.text(),
      HasSubstr("warn  usb      bus usb1: left 27.6 MB/s + right 27.6 MB/s of the 48.0 MB/s that 480"));
  EXPECT_THAT(both.text(), HasSubstr("another USB controller"));
  EXPECT_EQ(examined(usb, pair("/dev/video0", "/dev/video1", 12)).worst(), Verdict::kOk);
}

TEST(ExamineUsb, FindsTwoBusesWell) {
  const MadeUpUsb usb;
  usb.bus(1, 480);
  usb.bus(2, 480);
  usb.camera(0, "1-1", 1, 480);
  usb.camera(1, "2-1", 2, 480);
  const Diagnosis apart = examined(usb, pair("/dev/video0", "/dev/video1", 15));
  EXPECT_EQ(apart.worst(), Verdict::kOk) << apart.text();
  EXPECT_THAT(apart.text(), HasSubstr("left camera: HD Camera, release 1.02"));
}

TEST(ExamineUsb, WarnsOfAPortThatIsTooSlow) {
  const MadeUpUsb usb;
  usb.bus(1, 480);
  usb.camera(0, "1-1", 1, 12);
  usb.camera(1, "1-2", 1, 480);
  const Diagnosis slow = examined(usb, pair("/dev/video0", "/dev/video1", 5));
  EXPECT_EQ(slow.worst(), Verdict::kWarn);
  EXPECT_THAT(slow.text(),
              HasSubstr("left camera's port: 9.2 MB/s are asked for, and 12 Mbit/s carry 1.4 MB/s"));
}

TEST(ExamineUsb, HasLittleToSayOfCamerasElsewhereAndNothingOfThoseThatAreAbsent) {
  const MadeUpUsb usb;
  const Diagnosis none = examined(usb, pair("/dev/null", "/dev/no such camera"));
  EXPECT_EQ(none.worst(), Verdict::kOk);
  EXPECT_THAT(none.text(), HasSubstr("left camera: not on the USB"));
  EXPECT_THAT(none.text(), testing::Not(HasSubstr("right camera")));
}

TEST(ExamineUsb, NamesTheAdapterBehindAnInterface) {
  const MadeUpUsb usb;
  usb.bus(1, 480);
  usb.adapter("can0");
  Diagnosis diagnosis("can");
  examine_usb_adapter(usb.root(), "can0", diagnosis);
  examine_usb_adapter(usb.root(), "vcan0", diagnosis);
  EXPECT_EQ(diagnosis.text(), "ok    can      adapter: HD Camera, release 1.02\n");
}

}  // namespace
}  // namespace headway::app
