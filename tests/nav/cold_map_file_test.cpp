#include "nav/cold_map_file.h"

#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"
#include "nav/checksum.h"
#include "nav/voxel_map.h"
#include "tests/fuzz/old_map_files.h"

namespace headway::nav {
namespace {

using fuzz::with_sum, testing::AllOf, testing::HasSubstr, testing::StartsWith;

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

/// Surfaces in voxels near each other or anywhere.
SurfacePoints any_surfaces(double resolution) {
  SurfacePoints surfaces(resolution);
  const int voxels = *rc::gen::inRange(0, 40);
  const auto share = [] { return static_cast<float>(*rc::gen::inRange(-1000, 1001)) / 1000; };
  for (int i = 0; i < voxels; ++i) {
    SurfaceVoxel v;
    v.key = static_cast<std::uint64_t>(*rc::gen::oneOf(
        rc::gen::inRange<std::int64_t>(1, 100), rc::gen::inRange<std::int64_t>(1, std::int64_t{1} << 62)));
    v.weight = static_cast<float>(*rc::gen::inRange(1, 1'000'000));
    v.count = static_cast<float>(*rc::gen::inRange(1, 1000));
    v.doubt = std::abs(share());
    const float reach = 0.49F * static_cast<float>(resolution) * v.weight;
    for (float& f : v.first) f = reach * share();
    for (float& f : v.second) f = reach * static_cast<float>(resolution) * share();
    for (const std::size_t k : {0U, 3U, 5U}) v.second[k] = std::abs(v.second[k]);
    for (float& f : v.rays) f = v.weight * share();
    surfaces.restore(v);
  }
  return surfaces;
}

std::string any_file() {
  const ColdMap map = any_cold_map();
  std::ostringstream out;
  write_map_file(map, any_surfaces(map.resolution()), out);
  return out.str();
}

RC_GTEST_PROP(ColdMapFile, GivesBackSurfacesThatWereWritten, ()) {
  const ColdMap map = any_cold_map();
  const SurfacePoints surfaces = any_surfaces(map.resolution());
  std::stringstream file;
  write_map_file(map, surfaces, file);
  const SavedMap read = read_saved_map(file, "some.hmap");
  RC_ASSERT(read.map == map);
  RC_ASSERT(read.surfaces.saved() == surfaces.saved());
}

RC_GTEST_PROP(ColdMapFile, OfVersion1IsReadWithoutSurfaces, ()) {
  const ColdMap map = any_cold_map();
  std::istringstream in(fuzz::of_version_1(map));
  const SavedMap read = read_saved_map(in, "old.hmap");
  RC_ASSERT(read.map == map);
  RC_ASSERT(read.surfaces.voxels() == 0U);
}

RC_GTEST_PROP(ColdMapFile, OfVersion2IsReadWithoutRays, ()) {
  const ColdMap map = any_cold_map();
  const SurfacePoints surfaces = any_surfaces(map.resolution());
  std::istringstream in(fuzz::of_version_2(map, surfaces));
  const SavedMap read = read_saved_map(in, "old.hmap");
  std::vector<SurfaceVoxel> expected = surfaces.saved();
  for (SurfaceVoxel& voxel : expected) voxel.rays = {};
  RC_ASSERT(read.map == map);
  RC_ASSERT(read.surfaces.saved() == expected);
}

RC_GTEST_PROP(ColdMapFile, NoticesEveryBitThatTurns, ()) {
  std::string bytes = any_file();
  const auto place = static_cast<std::size_t>(*rc::gen::inRange<int>(0, static_cast<int>(bytes.size())));
  bytes[place] = static_cast<char>(bytes[place] ^ 1 << *rc::gen::inRange(0, 8));
  RC_ASSERT(complaint(bytes) != "accepted");
}

RC_GTEST_PROP(ColdMapFile, NoticesWhereItIsCutOff, ()) {
  const std::string bytes = any_file();
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
  EXPECT_THAT(bytes, StartsWith("headway map 3\n"));
  bytes[12] = '4';
  EXPECT_THAT(complaint(bytes),
              AllOf(StartsWith("some.hmap: is a map of version 4, and this program reads versions 1 to 3"),
                    HasSubstr("a newer Headway"), HasSubstr("headway map convert")));
  bytes[12] = '0';
  EXPECT_THAT(complaint(bytes), HasSubstr("an older Headway"));
}

TEST(ColdMapFile, RefusesSurfacesThatCannotBe) {
  SurfacePoints surfaces(0.05);
  const SurfaceVoxel good{
      .key = 7, .weight = 100, .count = 2, .doubt = 0, .first = {1, 0, -1}, .second = {}, .rays = {}};
  ASSERT_TRUE(surfaces.restore(good));
  std::ostringstream out;
  write_map_file(one_brick(), surfaces, out);
  const std::string body = out.str().substr(0, out.str().size() - 4);
  const std::size_t voxel = body.size() - 68;
  const auto changed = [&](std::size_t at, const std::string& to) {
    return complaint(with_sum(std::string(body).replace(at, to.size(), to)));
  };
  EXPECT_EQ(changed(0, "h"), "accepted");
  const std::string nan("\0\0\xc0\x7f", 4), huge("\0\0\0\x7f", 4), minus("\0\0\x80\xbf", 4);
  for (const std::size_t at : {8U, 12U, 16U, 20U, 32U, 52U, 56U, 64U})
    EXPECT_THAT(changed(voxel + at, nan), HasSubstr("a surface that cannot be")) << at;
  for (const std::size_t at : {20U, 32U, 56U})
    EXPECT_THAT(changed(voxel + at, huge), HasSubstr("a surface that cannot be")) << at;
  for (const std::size_t at : {8U, 12U, 16U, 32U})
    EXPECT_THAT(changed(voxel + at, minus), HasSubstr("a surface that cannot be")) << at;
  EXPECT_THAT(changed(voxel, std::string(8, '\xff')), HasSubstr("a surface that cannot be"));
  EXPECT_THAT(changed(voxel, std::string(8, '\0')), HasSubstr("out of order"));
  EXPECT_THAT(changed(voxel - 8, std::string(8, '\xff')), HasSubstr("ends too early"));
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
  EXPECT_THAT(complaint("# Octomap OcTree file\n"), HasSubstr("expected 'headway map 3' in the first line"));
  EXPECT_THAT(complaint("headway map one\n"), HasSubstr("expected 'headway map 3'"));
  EXPECT_THAT(complaint(changed(kResolution, nan)), HasSubstr("a resolution of nan m"));
  EXPECT_THAT(complaint(changed(kCount, many)), HasSubstr("claims 18446744073709551615 bricks"));
  const std::string surfaces(8, '\0'), bricks = body.substr(0, body.size() - surfaces.size());
  const std::string twice =
      changed(kCount, "\x02").substr(0, bricks.size()) + bricks.substr(kOrder) + surfaces;
  EXPECT_THAT(complaint(with_sum(twice)), HasSubstr("out of order"));
  EXPECT_THAT(complaint(changed(kOrder, many)), HasSubstr("out of order"));
  EXPECT_THAT(complaint(bytes + "x"), HasSubstr("something follows its end"));
}

}  // namespace
}  // namespace headway::nav
