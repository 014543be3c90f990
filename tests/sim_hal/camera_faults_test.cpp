// What each fault does to the pictures of a camera, against the pictures of one without it.
#include "sim_hal/camera_faults.h"

#include <cmath>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "hal/head_kinematics.h"
#include "sim_hal/sim_camera.h"

namespace headway::sim {
namespace {

World room() {
  World w;
  w.floor.size = {8, 8};
  add_room(w, {0, 0}, {7, 7}, 2.5, 0);
  w.things.push_back({"crate", Solid::box({1.0, 0.3, 0.4}, {0.5, 0.5, 0.8}, 0.5), 0});
  return w;
}

/// From a place that moves on with each frame, looking down at the crate.
Eigen::Isometry3d pose(int frame) {
  Eigen::Isometry3d p = Pose2{-1 + 0.02 * frame, 0, 0}.lifted(1.4);
  p.linear() = p.linear() * hal::body_from_optical(0.4);
  return p;
}

Time at(int frame) { return at_seconds(0.1 * frame); }

/// Frames 0 to 29, exposed each 0.1 s; the fault is on from the tenth up to the twentieth.
template <class Camera, class Frame>
std::vector<std::pair<Time, Frame>> taken(Camera& camera, hal::ManualClock& clock) {
  std::vector<std::pair<Time, Frame>> all;
  int next = 0;
  for (Time now{}; now <= at_seconds(6); now += seconds(0.005)) {
    clock.set(now);
    if (next < 30 && now >= at(next)) camera.expose(at(next), pose(next)), ++next;
    Frame frame;
    if (camera.take_newest(frame)) all.emplace_back(now, std::move(frame));
  }
  return all;
}

FaultSchedule schedule_of(Fault fault) {
  fault.begin = seconds(1);
  fault.length = seconds(1);
  return FaultSchedule({fault});
}

struct Stereo {
  std::vector<std::pair<Time, hal::StereoFrame>> frames;
  explicit Stereo(const Fault& fault, double noise = 1.5) {
    const Scene scene(room());
    hal::ManualClock clock;
    StereoCameraModel model;
    model.left = model.right = Lens::pinhole(160, 120, 120, 79.5, 59.5);
    model.right_from_left.translation().x() = -0.14;
    model.imager.noise_sigma = noise;
    const FaultSchedule faults = schedule_of(fault);
    SimStereoCamera camera(scene, clock, model, &faults);
    frames = taken<SimStereoCamera, hal::StereoFrame>(camera, clock);
  }
};

struct Depth {
  std::vector<std::pair<Time, hal::DepthFrame>> frames;
  explicit Depth(const Fault& fault) {
    const Scene scene(room());
    hal::ManualClock clock;
    const FaultSchedule faults = schedule_of(fault);
    SimDepthCamera camera(scene, clock, {.width = 80, .height = 60, .focal = 60, .cx = 39.5, .cy = 29.5},
                          &faults);
    frames = taken<SimDepthCamera, hal::DepthFrame>(camera, clock);
  }
};

const Fault kNothing{.kind = FaultKind::kBusOff};

bool faulty(int frame) { return frame >= 10 && frame < 20; }

double mean(const hal::GrayImage& image) {
  return std::accumulate(image.pixels.begin(), image.pixels.end(), 0.0) /
         static_cast<double>(image.pixels.size());
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](float x, float y) {
           return x == y || (std::isnan(x) && std::isnan(y));
         });
}

double measured(const hal::DepthFrame& frame) {
  return 1 - static_cast<double>(std::count_if(frame.depth.begin(), frame.depth.end(),
                                               [](float z) { return std::isnan(z); })) /
                 static_cast<double>(frame.depth.size());
}

TEST(CameraFaults, LostFramesLeaveGapsInTheNumbers) {
  const Stereo stereo({.kind = FaultKind::kFrameLoss});
  const Depth depth({.kind = FaultKind::kFrameLoss});
  std::vector<std::uint64_t> expected(20);
  for (std::size_t i = 0; i < 20; ++i) expected[i] = i < 10 ? i : i + 10;
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_EQ(stereo.frames.size(), 20U);
    ASSERT_EQ(depth.frames.size(), 20U);
    EXPECT_EQ(stereo.frames[i].second.sequence, expected[i]);
    EXPECT_EQ(depth.frames[i].second.sequence, expected[i]);
  }
}

TEST(CameraFaults, AShareOfTheFramesIsLost) {
  int lost = 0;
  const FaultSchedule faults({{.kind = FaultKind::kFrameLoss, .length = seconds(1), .share = 0.25}});
  for (std::uint64_t i = 0; i < 4000; ++i) lost += camera_faults(faults, {}, i).lost;
  EXPECT_NEAR(lost, 1000, 4 * std::sqrt(4000 * 0.25 * 0.75));
}

