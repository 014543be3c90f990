#include "app/frame_pipe.h"

#include <fstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::app {
namespace {

hal::GrayImage grey(std::uint8_t value) {
  return {340, 480, std::vector<std::uint8_t>(std::size_t{340} * 480, value)};
}

/// All that is there to be read.
std::vector<std::uint8_t> drain(int fd, FramePipe& pipe) {
  std::vector<std::uint8_t> all;
  std::vector<std::uint8_t> some(1 << 16);
  for (;;) {
    const ssize_t count = ::read(fd, some.data(), some.size());
    if (count <= 0) return all;
    all.insert(all.end(), some.begin(), some.begin() + count);
    pipe.pump();
  }
}

TEST(FramePipe, HandsWholeFramesOverAndLeavesOutWhatComesMeanwhile) {
  const TemporaryFolder folder;
  FramePipe pipe(folder.path() / "left");
  pipe.offer(grey(1));
  EXPECT_EQ(pipe.left_out(), 1U) << "nobody reads";
  const int reader = ::open((folder.path() / "left").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  pipe.offer(grey(2));  // more than a pipe holds
  pipe.offer(grey(3));
  EXPECT_EQ(pipe.left_out(), 2U);
  EXPECT_EQ(drain(reader, pipe), grey(2).pixels);
  pipe.offer(grey(4));
  EXPECT_EQ(drain(reader, pipe), grey(4).pixels);
  EXPECT_EQ(pipe.written(), 2U);
  ::close(reader);
}

TEST(FramePipe, BeginsWithAWholeFrameForAnotherReader) {
  const TemporaryFolder folder;
  FramePipe pipe(folder.path() / "left");
  int reader = ::open((folder.path() / "left").c_str(), O_RDONLY | O_NONBLOCK);
  pipe.offer(grey(1));
  ::close(reader);  // in the middle of a frame
  pipe.pump();
  reader = ::open((folder.path() / "left").c_str(), O_RDONLY | O_NONBLOCK);
  pipe.offer(grey(2));
  EXPECT_EQ(drain(reader, pipe), grey(2).pixels);
  ::close(reader);
}

TEST(FramePipe, RemovesThePipeThatItMadeAndNoOther) {
  const TemporaryFolder folder;
  const auto ours = folder / "ours", others = folder / "others";
  ASSERT_EQ(::mkfifo(others.c_str(), 0600), 0);
  {
    const FramePipe left(ours), right(others);
    EXPECT_TRUE(std::filesystem::is_fifo(ours));
  }
  EXPECT_FALSE(std::filesystem::exists(ours));
  EXPECT_TRUE(std::filesystem::is_fifo(others));
}

TEST(FramePipe, RefusesWhatIsNoPipe) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "x";
  EXPECT_THROW(FramePipe(folder.path() / "file"), InputError);
  EXPECT_THROW(FramePipe(folder.path() / "nowhere" / "left"), InputError);
}

}  // namespace
}  // namespace headway::app
