#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"
#include "hal/head_kinematics.h"
#include "sim_hal/noise.h"
#include "sim_hal/render.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/sim_depth_camera.h"

namespace headway::sim {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d;
using std::chrono::milliseconds;

Lens real_lens() {
  return {.width = 340,
          .height = 240,
          .fx = 410,
          .fy = 413,
          .cx = 172,
          .cy = 118,
          .k1 = -0.21,
          .k2 = 0.07,
          .p1 = 0.0012,
          .p2 = -0.0008,
          .k3 = -0.01};
}

// The plumb bob model, written from the calibration toolbox's page, term by term: the oracle of the lens.
Vector2d projected(const Lens& l, const Vector3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r = std::sqrt(x * x + y * y);
  const double radial = 1 + l.k1 * std::pow(r, 2) + l.k2 * std::pow(r, 4) + l.k3 * std::pow(r, 6);
  const double dx = 2 * l.p1 * x * y + l.p2 * (std::pow(r, 2) + 2 * x * x);
  const double dy = l.p1 * (std::pow(r, 2) + 2 * y * y) + 2 * l.p2 * x * y;
  return {l.fx * (radial * x + dx) + l.cx, l.fy * (radial * y + dy) + l.cy};
}

// A camera 1.4 m above `at`, tilted down.
Isometry3d camera_at(const Pose2& at, double down, double height = 1.4) {
  Isometry3d pose = at.lifted(height);
  pose.linear() = pose.linear() * hal::body_from_optical(down);
  return pose;
}

World furnished() {
  World w;
  w.floor.size = {8, 8};
  add_room(w, {0, 0}, {7, 7}, 2.5, 0);
  w.things.push_back({"crate", Solid::box({1.0, 0.3, 0.4}, {0.5, 0.5, 0.8}, 0.5), 0});
  w.things.push_back({"post", Solid::cylinder({0.4, -0.5, 0}, 0.1, 1.2), 0});
  return w;
}

RC_GTEST_PROP(Lens, UndoesItsOwnDistortion, ()) {
  const Lens lens = real_lens();
  const Vector2d pixel(*rc::gen::inRange(0, 339), *rc::gen::inRange(0, 239));
  const Vector2d n = lens.normalised(pixel);
  RC_ASSERT((projected(lens, {n.x() * 3, n.y() * 3, 3}) - pixel).norm() < 1e-8);
}

TEST(Lens, HasNoRayBeyondTheFoldOfItsDistortion) {
  Lens lens = real_lens();
  lens.k1 = -0.6, lens.k2 = 0, lens.k3 = 0;
  EXPECT_TRUE(std::isnan(lens.normalised({4000, 120}).x()));
  EXPECT_FALSE(std::isnan(lens.normalised({172, 118}).x()));
}

TEST(Render, ShowsEachFieldOfACheckerWhereTheLensProjectsIt) {
  World w;
  w.textures = {{.name = "checker", .kind = Texture::Kind::kChecker, .contrast = 0.9, .grain = 0.2}};
  w.floor.size = {10, 10};
  const Scene scene(w);
  const Lens lens = real_lens();
  const Isometry3d pose = camera_at({-1.1, 0.13, 0.2}, 0.7);
  hal::GrayImage image;
  render(scene, lens, ray_table(lens), {.noise_sigma = 0}, pose, 1, image);
  // Three and more pixels from a corner, in all four directions, the fields alternate.
  int corners = 0;
  for (int i = -10; i <= 10; ++i)
    for (int j = -10; j <= 10; ++j) {
      const auto grey = [&](double dx, double dy) -> int {
        const Vector3d p = pose.inverse() * Vector3d(0.2 * i + dx, 0.2 * j + dy, 0);
        const Vector2d q = p.z() > 0.3 ? projected(lens, p) : Vector2d(-9, -9);
        const long u = std::lround(q.x()), v = std::lround(q.y());
        if (u < 0 || v < 0 || u >= lens.width || v >= lens.height) return -1;
        return image.pixels[static_cast<std::size_t>(v * lens.width + u)];
      };
      const double off = 0.012;  // about three pixels
      const int a = grey(off, off), b = grey(-off, off), c = grey(-off, -off), d = grey(off, -off);
      if (std::min({a, b, c, d}) < 0) continue;
      ++corners;
      const bool even = (i + j) % 2 == 0;
      EXPECT_GT(even ? std::min(a, c) - std::max(b, d) : std::min(b, d) - std::max(a, c), 30)
          << i << ' ' << j;
    }
  EXPECT_GT(corners, 20);
}

// Centroid of the polygon that the disc's edge projects to (shoelace formula).
Vector2d centroid_of_projected_disc(const Lens& lens, const Isometry3d& pose, const Vector3d& centre,
                                    double radius) {
  constexpr int kPoints = 720;
  const auto edge = [&](int i) {
    const double a = 2 * std::numbers::pi * i / kPoints;
    return projected(lens,
                     pose.inverse() * Vector3d(centre + radius * Vector3d(std::cos(a), std::sin(a), 0)));
  };
  Vector2d sum(0, 0);
  double area = 0;
  for (int i = 0; i < kPoints; ++i) {
    const Vector2d p = edge(i), q = edge(i + 1);
    const double cross = p.x() * q.y() - q.x() * p.y();
    area += cross;
    sum += cross * (p + q);
  }
  return sum / (3 * area);
}

TEST(Render, PutsBrightDiscsWhereTheyProjectTo) {
  World w;
  w.textures = {{.name = "black", .kind = Texture::Kind::kPlain, .brightness = 0.0},
                {.name = "white", .kind = Texture::Kind::kPlain, .brightness = 0.7}};
  w.ambient = 1;
  w.floor.size = {10, 10};
  const Lens lens = real_lens();
  const Isometry3d pose = camera_at({0, 0, 0}, 0.6);
  Vector2d total(0, 0);
  int discs = 0;
  for (int i = 0; i < 25; ++i) {
    const Vector2d at(1.6 + 0.037 * i, -0.4 + 0.2 * (i % 5));
    w.things = {{"mark", Solid::cylinder({at.x(), at.y(), 0}, 0.15, 1e-4), 1}};
    const Scene scene(w);
    hal::GrayImage image;
    render(scene, lens, ray_table(lens), {.noise_sigma = 0, .vignetting = 0}, pose, 1, image);
    Vector2d sum(0, 0);
    double weight = 0;
    for (int v = 0; v < lens.height; ++v)
      for (int u = 0; u < lens.width; ++u) {
        const double g = image.pixels[static_cast<std::size_t>(v * lens.width + u)];
        sum += g * Vector2d(u, v);
        weight += g;
      }
    ASSERT_GT(weight, 1000);
    const Vector2d expected = centroid_of_projected_disc(lens, pose, {at.x(), at.y(), 1e-4}, 0.15);
    const Vector2d error = sum / weight - expected;
    EXPECT_LT(error.norm(), 0.15) << at.transpose();
    total += error;
    ++discs;
  }
  EXPECT_LT((total / discs).norm(), 0.02);
}

TEST(Render, AddsNoiseOfTheAskedStrength) {
  World w;
  w.textures = {{.name = "grey", .kind = Texture::Kind::kPlain}};
  w.ambient = 1;
  const Scene scene(w);
  const Lens lens = Lens::pinhole(200, 200, 300, 99.5, 99.5);
  const Isometry3d down = camera_at({}, std::numbers::pi / 2);
  for (const double sigma : {0.8, 1.5, 4.0}) {
    hal::GrayImage image;
    render(scene, lens, ray_table(lens), {.noise_sigma = sigma, .vignetting = 0}, down, 5, image);
    double sum = 0, squares = 0;
    const auto n = static_cast<double>(image.pixels.size());
    for (const std::uint8_t p : image.pixels) sum += p, squares += static_cast<double>(p) * p;
    const double mean = sum / n, variance = squares / n - mean * mean;
    EXPECT_NEAR(mean, 0.5 * 255 * Imager{}.exposure, 0.6);
    EXPECT_NEAR(std::sqrt(variance - 1.0 / 12), sigma, 0.03 * sigma);  // 1/12: of rounding to whole levels
  }
}

struct StereoBench {
  Scene scene{furnished()};
  hal::ManualClock clock;
  StereoCameraModel model = [] {
    StereoCameraModel m;
    m.left = m.right = real_lens();
    m.right.cx = 165;
    m.right_from_left.translation() = Vector3d(-0.144, 0.001, 0);
    return m;
  }();
};

TEST(SimStereoCamera, HandsAFrameOverWhenTheTransferIsDone) {
  StereoBench b;
  SimStereoCamera camera(b.scene, b.clock, b.model);
  hal::StereoFrame frame;
  EXPECT_FALSE(camera.take_newest(frame));
  camera.expose(at_seconds(1), camera_at({}, 0.3));
  b.clock.set(at_seconds(1.0199));
  EXPECT_FALSE(camera.take_newest(frame));
  b.clock.set(at_seconds(1.02));
  ASSERT_TRUE(camera.take_newest(frame));
  EXPECT_EQ(frame.exposure, at_seconds(1));
  EXPECT_EQ(frame.sequence, 0U);
  EXPECT_EQ(frame.left.pixels.size(), 340U * 240U);
  EXPECT_FALSE(camera.take_newest(frame));
}

TEST(SimStereoCamera, DropsOlderFramesForTheNewestAndCountsThem) {
  StereoBench b;
  SimStereoCamera camera(b.scene, b.clock, b.model);
  camera.expose(at_seconds(1.0), camera_at({}, 0.3));
  camera.expose(at_seconds(1.1), camera_at({}, 0.3));
  camera.lose_frame();
  camera.expose(at_seconds(1.3), camera_at({}, 0.3));
  hal::StereoFrame frame;
  b.clock.set(at_seconds(1.25));
  ASSERT_TRUE(camera.take_newest(frame));
  EXPECT_EQ(frame.sequence, 1U);
  b.clock.set(at_seconds(2));
  ASSERT_TRUE(camera.take_newest(frame));
  EXPECT_EQ(frame.sequence, 3U);
}

TEST(SimStereoCamera, GivesTheSameBytesForTheSameSeed) {
  const auto shoot = [](std::uint64_t seed, std::uint64_t world_seed, int lost) {
    StereoBench b;
    World w = furnished();
    w.seed = world_seed;
    b.scene = Scene(w);
    b.model.seed = seed;
    SimStereoCamera camera(b.scene, b.clock, b.model);
    for (int i = 0; i < lost; ++i) camera.lose_frame();
    camera.expose(at_seconds(0), camera_at({-1, 0, 0}, 0.3));
    b.clock.set(at_seconds(1));
    hal::StereoFrame frame;
    camera.take_newest(frame);
    return frame;
  };
  const auto share_changed = [](const hal::GrayImage& a, const hal::GrayImage& b) {
    double changed = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) changed += a.pixels[i] != b.pixels[i];
    return changed / static_cast<double>(a.pixels.size());
  };
  const hal::StereoFrame a = shoot(1, 1, 0), again = shoot(1, 1, 0);
  EXPECT_EQ(a.left.pixels, again.left.pixels);
  EXPECT_EQ(a.right.pixels, again.right.pixels);
  EXPECT_GT(share_changed(a.left, shoot(2, 1, 0).left), 0.6) << "another sensor, another noise";
  EXPECT_GT(share_changed(a.left, shoot(1, 1, 1).left), 0.6) << "the next frame, another noise";
  EXPECT_GT(share_changed(a.left, shoot(1, 2, 0).left), 0.8) << "another world, other textures";
}

