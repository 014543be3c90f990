#include "nav/whole_file.h"

#include <array>
#include <cstdio>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

void write_text_whole(const fs::path& file, const std::string& text) {
  write_whole(file, [&](std::ostream& out) { out << text; });
}

RC_GTEST_PROP(WholeFile, ReplacesWhatLinksLeadToAndKeepsTheLinks, ()) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "here");
  fs::create_directories(folder / "there");
  const fs::path target = folder / "there/target";
  if (*rc::gen::arbitrary<bool>()) write_text(target, "old");
  const int links = *rc::gen::inRange(1, 6);
  fs::path last = target;
  for (int i = 0; i < links; ++i) {
    const fs::path link = folder / fmt::format("here/link{}", i);
    fs::create_symlink(*rc::gen::arbitrary<bool>() ? last : last.lexically_relative(folder / "here"), link);
    last = link;
  }
  write_text_whole(last, "new");
  RC_ASSERT(!fs::is_symlink(target) && read_text(target) == "new");
  for (int i = 0; i < links; ++i) RC_ASSERT(fs::is_symlink(folder / fmt::format("here/link{}", i)));
  const auto all = std::distance(fs::recursive_directory_iterator(folder.path()), {});
  RC_ASSERT(all == 3 + links);
}

TEST(WholeFile, RefusesLinksThatLeadRoundInACircle) {
  const TemporaryFolder folder;
  fs::create_symlink("b", folder / "a");
  fs::create_symlink("a", folder / "b");
  EXPECT_THROW(write_text_whole(folder / "a", "new"), InputError);
  EXPECT_TRUE(fs::is_symlink(folder / "a") && fs::is_symlink(folder / "b"));
}

TEST(WholeFile, WritesThroughAPipe) {
  const TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_text_whole(pipe, "new");
  std::array<char, 16> heard{};
  EXPECT_EQ(::read(reader, heard.data(), heard.size()), 3);
  EXPECT_STREQ(heard.data(), "new");
  ::close(reader);
  EXPECT_TRUE(is_stream(pipe) && fs::is_fifo(pipe));
}

/// A device that is always full, of the test's own, for a fault in what is tested could replace it as root.
/// Who may make none may not replace the system's either, and gets a link to that.
void make_full_device(const fs::path& at) {
  if (::mknod(at.c_str(), S_IFCHR | 0600, ::makedev(1, 7)) == 0) {
    if (const int opened = ::open(at.c_str(), O_WRONLY); opened >= 0) {
      ::close(opened);
      return;
    }
    fs::remove(at);  // its file system opens no devices
  }
  fs::create_symlink("/dev/full", at);
}

TEST(WholeFile, LeavesADeviceADeviceAndTellsWhatItSays) {
  const TemporaryFolder folder;
  const fs::path full = folder / "full";
  make_full_device(full);
  try {
    write_text_whole(full, "new");
    FAIL() << "was written";
  } catch (const Error& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("cannot be written completely (No space left on device)"));
  }
  EXPECT_TRUE(fs::is_character_file(full));
}

TEST(WholeFile, GoesOnWhereItsOwnOutputIs) {
  const TemporaryFolder folder;
  const fs::path link = folder / "stdout";  // as /dev/stdout is one
  fs::create_symlink("/proc/self/fd/1", link);
  testing::internal::CaptureStdout();
  std::printf("before ");
  EXPECT_TRUE(is_stream(link));
  write_text_whole(link, "new");
  std::printf(" after");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "before new after");
  EXPECT_TRUE(fs::is_symlink(link));
}

}  // namespace
}  // namespace headway::nav
