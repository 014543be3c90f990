#include "nav/view_patches.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "hal/error.h"
#include "known_room.h"

namespace headway::nav {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

const Isometry3d kPose = camera_pose({0, 0, 1.4}, 0.4, 0.3);

TEST(ViewPatches, LieOnTheSurfacesAsSureAsTheySay) {
  KnownRoom known(SyntheticRoom::furnished());
  std::vector<Patch> patches;
  double squares = 0;
  std::size_t count = 0, far_off = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    view_patches(known.see(kPose, seed), {}, patches);
    for (const Patch& p : patches) {
      const Vector3d ray = kPose.linear() * p.point;
      const double truth = known.room.cast(kPose.translation(), ray);  // 1 when right
      const double off = (truth - 1) / p.sigma;
      far_off += std::abs(off) > 5;
      if (std::abs(off) > 5) continue;
      squares += off * off;
      ++count;
    }
  }
  ASSERT_GT(count, 10000U);
  EXPECT_LT(static_cast<double>(far_off), 0.005 * static_cast<double>(count)) << "at depth edges";
  const double rms = std::sqrt(squares / static_cast<double>(count));
  EXPECT_GT(rms, 0.5);
  EXPECT_LT(rms, 1.2);
}

TEST(ViewPatches, AreAsManyAsAskedForAtMost) {
  KnownRoom known(SyntheticRoom::furnished());
  std::vector<Patch> patches;
  for (const int most : {200, 1000, 3000}) {
    view_patches(known.see(kPose, 1), {.most = most}, patches);
    EXPECT_LE(patches.size(), static_cast<std::size_t>(most));
    EXPECT_GE(patches.size(), static_cast<std::size_t>(most) / 3);
  }
}

TEST(ViewPatches, AreFoundOnSlopesThatAreSteepForTheirNoise) {
  KnownRoom known(SyntheticRoom{});
  const Isometry3d down = camera_pose({0, 0, 1.4}, 0.4, 0.7);
  std::vector<Patch> patches;
  for (const double sigma : {0.2, 0.02, 0.002}) {
    const Noise noise{.disparity_sigma = sigma, .correlation = 2, .outliers = 0.01};
    view_patches(look(known.room, known.camera, down, noise, sigma, 0.6, 6.0), {}, patches);
    EXPECT_GT(patches.size(), 2000U) << "of 2550 squares, at a sigma of " << sigma << " px";
  }
}

TEST(ViewPatches, LeaveOutWhatIsNotTrusted) {
  KnownRoom known(SyntheticRoom::furnished());
  vision::RangeView view = known.see(kPose, 1);
  std::vector<Patch> patches;
  view.weight.assign(view.depth.size(), 0.5F);
  view_patches(view, {}, patches);
  EXPECT_TRUE(patches.empty());
  view.weight.clear();
  view.far = 1;
  view_patches(view, {}, patches);
  for (const Patch& p : patches) EXPECT_LE(p.point.z(), 1);
  view.depth.assign(view.depth.size(), std::numeric_limits<float>::quiet_NaN());
  view_patches(view, {}, patches);
  EXPECT_TRUE(patches.empty());
}

TEST(ViewPatches, ErrAlikeWhereTheyComeFromAMatcher) {
  KnownRoom known(SyntheticRoom::furnished());
  vision::RangeView view = known.see(kPose, 1);
  std::vector<Patch> patches;
  view_patches(view, {}, patches);
  ASSERT_FALSE(patches.empty());
  for (const Patch& p : patches) ASSERT_EQ(p.alike, 0);
  view.weight.assign(view.depth.size(), 1.0F);
  view_patches(view, {}, patches);
  ASSERT_FALSE(patches.empty());
  for (const Patch& p : patches) ASSERT_EQ(p.alike, p.sigma);
}

TEST(ViewPatches, NameASettingOutOfBounds) {
  EXPECT_THROW((PatchConfig{.most = 1}.validate()), InputError);
  EXPECT_THROW((PatchConfig{.least_weight = 2}.validate()), InputError);
  EXPECT_NO_THROW(PatchConfig{}.validate());
}

}  // namespace
}  // namespace headway::nav