TEST(SimStereoCamera, ShowsBothEyesTheSameSpotsOfTheTexture) {
  // Without noise, a point's grey value agrees in both eyes up to a pixel's interpolation.
  StereoBench b;
  b.model.imager = {.noise_sigma = 0, .vignetting = 0};
  SimStereoCamera camera(b.scene, b.clock, b.model);
  const Isometry3d pose = camera_at({-1, 0, 0}, 0.4);
  camera.expose(at_seconds(0), pose);
  b.clock.set(at_seconds(1));
  hal::StereoFrame f;
  ASSERT_TRUE(camera.take_newest(f));
  double difference = 0, elsewhere = 0;
  int n = 0;
  const std::vector<Eigen::Vector2f> rays = ray_table(b.model.left);
  const std::vector<float> depth = true_depth(b.scene, rays, pose);
  for (std::size_t i = 0; i < depth.size(); i += 7) {
    const double z = static_cast<double>(depth[i]);
    const Vector3d left(static_cast<double>(rays[i].x()) * z, static_cast<double>(rays[i].y()) * z, z);
    const Vector3d right = b.model.right_from_left * left;
    const Vector2d q = projected(b.model.right, right);
    const Isometry3d map_from_right = pose * b.model.right_from_left.inverse();
    if (!(q.x() > 1 && q.y() > 1 && q.x() < 337 && q.y() < 237)) continue;
    if (!b.scene.sees(map_from_right.translation(), pose * left)) continue;
    const auto u = static_cast<std::size_t>(q.x()), v = static_cast<std::size_t>(q.y());
    const double fu = q.x() - static_cast<double>(u), fv = q.y() - static_cast<double>(v);
    const auto at = [&](std::size_t x, std::size_t y) {
      return static_cast<double>(f.right.pixels[y * 340 + x]);
    };
    const double seen = (1 - fv) * ((1 - fu) * at(u, v) + fu * at(u + 1, v)) +
                        fv * ((1 - fu) * at(u, v + 1) + fu * at(u + 1, v + 1));
    difference += std::abs(seen - f.left.pixels[i]);
    elsewhere += std::abs(at(u, v >= 6 ? v - 6 : v + 6) - f.left.pixels[i]);
    ++n;
  }
  ASSERT_GT(n, 5000);
  EXPECT_LT(difference, 0.25 * elsewhere) << "six pixels beside it the texture is another";
  EXPECT_LT(difference / n, 5) << "grey levels";
}

