#include "nav/cold_map_file.h"

#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"
#include "nav/checksum.h"
#include "nav/voxel_map.h"

namespace headway::nav {
namespace {

using testing::AllOf, testing::HasSubstr, testing::StartsWith;

std::string written(const SeenBricks& map) {
  std::ostringstream out;
  write_map_file(map, out);
  return out.str();
}
ColdMap read(const std::string& bytes) {
  std::istringstream in(bytes);
  return read_map_file(in, "some.hmap", 1000);
}
std::string complaint(const std::string& bytes) {
  try {
    read(bytes);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

std::string with_sum(std::string bytes) {
  Checksum sum;
  sum.add(bytes);
  for (unsigned i = 0; i < 32; i += 8) bytes += static_cast<char>(sum.value() >> i & 255);
  return bytes;
}

ColdMap one_brick() {
  ColdMap map(0.05);
  BrickValues values;
  values.fill(17);
  map.put({1, -2, 3}, values);
  return map;
}

// The check value that every catalogue of CRCs lists for this one.
TEST(Checksum, IsTheOneOfEthernet) {
  Checksum sum;
  sum.add("12345");
  sum.add("6789");
  EXPECT_EQ(sum.value(), 0xCBF43926U);
}

RC_GTEST_PROP(ColdMapFile, GivesBackWhatWasWritten, ()) {
  const ColdMap map = any_cold_map();
  RC_ASSERT(read(written(map)) == map);
}

RC_GTEST_PROP(ColdMapFile, NoticesEveryBitThatTurns, ()) {
  std::string bytes = written(any_cold_map());
  const auto place = static_cast<std::size_t>(*rc::gen::inRange<int>(0, static_cast<int>(bytes.size())));
  bytes[place] = static_cast<char>(bytes[place] ^ 1 << *rc::gen::inRange(0, 8));
  RC_ASSERT(complaint(bytes) != "accepted");
}

RC_GTEST_PROP(ColdMapFile, NoticesWhereItIsCutOff, ()) {
  const std::string bytes = written(any_cold_map());
  const auto size = static_cast<std::size_t>(*rc::gen::inRange<int>(0, static_cast<int>(bytes.size())));
  RC_ASSERT(complaint(bytes.substr(0, size)) == "some.hmap: ends too early; copy it again");
}

TEST(ColdMapFile, IsTheSameForTheSameMapInAWindow) {
  VoxelMap window{VoxelMapConfig{}};
  window.set({3, 40, 17}, 17, at_seconds(1));
  window.set({0, 0, 0}, -8, at_seconds(1));
  const ColdMap map = read(written(window));
  EXPECT_EQ(written(map), written(window));
  EXPECT_EQ(map.size(), 2U);
}

TEST(ColdMapFile, OfAnotherVersionIsRefusedWithWhatToDo) {
  std::string bytes = written(one_brick());
  EXPECT_THAT(bytes, StartsWith("headway map 1\n"));
  bytes[12] = '2';
  EXPECT_THAT(complaint(bytes),
              AllOf(StartsWith("some.hmap: is a map of version 2, and this program reads version 1"),
                    HasSubstr("a newer Headway"), HasSubstr("headway map convert")));
  bytes[12] = '0';
  EXPECT_THAT(complaint(bytes), HasSubstr("an older Headway"));
}

TEST(ColdMapFile, SaysWhatIsWrong) {
  const std::string bytes = written(one_brick()), body = bytes.substr(0, bytes.size() - 4);
  EXPECT_EQ(with_sum(body), bytes);
  const auto changed = [&](std::size_t at, const std::string& to) {
    return with_sum(std::string(body).replace(at, to.size(), to));
  };
  constexpr std::size_t kResolution = 14, kCount = 22, kOrder = 30;
  const std::string nan("\0\0\0\0\0\0\xf8\x7f", 8), many(8, '\xff');
  EXPECT_THAT(complaint(""), HasSubstr("ends too early"));
  EXPECT_THAT(complaint("# Octomap OcTree file\n"), HasSubstr("expected 'headway map 1' in the first line"));
  EXPECT_THAT(complaint("headway map one\n"), HasSubstr("expected 'headway map 1'"));
  EXPECT_THAT(complaint(changed(kResolution, nan)), HasSubstr("a resolution of nan m"));
  EXPECT_THAT(complaint(changed(kCount, many)), HasSubstr("claims 18446744073709551615 bricks"));
  const std::string twice = changed(kCount, "\x02").substr(0, body.size()) + body.substr(kOrder);
  EXPECT_THAT(complaint(with_sum(twice)), HasSubstr("out of order"));
  EXPECT_THAT(complaint(changed(kOrder, many)), HasSubstr("out of order"));
  EXPECT_THAT(complaint(bytes + "x"), HasSubstr("something follows its end"));
}

}  // namespace
}  // namespace headway::nav