TEST(CameraFaults, LateFramesComeInOrderAndNoneOvertakesAnother) {
  const Stereo stereo({.kind = FaultKind::kFrameDelay, .delay = seconds(0.75)});
  Time before{};
  std::set<std::uint64_t> seen;
  for (const auto& [came, frame] : stereo.frames) {
    EXPECT_EQ(frame.exposure, at(static_cast<int>(frame.sequence))) << "their stamps stay true";
    EXPECT_GE(came, before);
    if (faulty(static_cast<int>(frame.sequence))) {
      EXPECT_NEAR(to_seconds(came - frame.exposure), 0.77, 0.0051);
    }
    before = came;
    seen.insert(frame.sequence);
  }
  EXPECT_TRUE(seen.contains(10) && seen.contains(18) && seen.contains(26));
  for (std::uint64_t held_up = 19; held_up < 26; ++held_up)
    EXPECT_FALSE(seen.contains(held_up)) << "20 to 26 waited behind 19, and came with it";
}

TEST(CameraFaults, AFrozenPictureComesAgainWithNewStampsAndNumbers) {
  const Stereo stereo({.kind = FaultKind::kFrozenPicture});
  const Depth depth({.kind = FaultKind::kFrozenPicture});
  ASSERT_EQ(stereo.frames.size(), 30U);
  for (std::size_t i = 1; i < 30; ++i) {
    const auto &one = stereo.frames[i - 1].second, &next = stereo.frames[i].second;
    EXPECT_EQ(next.exposure, at(static_cast<int>(i)));
    EXPECT_EQ(next.sequence, i);
    EXPECT_EQ(one.left.pixels == next.left.pixels, faulty(static_cast<int>(i))) << i;
    EXPECT_EQ(one.right.pixels == next.right.pixels, faulty(static_cast<int>(i))) << i;
    EXPECT_EQ(same_bits(depth.frames[i - 1].second.depth, depth.frames[i].second.depth),
              faulty(static_cast<int>(i)));
  }
}

TEST(CameraFaults, AFrozenStampComesWithNewPictures) {
  const Stereo stereo({.kind = FaultKind::kFrozenStamp}), sound(kNothing);
  ASSERT_EQ(stereo.frames.size(), 30U);
  for (std::size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(stereo.frames[i].second.exposure,
              faulty(static_cast<int>(i)) ? at(9) : at(static_cast<int>(i)));
    EXPECT_EQ(stereo.frames[i].second.left.pixels, sound.frames[i].second.left.pixels);
  }
}

TEST(CameraFaults, InTheDarkThatShareOfTheLightIsLeft) {
  const Stereo dark({.kind = FaultKind::kDark, .light = 0.2}, 0), sound(kNothing, 0);
  for (std::size_t i = 0; i < 30; ++i) {
    const double share = mean(dark.frames[i].second.left) / mean(sound.frames[i].second.left);
    EXPECT_NEAR(share, faulty(static_cast<int>(i)) ? 0.2 : 1, 0.02) << i;
  }
  const Depth covered({.kind = FaultKind::kDark, .light = 0.02});
  for (std::size_t i = 0; i < 30; ++i)
    EXPECT_EQ(measured(covered.frames[i].second) == 0, faulty(static_cast<int>(i))) << i;
}

TEST(CameraFaults, NoiseAddsToThatOfTheSensor) {
  const Stereo noisy({.kind = FaultKind::kNoise, .noise = 8}, 6), sound(kNothing, 0);
  for (std::size_t i = 0; i < 30; ++i) {
    const auto &a = noisy.frames[i].second.left.pixels, &b = sound.frames[i].second.left.pixels;
    double sum = 0, count = 0;
    for (std::size_t p = 0; p < a.size(); ++p) {
      if (b[p] < 50 || b[p] > 205) continue;  // no noise is cut off
      sum += std::pow(static_cast<double>(a[p]) - b[p], 2);
      ++count;
    }
    ASSERT_GT(count, 3000);
    EXPECT_NEAR(std::sqrt(sum / count), faulty(static_cast<int>(i)) ? 10 : 6, 0.4) << i;
  }
}

TEST(CameraFaults, SwappedEyesShowEachOthersPictures) {
  const Stereo swapped({.kind = FaultKind::kSwapped}), sound(kNothing);
  for (std::size_t i = 0; i < 30; ++i) {
    const bool fault = faulty(static_cast<int>(i));
    const auto &a = swapped.frames[i].second, &b = sound.frames[i].second;
    EXPECT_EQ(a.left.pixels, fault ? b.right.pixels : b.left.pixels);
    EXPECT_EQ(a.right.pixels, fault ? b.left.pixels : b.right.pixels);
  }
}

}  // namespace
}  // namespace headway::sim
