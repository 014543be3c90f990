#include "runtime/second_processor.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/source_dir/source_dir.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway::runtime {
namespace {

TEST(SecondProcessor, DoesTheSecondTaskOnAnotherThreadAndIsDoneWithBoth) {
  SecondProcessor second;
  for (int i = 0; i < 1000; ++i) {
    std::vector<int> a(100), b(100);
    std::thread::id here, there;
    second.both([&] { std::iota(a.begin(), a.end(), i), here = std::this_thread::get_id(); },
                [&] { std::iota(b.begin(), b.end(), i), there = std::this_thread::get_id(); });
    ASSERT_EQ(a, b);
    ASSERT_EQ(here, std::this_thread::get_id());
    ASSERT_NE(there, here);
  }
}

TEST(SecondProcessor, ThrowsWhatEitherTaskThrowsAfterBothHaveEndedAndGoesOn) {
  SecondProcessor second;
  const auto fails = [] { throw std::runtime_error("no memory"); };
  bool done = false;
  EXPECT_THROW(second.both([&] { done = true; }, fails), std::runtime_error);
  EXPECT_TRUE(done);
  done = false;
  EXPECT_THROW(second.both(fails, [&] { done = true; }), std::runtime_error);
  EXPECT_TRUE(done) << "what the task uses may be gone once it has thrown";
  EXPECT_THROW(second.both(fails, fails), std::runtime_error);
  done = false;
  second.both([] {}, [&] { done = true; });
  EXPECT_TRUE(done);
}

TEST(SecondProcessor, EndsUnused) { SecondProcessor second; }

hal::GrayImage noise(int width, int height, std::uint32_t seed, int shift) {
  hal::GrayImage image{width, height, {}};
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      std::uint32_t x = static_cast<std::uint32_t>((u + shift) / 3 * 7919 + v / 3 * 104729) + seed;
      x = (x ^ (x >> 15)) * 2246822519U;
      image.pixels.push_back(static_cast<std::uint8_t>((x ^ (x >> 13)) >> 8));
    }
  return image;
}

TEST(SecondProcessor, ChangesNoBitOfWhatIsSeen) {
  vision::StereoRig rig = vision::read_rig(source_dir() / "config/hrp2/rigs/bottom_640.yaml");
  rig.left.k1 = rig.left.k2 = rig.left.k3 = rig.left.p1 = rig.left.p2 = 0;
  rig.right = rig.left;
  rig.right_from_left = Eigen::Translation3d(-rig.right_from_left.translation().norm(), 0, 0);
  SecondProcessor second;
  vision::StereoVision on_one(rig), on_two(rig, {}, second);
  for (const std::uint32_t seed : {1U, 2U}) {
    hal::StereoFrame frame;
    frame.left = noise(rig.left.width, rig.left.height, seed, 0);
    frame.right = noise(rig.right.width, rig.right.height, seed, 40);
    const vision::RangeView& one = on_one.see(frame);
    const vision::RangeView& two = on_two.see(frame);
    const auto same = [](const std::vector<float>& a, const std::vector<float>& b) {
      return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
    };
    EXPECT_TRUE(same(one.depth, two.depth));
    EXPECT_TRUE(same(one.sigma_depth, two.sigma_depth));
    EXPECT_TRUE(same(one.weight, two.weight));
    EXPECT_EQ(on_one.sight().pair.found, on_two.sight().pair.found);
    EXPECT_EQ(on_one.fault() + on_two.fault(), "");
    const auto seen = std::count_if(one.depth.begin(), one.depth.end(), [](float z) { return z > 0; });
    EXPECT_GT(static_cast<std::size_t>(seen), one.depth.size() / 2);
  }
}

}  // namespace
}  // namespace headway::runtime
