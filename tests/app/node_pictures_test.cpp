#include "app/node_pictures.h"

#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/robot_file.h"
#include "app/simulated_robot.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

/// The next whole picture that comes through the pipe; empty when none comes.
std::vector<std::uint8_t> next_picture(int fd, std::size_t size, hal::Clock& clock) {
  std::vector<std::uint8_t> picture(size);
  const Time give_up = clock.now() + seconds(60);
  for (std::size_t done = 0; done < size;) {
    if (clock.now() > give_up) return {};
    const ssize_t count = ::read(fd, picture.data() + done, size - done);
    if (count > 0)
      done += static_cast<std::size_t>(count);
    else
      std::this_thread::yield();
  }
  return picture;
}

TEST(NodePictures, ShowTheWorldAsItWasWhenTheEyesWereExposed) {
  const Robot robot = read_robot(source_dir() / "config/hrp2/robot.yaml");
  const sim::World world = sim::read_world(source_dir() / "config/worlds/moving_box.yaml");
  const sim::StereoCameraModel model = simulated_pair(robot.rig, 7);
  const auto size = static_cast<std::size_t>(model.left.width) * static_cast<std::size_t>(model.left.height);
  // As seen at once, from beside the robot's start, while the box comes.
  sim::Scene scene(world);
  hal::ManualClock seen_at;
  sim::SimStereoCamera camera(scene, seen_at, model);
  Exposure exposure;
  exposure.map_from_left.linear() = (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  exposure.map_from_left.translation() << world.start.x, world.start.y, 1.3;

  const TemporaryFolder folder;
  hal::ScaledClock clock(1);
  NodePictures pictures(world, model, folder.path() / "left", folder.path() / "right", clock);
  const int left = ::open((folder.path() / "left").c_str(), O_RDONLY | O_NONBLOCK);
  const int right = ::open((folder.path() / "right").c_str(), O_RDONLY | O_NONBLOCK);
  hal::StereoFrame expected;
  for (int i = 0; i < 3; ++i) {
    scene.advance(Time{} + seconds(4.0 * i), {world.start.x + 0.3 * i, world.start.y, 0});
    exposure.at = clock.now();
    exposure.world = scene.state();
    camera.expose(exposure.at, exposure.map_from_left);
    seen_at.set(exposure.at + model.transfer);
    const std::vector<std::uint8_t> before = expected.left.pixels;
    ASSERT_TRUE(camera.take_newest(expected));
    EXPECT_NE(expected.left.pixels, before);
    pictures.expose(exposure);
    EXPECT_EQ(next_picture(left, size, clock), expected.left.pixels) << i;
    EXPECT_EQ(next_picture(right, size, clock), expected.right.pixels) << i;
  }
  EXPECT_FALSE(pictures.failed());
  ::close(left);
  ::close(right);
}

}  // namespace
}  // namespace headway::app