TEST(SimStereoCamera, RefusesALensThatCannotBe) {
  StereoBench b;
  StereoCameraModel bad = b.model;
  bad.right.width = 0;
  EXPECT_THROW(SimStereoCamera(b.scene, b.clock, bad), InputError);
  bad = b.model;
  bad.left.fx = -1;
  EXPECT_THROW(SimStereoCamera(b.scene, b.clock, bad), InputError);
}

struct DepthShot {
  std::vector<float> depth, truth;
};

DepthShot shoot(const Scene& scene, const DepthCameraModel& model, const Isometry3d& pose) {
  hal::ManualClock clock;
  SimDepthCamera camera(scene, clock, model);
  camera.expose(at_seconds(0), pose);
  clock.set(at_seconds(1));
  hal::DepthFrame frame;
  EXPECT_TRUE(camera.take_newest(frame));
  EXPECT_EQ(frame.width, model.width);
  EXPECT_EQ(frame.height, model.height);
  return {frame.depth, camera.truth()};
}

DepthCameraModel without_errors() {
  DepthCameraModel m;
  m.disparity_sigma = 0;
  m.outliers = m.missing = m.missing_at_edges = 0;
  return m;
}

TEST(SimDepthCamera, GivesTheTrueDepthWhenItHasNoErrors) {
  const Scene scene(furnished());
  const DepthCameraModel m = without_errors();
  const Isometry3d pose = camera_at({-1.5, 0, 0.1}, 0.35);
  const DepthShot shot = shoot(scene, m, pose);
  int measured = 0;
  for (int v = 0; v < m.height; v += 3)
    for (int u = 0; u < m.width; u += 3) {
      const auto i = static_cast<std::size_t>(v * m.width + u);
      const Vector3d direction = pose.linear() * Vector3d((u - m.cx) / m.focal, (v - m.cy) / m.focal, 1);
      const double z = scene.distance(pose.translation(), direction) / direction.norm();
      const Vector3d point = pose.translation() + z * direction;
      const bool in_right_image = u - m.focal * m.baseline / z >= 0;
      const bool both = scene.sees(pose * Vector3d(m.baseline, 0, 0), point);
      EXPECT_NEAR(static_cast<double>(shot.truth[i]), z, 1e-4 * z);
      if (in_right_image && both && z > m.nearest && z < m.farthest) {
        EXPECT_NEAR(static_cast<double>(shot.depth[i]), z, 1e-4 * z) << u << ' ' << v;
        ++measured;
      } else {
        EXPECT_TRUE(std::isnan(shot.depth[i])) << u << ' ' << v;
      }
    }
  EXPECT_GT(measured, 3000);
}

