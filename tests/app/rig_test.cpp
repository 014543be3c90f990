// The command rig as a user calls it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/run_headway.h"
#include "tests/source_dir/source_dir.h"
#include "tests/temporary_folder.h"
#include "tests/vision/same_rig.h"
#include "vision/rig_files.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;
using test::run_headway, test::says;
using testing::HasSubstr;

const fs::path kOurs = source_dir() / "config/hrp2/rigs/bottom.yaml";

class RigConvert : public testing::Test {
 protected:
  test::Outcome convert(const fs::path& from, const fs::path& to, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"rig", "convert", from.string(), to.string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_headway(arguments);
  }
  fs::path ros() const { return (folder_ / "left.yaml").string() + "," + (folder_ / "right.yaml").string(); }

  TemporaryFolder folder_;
};

TEST_F(RigConvert, GoesToCameraInfoAndBack) {
  ASSERT_EQ(convert(kOurs, ros()).code, kSuccess);
  const auto back = convert(ros(), folder_ / "back.yaml", {"--near", "0.9", "--far", "5", "--sigma", "0.2"});
  ASSERT_EQ(back.code, kSuccess) << back.error;
  EXPECT_THAT(back.said, HasSubstr("back.yaml"));
  const vision::StereoRig before = vision::read_rig(kOurs), after = vision::read_rig(folder_ / "back.yaml");
  EXPECT_TRUE(vision::test::same(before.left, after.left));
  EXPECT_TRUE(vision::test::same(before.right, after.right));
  EXPECT_TRUE(before.right_from_left.isApprox(after.right_from_left, 1e-9));
  EXPECT_EQ(after.nearest, 0.9);
  EXPECT_EQ(after.farthest, 5);
  EXPECT_EQ(after.disparity_sigma, 0.2);
}

TEST_F(RigConvert, KeepsWhatItWasNotToldToChange) {
  ASSERT_EQ(convert(kOurs, folder_ / "same.yaml", {"--name", "head"}).code, kSuccess);
  const vision::StereoRig before = vision::read_rig(kOurs), after = vision::read_rig(folder_ / "same.yaml");
  EXPECT_EQ(after.name, "head");
  EXPECT_EQ(after.nearest, before.nearest);
  EXPECT_EQ(after.farthest, before.farthest);
  EXPECT_EQ(after.disparity_sigma, before.disparity_sigma);
}

TEST_F(RigConvert, NamesARigByItsNewFileWhereNobodyNamedIt) {
  ASSERT_EQ(convert(kOurs, ros()).code, kSuccess);
  ASSERT_EQ(convert(ros(), folder_ / "back.yaml").code, kSuccess);
  EXPECT_EQ(vision::read_rig(folder_ / "back.yaml").name, "back");
}

TEST_F(RigConvert, RefusesWhatWouldLoseOrDoNothing) {
  const std::string one = (folder_ / "a.yaml").string();
  EXPECT_TRUE(says(convert(kOurs, one + "," + (folder_ / "./a.yaml").string()), {"is one file for both"}));
  EXPECT_FALSE(fs::exists(one));
  EXPECT_TRUE(says(convert(kOurs, one, {"--size", "3", "3"}), {"--size", "says", "leave it out"}));
}

TEST_F(RigConvert, SaysWhatIsWrong) {
  EXPECT_TRUE(says(convert(folder_ / "none.yaml", folder_ / "to.yaml"), {"none.yaml"}));
  EXPECT_TRUE(says(convert(kOurs, folder_ / "no/such/to.yaml"), {"to.yaml"}));
  EXPECT_TRUE(says(convert(kOurs, folder_ / "to.yaml", {"--near", "9"}), {"9"}));
  EXPECT_EQ(convert(kOurs, folder_ / "to.yaml", {"--size", "640"}).code, kBadInput);
  EXPECT_EQ(run_headway({"rig"}).code, kBadInput);
  EXPECT_FALSE(fs::exists(folder_ / "to.yaml"));
}

}  // namespace
}  // namespace headway::app
