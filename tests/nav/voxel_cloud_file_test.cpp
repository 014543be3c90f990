#include "nav/voxel_cloud_file.h"

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <sstream>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "any_cold_map.h"
#include "hal/error.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

using testing::AllOf, testing::HasSubstr, testing::StartsWith;

ColdMap read(const std::string& bytes, std::optional<double> resolution = {}) {
  std::istringstream in(bytes);
  return read_voxel_cloud(in, "some.ply", resolution, 1000);
}
std::string complaint(const std::string& bytes, std::optional<double> resolution = 0.1) {
  try {
    read(bytes, resolution);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

RC_GTEST_PROP(VoxelCloudFile, GivesBackTheOccupiedVoxels, ()) {
  const ColdMap map = any_cold_map();
  ColdMap occupied(map.resolution());
  map.for_any([&](const BrickKey& key, BrickValues values) {
    for (LogOdds& v : values) v = v < log_odds::kOccupied ? log_odds::kUnseen : v;
    occupied.put(key, values);
  });
  std::ostringstream out;
  write_voxel_cloud(map, out);
  RC_ASSERT(read(out.str()) == occupied);
  const TemporaryFolder folder;
  write_voxel_cloud(map, folder / "map.ply");
  RC_ASSERT(read_voxel_cloud(folder / "map.ply") == occupied);
}

LogOdds value_at(const ColdMap& map, int x, int y, int z) {
  const BrickValues* brick = map.find({x >> 3, y >> 3, z >> 3});
  return brick == nullptr ? log_odds::kUnseen
                          : (*brick)[static_cast<std::size_t>(in_brick(x & 7, y & 7, z & 7))];
}

TEST(VoxelCloudFile, TakesEachPointOfAnyCloudAsAHit) {
  const ColdMap map = read(
      "ply\r\nformat ascii 1.0\r\ncomment resolution of the lens: high\r\nelement vertex 5\r\nproperty "
      "double z\r\n"
      "property uchar red\r\nproperty float32 x\r\nproperty double y\r\nelement face 1\r\n"
      "property list uchar int vertex_indices\r\nend_header\r\n"
      "0.05 255 0.15 -0.01\r\n0.09 0 0.11 -0.09\r\nnan 0 0 0\r\n1e0 0 0 0\r\n1.05 0 0.01 0.01\r\n3 0 1 2\r\n",
      0.1);
  EXPECT_EQ(map.size(), 2U);
  EXPECT_EQ(value_at(map, 1, -1, 0), 34);
  EXPECT_EQ(value_at(map, 0, 0, 10), 34);
  EXPECT_EQ(value_at(map, 0, 0, 0), log_odds::kUnseen);
}

/// The same two points, (-1, 2, 30) and (4, 5, -6), with a property of each type before them.
std::string binary(bool big) {
  std::string bytes = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement vertex 2\nproperty int8 a\nproperty ushort b\nproperty int x\n"
                      "property double y\nproperty short z\nproperty uint c\nend_header\n";
  const auto add = [&](auto value) {
    std::array<char, sizeof value> raw{};
    std::memcpy(raw.data(), &value, sizeof value);
    if (big != (std::endian::native == std::endian::big)) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
  };
  for (const auto& [x, y, z] : {std::array{-1, 2, 30}, std::array{4, 5, -6}}) {
    add(std::int8_t{-7});
    add(std::uint16_t{65535});
    add(std::int32_t{x});
    add(static_cast<double>(y));
    add(static_cast<std::int16_t>(z));
    add(std::uint32_t{9});
  }
  return bytes;
}

TEST(VoxelCloudFile, ReadsEveryTypeInBothOrders) {
  for (const bool big : {false, true}) {
    const ColdMap map = read(binary(big), 1.0);
    EXPECT_EQ(value_at(map, -1, 2, 30), log_odds::kHit);
    EXPECT_EQ(value_at(map, 4, 5, -6), log_odds::kHit);
    EXPECT_EQ(map.size(), 2U);
  }
}

const std::string kHead = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n";
const std::string kGood = kHead + "property float z\nend_header\n0 0 0\n1 1 1";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(VoxelCloudFile, SaysWhatIsWrong) {
  EXPECT_EQ(complaint(kGood), "accepted");
  EXPECT_THAT(complaint(kGood, {}), StartsWith("some.ply: says nothing of voxels"));
  EXPECT_THAT(complaint(kGood, std::numeric_limits<double>::quiet_NaN()), HasSubstr("resolution: nan m"));
  EXPECT_THAT(complaint(replaced(kGood, "ascii 1.0", "ascii 1.0\ncomment resolution -1"), {}),
              HasSubstr("resolution: -1 m"));
  EXPECT_THAT(complaint(""), HasSubstr("'ply' in the first line"));
  EXPECT_THAT(complaint(replaced(kGood, "ascii", "zip")), HasSubstr("format: 'zip'"));
  EXPECT_THAT(complaint(replaced(kGood, "format ascii 1.0\n", "")), HasSubstr("names no format"));
  EXPECT_THAT(complaint(replaced(kGood, "vertex 2", "face 2")), HasSubstr("'element face 2': expected"));
  EXPECT_THAT(complaint(replaced(kGood, "vertex 2", "vertex -2")), HasSubstr("number of points"));
  EXPECT_THAT(complaint(replaced(kGood, "float z", "float w")), HasSubstr("have no 'z'"));
  EXPECT_THAT(complaint(replaced(kGood, "float z", "list uchar int z")), HasSubstr("type char to double"));
  EXPECT_THAT(complaint(replaced(kGood, "1 1 1", "1 one 1")), HasSubstr("'one', expected a number"));
  EXPECT_THAT(complaint(replaced(kGood, "1 1 1", "1 1e9 1")), HasSubstr("lies beyond the reach"));
  EXPECT_THAT(complaint(replaced(kGood, "1 1 1", "1 1")), HasSubstr("ends too early"));
  EXPECT_THAT(complaint(replaced(kGood, "vertex 2", "vertex 18446744073709551615")),
              HasSubstr("ends too early"));
  EXPECT_THAT(complaint(replaced(kGood, "1 1 1", std::string(2000, '1'))), HasSubstr("longer than 1000"));
  EXPECT_THAT(complaint("ply\n" + std::string(5000, 'x')), HasSubstr("longer than 1000"));
  std::string endless = "ply\n";
  for (int i = 0; i < 2000; ++i) endless += "comment\n";
  EXPECT_THAT(complaint(endless), HasSubstr("the header does not end"));
  std::string many = replaced(kGood, "vertex 2", "vertex 1500");
  for (int i = 0; i < 1500; ++i) many += "\n" + std::to_string(i) + " 0 0";
  EXPECT_THAT(complaint(many), HasSubstr("more than 1000 bricks"));
}

}  // namespace
}  // namespace headway::nav