TEST(SimDepthCamera, IsBlindWhereTheRightEyeIsHiddenFromThePoint) {
  World w;
  w.floor.size = {20, 20};
  w.things.push_back({"wall", Solid::box({3.05, 0, 1.5}, {0.1, 10, 3}), 0});
  w.things.push_back({"post", Solid::box({1.5, 0, 1.5}, {0.02, 0.1, 3}), 0});
  const Scene scene(w);
  const DepthCameraModel m = without_errors();
  const DepthShot shot = shoot(scene, m, camera_at({}, 0));
  // The right eye sees the wall beside the post shifted: on the left of the post, fB/1.49 - fB/3 pixels of
  // wall are hidden.
  const double hidden = m.focal * m.baseline * (1 / 1.49 - 1 / 3.0);
  const int v = 60, post_left = static_cast<int>(std::ceil(m.cx - m.focal * 0.05 / 1.49));
  int blind = 0;
  for (int u = post_left - 30; u < post_left; ++u)
    blind += std::isnan(shot.depth[static_cast<std::size_t>(v * m.width + u)]) ? 1 : 0;
  EXPECT_NEAR(blind, hidden, 1.01);
}

class DepthErrors : public testing::Test {
 protected:
  DepthErrors() {
    World w;
    w.floor.size = {20, 20};
    w.things.push_back({"wall", Solid::box({2.05, 0, 1.5}, {0.1, 10, 3}), 0});
    scene_ = std::make_unique<Scene>(w);
  }
  // Disparity errors on a wall 2 m away [px]; NaN where nothing was measured.
  std::vector<double> errors(const DepthCameraModel& m) const {
    const DepthShot shot = shoot(*scene_, m, camera_at({}, 0));
    std::vector<double> e;
    for (std::size_t i = 0; i < shot.depth.size(); ++i) {
      const int u = static_cast<int>(i) % m.width, v = static_cast<int>(i) / m.width;
      if (u < 30 || v > 80) continue;  // only wall
      e.push_back(m.focal * m.baseline * (1 / static_cast<double>(shot.depth[i]) - 1 / 2.0));
    }
    return e;
  }
  std::unique_ptr<Scene> scene_;
};

