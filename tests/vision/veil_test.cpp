#include "vision/veil.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

namespace headway::vision {
namespace {

constexpr int kWidth = 60, kHeight = 40;

using OfPixel = std::function<double(int, int)>;

/// What is left of a view whose disparities, and their sigmas if there are any, are functions of the pixel.
RangeView filtered(const OfPixel& disparity_at, const OfPixel& sigma_at = {}) {
  DisparityImage disparity;
  disparity.resize(kWidth, kHeight);
  if (sigma_at) disparity.sigma = disparity.values;
  RangeView view;
  view.camera = {kWidth, kHeight, 500, 30, 20};
  view.depth.resize(disparity.values.size());
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      disparity.values[disparity.index(u, v)] = static_cast<float>(disparity_at(u, v));
      if (sigma_at) disparity.sigma[disparity.index(u, v)] = static_cast<float>(sigma_at(u, v));
      view.depth[view.index(u, v)] = static_cast<float>(72 / disparity_at(u, v));
    }
  view.sigma_depth = view.depth;
  drop_veils(disparity, {}, view);
  return view;
}

std::ptrdiff_t dropped(const RangeView& view) {
  return std::count_if(view.depth.begin(), view.depth.end(), [](float z) { return std::isnan(z); });
}

TEST(Veil, KeepsEveryPointOfAFloorAndOfAWallBesideTheWay) {
  EXPECT_EQ(dropped(filtered([](int, int v) { return 10 + 0.1 * v; })), 0) << "floor 1.4 m below";
  EXPECT_EQ(dropped(filtered([](int u, int) { return 10 + 0.45 * u; })), 0) << "wall 0.32 m beside";
}

TEST(Veil, DropsACurtainBetweenANearThingAndTheBackground) {
  const RangeView view = filtered([](int u, int) { return u < 20 ? 40.0 : u < 40 ? 40.0 - (u - 20) : 20.0; });
  for (int u = 22; u < 38; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(10, 20)]));
  EXPECT_FALSE(std::isnan(view.depth[view.index(50, 20)]));
  EXPECT_TRUE(std::isnan(view.sigma_depth[view.index(30, 20)]));
}

TEST(Veil, KeepsThingsThinnerThanItsReach) {
  const RangeView view = filtered([](int u, int) { return u >= 28 && u < 31 ? 40.0 : 20.0; });
  for (int u = 28; u < 31; ++u) EXPECT_FALSE(std::isnan(view.depth[view.index(u, 20)])) << u;
}

TEST(Veil, DropsAGentleCurtainThatIsTorn) {
  const auto curtain = [](int u, int) {
    return u < 20 ? 25.0 : u == 20 ? std::nan("") : u < 26 ? 25 - 0.4 * (u - 20) : 22.0;
  };
  const RangeView view = filtered(curtain);
  for (int u = 21; u < 23; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(30, 20)]));
}

TEST(Veil, DropsAGentleCurtainThatBendsThoughNoPixelIsMissing) {
  const auto curtain = [](int u, int) { return u < 20 ? 25.0 : u < 26 ? 25 - 0.4 * (u - 20) : 22.6; };
  const RangeView view = filtered(curtain, [](int u, int) { return u == 20 || u == 26 ? 0.6 : 0.2; });
  for (int u = 21; u < 25; ++u) EXPECT_TRUE(std::isnan(view.depth[view.index(u, 20)])) << u;
  EXPECT_FALSE(std::isnan(view.depth[view.index(10, 20)]));
  EXPECT_FALSE(std::isnan(view.depth[view.index(32, 20)]));
}

TEST(Veil, KeepsAWallBesideTheWayWhoseMatchesAreSound) {
  EXPECT_EQ(dropped(filtered([](int u, int) { return 10 + 0.45 * u; }, [](int, int) { return 0.45; })), 0);
}

TEST(Veil, CondemnsNothingBesideWhatIsNotKnown) {
  const RangeView view = filtered([](int u, int) { return u < 30 ? 20.0 : std::nan(""); });
  for (int u = 0; u < 30; ++u) EXPECT_FALSE(std::isnan(view.depth[view.index(u, 20)])) << u;
}

}  // namespace
}  // namespace headway::vision
