// Files of OctoMap's that lie, end too early, or never end: one line that names the file and what is wrong.
#include <bit>
#include <cstdint>
#include <limits>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/error.h"
#include "nav/octomap_files.h"
#include "tests/temporary_folder.h"

namespace headway::nav {
namespace {

using testing::AllOf, testing::HasSubstr, testing::Not, testing::StartsWith;

constexpr std::size_t kFewBricks = 1000;

std::string header(const std::string& magic, const std::string& size, const std::string& res = "0.05") {
  return magic + "\n# a comment\n#\nid OcTree\nsize " + size + "\nres " + res + "\ndata\n";
}
std::string bt(const std::string& size, const std::string& data, const std::string& res = "0.05") {
  return header("# Octomap OcTree binary file", size, res) + data;
}
std::string ot(const std::string& size, const std::string& data) {
  return header("# Octomap OcTree file", size) + data;
}

template <class Read>
std::string complaint(const std::string& bytes, Read read) {
  std::istringstream in(bytes);
  try {
    read(in, "some/file", kFewBricks);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}
std::string complaint_bt(const std::string& bytes) {
  return complaint(bytes, [](auto&... a) { return read_bt(a...); });
}
std::string complaint_ot(const std::string& bytes) {
  return complaint(bytes, [](auto&... a) { return read_ot(a...); });
}

std::string repeated(const std::string& bytes, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += bytes;
  return all;
}

/// A node of a .ot file.
std::string node(float log_odds, unsigned children) {
  const auto bits = std::bit_cast<std::uint32_t>(log_odds);
  std::string bytes;
  for (unsigned i = 0; i < 4; ++i) bytes += static_cast<char>(bits >> (8 * i) & 255);
  return bytes + static_cast<char>(children);
}

const std::string kInnerChild("\x03\x00", 2), kEmptyChild("\x01\x00", 2);  // of child 0

TEST(HostileBt, ThatIsWellFormedIsAccepted) {
  EXPECT_EQ(complaint_bt(bt("0", "")), "accepted");
  EXPECT_EQ(complaint_bt(bt("17", repeated(kInnerChild, 15) + kEmptyChild)), "accepted");
}

TEST(HostileBt, WithAChainBelowTheVoxelsIsRefused) {
  EXPECT_THAT(complaint_bt(bt("99999", repeated(kInnerChild, 90000))),
              AllOf(StartsWith("some/file: "), HasSubstr("below the 16th level")));
}

TEST(HostileBt, WithLeavesThatStandForTooManyBricksIsRefused) {
  for (int depth = 0; depth <= 8; ++depth) {
    const std::string data = repeated(kInnerChild, depth) + kEmptyChild;
    EXPECT_THAT(complaint_bt(bt(std::to_string(depth + 2), data)),
                AllOf(StartsWith("some/file: "), HasSubstr("1000 bricks of 8 x 8 x 8 voxels")))
        << depth;
  }
}

TEST(HostileBt, IsToldWhereItsHeaderIsWrong) {
  const std::string one = repeated(kInnerChild, 15) + kEmptyChild;
  EXPECT_THAT(complaint_bt(""), HasSubstr("'# Octomap OcTree binary file' in the first line"));
  EXPECT_THAT(complaint_bt(ot("17", one)), HasSubstr("in the first line"));
  EXPECT_THAT(complaint_bt(bt("17", one).substr(0, 60)), HasSubstr("ends too early"));
  EXPECT_THAT(complaint_bt("# Octomap OcTree binary file\nid ColorOcTree\nsize 1\nres 1\ndata\n"),
              HasSubstr("id: 'ColorOcTree', expected OcTree"));
  EXPECT_THAT(complaint_bt(bt("-17", one)), HasSubstr("size: '-17'"));
  EXPECT_THAT(complaint_bt(bt("99999999999999999999999", one)), HasSubstr("size: "));
  for (const char* res : {"nan", "inf", "-0.05", "0", "1e-300", "1e300", "0.05m", ""}) {
    EXPECT_THAT(complaint_bt(bt("17", one, res)),
                HasSubstr("res: '" + std::string(res) + "', expected 0.0001"));
  }
  EXPECT_THAT(complaint_bt("# Octomap OcTree binary file\n" + repeated("# no end\n", 5000)),
              HasSubstr("the header does not end"));
  EXPECT_THAT(complaint_bt("# Octomap OcTree binary file\n# " + std::string(5000, 'x')), HasSubstr("longer"));
}

TEST(HostileBt, IsToldWhenItsNodesAreNotThoseItClaims) {
  const std::string one = repeated(kInnerChild, 15) + kEmptyChild;
  EXPECT_THAT(complaint_bt(bt("16", one)), HasSubstr("more than the 16 nodes"));
  EXPECT_THAT(complaint_bt(bt("18446744073709551615", one)), HasSubstr("holds 17 nodes"));
  EXPECT_THAT(complaint_bt(bt("17", one.substr(0, 31))), HasSubstr("ends too early"));
}

TEST(HostileOt, IsToldWhatIsWrong) {
  const std::string chain = repeated(node(1, 1), 16) + node(1, 0);
  EXPECT_EQ(complaint_ot(ot("17", chain)), "accepted");
  EXPECT_THAT(complaint_ot(ot("99999", repeated(node(1, 1), 90000))), HasSubstr("below the 16th level"));
  EXPECT_THAT(complaint_ot(ot("1", node(1, 0))), HasSubstr("1000 bricks"));
  EXPECT_THAT(complaint_ot(ot("17", chain.substr(0, 80))), HasSubstr("ends too early"));
  EXPECT_THAT(complaint_ot(ot("16", chain)), HasSubstr("more than the 16 nodes"));
  EXPECT_THAT(complaint_ot(bt("17", chain)), HasSubstr("in the first line"));
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_THAT(complaint_ot(ot("17", repeated(node(1, 1), 16) + node(value, 0))),
                HasSubstr("node 17 are no number"));
  }
}

TEST(HostileOt, WithLogOddsOutOfBoundsKeepsTheirSide) {
  for (const float value : {1e30F, -1e30F, 1e-30F, -1e-30F}) {
    std::istringstream in(ot("17", repeated(node(1, 1), 16) + node(value, 0)));
    const ColdMap map = read_ot(in, "some/file");
    const LogOdds read = map.find({-kBrickReach, -kBrickReach, -kBrickReach})->front();
    EXPECT_EQ(read, value > 1 ? 70 : value < -1 ? -40 : value > 0 ? 0 : -1);
  }
}

TEST(HostileOctree, WithTooManyBricksOrNoNumbersIsRefused) {
  octomap::OcTree tree(0.05);
  tree.setNodeValue(octomap::OcTreeKey(40000, 40000, 40000), 1.0F);
  EXPECT_EQ(from_octree(tree).size(), 1U);
  for (int i = 0; i < 64; ++i) {
    tree.setNodeValue(octomap::OcTreeKey(static_cast<octomap::key_type>(40000 + 8 * i), 40000, 40000), 1.0F);
  }
  EXPECT_THROW(from_octree(tree, 63), InputError);
  tree.setNodeValue(octomap::OcTreeKey(40000, 40000, 40000), std::numeric_limits<float>::quiet_NaN());
  EXPECT_THROW(from_octree(tree), InputError);
}

TEST(HostileFiles, ThatAreNoFilesAreNamed) {
  const TemporaryFolder folder;
  const auto message = [](const std::filesystem::path& path) {
    try {
      read_bt(path);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message(folder / "none.bt"), AllOf(HasSubstr("none.bt: no such file"), Not(HasSubstr("\n"))));
  EXPECT_THAT(message(folder.path()), HasSubstr("is a folder, expected a file"));
  EXPECT_THAT(message("/dev/zero"), HasSubstr("/dev/zero: cannot be read"));
}

}  // namespace
}  // namespace headway::nav