double deviation(const std::vector<double>& values, double within = 1e9) {
  double sum = 0, squares = 0, n = 0;
  for (const double v : values)
    if (std::abs(v) < within) sum += v, squares += v * v, ++n;
  return std::sqrt(squares / n - sum * sum / (n * n));
}

TEST_F(DepthErrors, HaveTheAskedSigmaInTheDisparity) {
  for (const double sigma : {0.1, 0.3, 0.6}) {
    DepthCameraModel m = without_errors();
    m.disparity_sigma = sigma;
    EXPECT_NEAR(deviation(errors(m)), sigma, 0.03 * sigma);
    m.correlation = 2;
    EXPECT_NEAR(deviation(errors(m)), sigma, 0.06 * sigma) << "correlated";
  }
}

TEST_F(DepthErrors, LeaveOutAndFalsifyTheAskedShares) {
  DepthCameraModel m = without_errors();
  m.missing = 0.03;
  m.outliers = 0.02;
  double missing = 0, gross = 0;
  const std::vector<double> e = errors(m);
  for (const double x : e) {
    if (std::isnan(x)) ++missing;
    if (std::abs(x) > 0.3) ++gross;
  }
  const auto n = static_cast<double>(e.size());
  EXPECT_NEAR(missing / n, 0.03, 0.006);
  EXPECT_NEAR(gross / n, 0.02, 0.006);
}

TEST_F(DepthErrors, AreTheSameForTheSameSeedAndFrameOnly) {
  const DepthCameraModel m;
  DepthCameraModel other = m;
  other.seed = 2;
  const auto bits = [](const std::vector<double>& v) {
    std::vector<std::uint64_t> b;
    for (const double x : v) b.push_back(std::isnan(x) ? 0 : std::bit_cast<std::uint64_t>(x));
    return b;
  };
  EXPECT_EQ(bits(errors(m)), bits(errors(m)));
  EXPECT_NE(bits(errors(m)), bits(errors(other)));
}

TEST(SimDepthCamera, LosesPixelsAtDepthEdges) {
  World w;
  w.floor.size = {20, 20};
  w.things.push_back({"wall", Solid::box({3.05, 0, 1.5}, {0.1, 10, 3}), 0});
  w.things.push_back({"post", Solid::box({1.5, 0, 1.5}, {0.1, 0.4, 3}), 0});
  const Scene scene(w);
  DepthCameraModel m = without_errors();
  const DepthShot sharp = shoot(scene, m, camera_at({}, 0));
  m.missing_at_edges = 1;
  const DepthShot frayed = shoot(scene, m, camera_at({}, 0));
  int lost = 0;
  for (std::size_t i = 0; i < sharp.depth.size(); ++i)
    if (!std::isnan(sharp.depth[i]) && std::isnan(frayed.depth[i])) {
      ++lost;
      const double u = static_cast<double>(i % static_cast<std::size_t>(m.width));
      const double from_edge = std::abs(std::abs(u - m.cx) - m.focal * 0.2 / 1.45);
      EXPECT_LT(from_edge, 3) << u;
    }
  EXPECT_GT(lost, 2 * m.height);
}

TEST(SimDepthCamera, RefusesAModelThatCannotBe) {
  const Scene scene(furnished());
  const hal::ManualClock clock;
  const auto refused = [&](auto change) {
    DepthCameraModel m;
    change(m);
    EXPECT_THROW(SimDepthCamera(scene, clock, m), InputError);
  };
  refused([](DepthCameraModel& m) { m.width = 0; });
  refused([](DepthCameraModel& m) { m.focal = 0; });
  refused([](DepthCameraModel& m) { m.baseline = -0.1; });
  refused([](DepthCameraModel& m) { m.farthest = m.nearest; });
  refused([](DepthCameraModel& m) { m.missing = 1.5; });
  refused([](DepthCameraModel& m) { m.disparity_sigma = std::nan(""); });
}

}  // namespace
}  // namespace headway::sim
