// Viewers that ask now and then end with the same bricks as one that saw everything.
#include "operator/voxel_mirror.h"

#include <map>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::remote {
namespace {

SeenBrick brick(int x, std::uint8_t occupied) {
  SeenBrick out;
  out.key = {x, -x, 2 * x};
  out.occupied.fill(occupied);
  out.unseen.fill(static_cast<std::uint8_t>(~occupied));
  return out;
}

/// What a page keeps of the messages that it gets.
struct Viewer {
  std::map<nav::BrickKey, std::uint8_t> bricks;  ///< the first byte of each
  std::uint64_t version = 0;
  std::size_t messages = 0;

  void ask(const VoxelMirror& mirror) {
    Voxels news;
    if (!mirror.since(version, news)) return;
    ++messages;
    if (news.whole) bricks.clear();
    ASSERT_EQ(news.keys.size() % 3, 0U);
    const std::size_t count = news.keys.size() / 3;
    ASSERT_LE(count, VoxelMirror::kAtOnce);
    ASSERT_EQ(news.occupied.size(), 64 * count);
    ASSERT_EQ(news.unseen.size(), 64 * count);
    for (std::size_t i = 0; i < count; ++i) {
      bricks[{news.keys[3 * i], news.keys[3 * i + 1], news.keys[3 * i + 2]}] = news.occupied[64 * i];
      EXPECT_EQ(static_cast<std::uint8_t>(~news.occupied[64 * i]), news.unseen[64 * i]);
    }
  }
};

RC_GTEST_PROP(VoxelMirror, WhoAsksSeldomEndsWithTheSame, ()) {
  struct Told {
    int key;
    std::uint8_t value;
    bool asks;
  };
  const auto told = *rc::gen::container<std::vector<Told>>(rc::gen::construct<Told>(
      rc::gen::inRange(0, 20), rc::gen::arbitrary<std::uint8_t>(), rc::gen::arbitrary<bool>()));
  VoxelMirror mirror;
  Viewer seldom, late;
  std::map<nav::BrickKey, std::uint8_t> truth;
  for (const Told& t : told) {
    const SeenBrick b = brick(t.key, t.value);
    truth[b.key] = t.value;
    mirror.take(b);
    if (t.asks) seldom.ask(mirror);
  }
  seldom.ask(mirror);
  late.ask(mirror);
  RC_ASSERT(seldom.bricks == truth);
  RC_ASSERT(late.bricks == truth);
  RC_ASSERT(mirror.bricks() == truth.size());
}

TEST(VoxelMirror, TellsNothingTwice) {
  VoxelMirror mirror;
  mirror.take(brick(1, 3));
  Viewer viewer;
  viewer.ask(mirror);
  viewer.ask(mirror);
  EXPECT_EQ(viewer.messages, 1U);
  mirror.take(brick(1, 3));
  viewer.ask(mirror);
  EXPECT_EQ(viewer.messages, 2U);
}

TEST(VoxelMirror, TellsALargeMapInParts) {
  VoxelMirror mirror;
  constexpr int kBricks = 4500;
  for (int i = 0; i < kBricks; ++i) mirror.take(brick(i, static_cast<std::uint8_t>(i)));
  Viewer viewer;
  for (int i = 0; i < 10; ++i) viewer.ask(mirror);
  EXPECT_EQ(viewer.messages, 3U);
  EXPECT_EQ(viewer.bricks.size(), static_cast<std::size_t>(kBricks));
}

TEST(VoxelMirror, OnlyTheFirstMessageMakesTheViewerForget) {
  VoxelMirror mirror;
  mirror.take(brick(1, 1));
  std::uint64_t version = 0;
  Voxels news;
  ASSERT_TRUE(mirror.since(version, news));
  EXPECT_TRUE(news.whole);
  mirror.take(brick(2, 1));
  ASSERT_TRUE(mirror.since(version, news));
  EXPECT_FALSE(news.whole);
}

TEST(VoxelMirror, AnotherWorldMakesAllForgetTheOneBefore) {
  VoxelMirror mirror;
  mirror.take(brick(1, 1));
  mirror.take(brick(2, 2));
  Viewer viewer;
  viewer.ask(mirror);
  ASSERT_EQ(viewer.bricks.size(), 2U);
  SeenBrick other = brick(3, 3);
  other.world = 1;
  mirror.take(other);
  viewer.ask(mirror);
  EXPECT_EQ(viewer.bricks, (std::map<nav::BrickKey, std::uint8_t>{{other.key, 3}}));
  EXPECT_EQ(mirror.bricks(), 1U);
}

}  // namespace
}  // namespace headway::remote
