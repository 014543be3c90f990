#include "sim_hal/scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "sim_hal/world.h"

namespace headway::sim {
namespace {

using Eigen::Isometry3d, Eigen::Vector2d, Eigen::Vector3d, Eigen::Vector3f;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double between(double a, double b) { return a + (b - a) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  Vector3d in_box(const Vector3d& low, const Vector3d& high) {
    return {between(low.x(), high.x()), between(low.y(), high.y()), between(low.z(), high.z())};
  }
  Vector3d direction() {
    for (;;) {
      const Vector3d d = in_box({-1, -1, -1}, {1, 1, 1});
      if (d.norm() <= 1 && d.norm() > 0.1) return d.normalized();
    }
  }
  Solid solid(double spread) {
    const double bottom = between(0, 1), top = bottom + between(0.05, 1.5);
    const Vector2d at(between(-spread, spread), between(-spread, spread));
    if (between(0, 1) < 0.5)
      return Solid::cylinder({at.x(), at.y(), bottom}, between(0.05, 0.8), top - bottom);
    return Solid::box({at.x(), at.y(), (bottom + top) / 2},
                      {between(0.05, 1.5), between(0.05, 1.5), top - bottom}, between(-4, 4));
  }

 private:
  std::mt19937_64 engine_;
};

// The oracle: solids as sets of points, written without a look at the code under test.
struct Oracle {
  // Six planes for a box, written with rotation matrices.
  static double ray_box(const Solid& s, const Vector3d& o, const Vector3d& d) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(s.pose.yaw, Vector3d::UnitZ()).toRotationMatrix();
    const Vector3d centre(s.pose.x, s.pose.y, (s.bottom + s.top) / 2);
    const Vector3d half(s.length / 2, s.width / 2, (s.top - s.bottom) / 2);
    double best = kInfinity;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        const Vector3d n = side * turn.col(axis);
        const double towards = n.dot(d);
        if (towards >= 0) continue;
        const double t = (half[axis] - n.dot(o - centre)) / towards;
        const Vector3d p = turn.transpose() * (o + t * d - centre);
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        if (t > 0 && std::abs(p[a]) <= half[a] && std::abs(p[b]) <= half[b]) best = std::min(best, t);
      }
    return best;
  }
  // Side and caps of a cylinder, by geometry: nearest approach of the ray to the axis.
  static double ray_cylinder(const Solid& s, const Vector3d& o, const Vector3d& d) {
    double best = kInfinity;
    for (const double z : {s.bottom, s.top}) {
      const double t = (z - o.z()) / d.z();
      const Vector3d p = o + t * d;
      if (t > 0 && std::hypot(p.x() - s.pose.x, p.y() - s.pose.y) <= s.radius) best = std::min(best, t);
    }
    const Vector2d to_axis = s.pose.position() - o.head<2>(), flat = d.head<2>();
    const double speed = flat.norm(), along = to_axis.dot(flat) / speed;
    const double miss2 = to_axis.squaredNorm() - along * along;
    if (miss2 <= s.radius * s.radius)
      for (const double t : {(along - std::sqrt(s.radius * s.radius - miss2)) / speed}) {
        const double z = o.z() + t * d.z();
        if (t > 0 && z >= s.bottom && z <= s.top) best = std::min(best, t);
      }
    return best;
  }
  static double ray(const World& w, const Vector3d& o, const Vector3d& d) {
    double best = kInfinity;
    for (const Solid& s : w.solids())
      best = std::min(best, s.shape == Shape::kBox ? ray_box(s, o, d) : ray_cylinder(s, o, d));
    const double t = -o.z() / d.z();
    const Vector2d p = (o + t * d).head<2>() - w.floor.centre;
    if (t > 0 && std::abs(p.x()) <= w.floor.size.x() / 2 && std::abs(p.y()) <= w.floor.size.y() / 2)
      best = std::min(best, t);
    return best;
  }
};

World clutter(std::uint64_t seed, int count) {
  Dice dice(seed);
  World w;
  w.floor.size = {8, 8};
  for (int i = 0; i < count; ++i) w.things.push_back({"thing " + std::to_string(i), dice.solid(3), 0});
  return w;
}

// The search walks cylinders as prisms of 96 sides, 0.54 mm inside at a radius of 1 m: rays that graze may
// differ.
bool grazes(const Scene& scene, const Vector3d& o, const Vector3d& d) {
  const double here = scene.distance(o, d);
  for (const Vector3d& off : {Vector3d(2e-3, 0, 0), Vector3d(-2e-3, 0, 0), Vector3d(0, 2e-3, 0),
                              Vector3d(0, -2e-3, 0), Vector3d(0, 0, 2e-3), Vector3d(0, 0, -2e-3)}) {
    const double there = scene.distance(o + off, d);
    if (std::isinf(here) != std::isinf(there) || std::abs(here - there) > 0.02) return true;
  }
  return false;
}

TEST(Scene, RaysEndWhereGeometrySaysTheyDo) {
  int compared = 0, hits = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const World w = clutter(seed, 12);
    const Scene scene(w);
    Dice dice(100 + seed);
    for (int i = 0; i < 1500; ++i) {
      const Vector3d o = dice.in_box({-4, -4, 0.05}, {4, 4, 3}), d = dice.direction();
      if (scene.occupied(o) || grazes(scene, o, d)) continue;
      const double expected = Oracle::ray(w, o, d);
      const RayHit hit = scene.cast(o, d);
      ++compared;
      ASSERT_EQ(hit.met(), std::isfinite(expected)) << "seed " << seed << " ray " << i;
      if (!hit.met()) continue;
      ++hits;
      ASSERT_NEAR(static_cast<double>(hit.distance), expected, 1e-4 * (1 + expected))
          << "seed " << seed << " ray " << i;
    }
  }
  EXPECT_GT(compared, 8000);
  EXPECT_GT(hits, 3000);
}

TEST(Scene, TellsThePointInTheObjectsOwnFrameAndTheNormalThatFacesTheRay) {
  const World w = clutter(3, 12);
  const Scene scene(w);
  Dice dice(5);
  int on_solids = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3d o = dice.in_box({-4, -4, 0.05}, {4, 4, 3}), d = dice.direction();
    if (scene.occupied(o)) continue;
    const RayHit hit = scene.cast(o, d);
    if (hit.surface < 0) continue;
    ++on_solids;
    const Solid& s = scene.solids()[static_cast<std::size_t>(hit.surface)];
    const Vector3d p = o + static_cast<double>(hit.distance) * d, n = hit.normal.cast<double>();
    EXPECT_LT((s.from_own(hit.own_point.cast<double>()) - p).norm(), 1e-4);
    EXPECT_NEAR(n.norm(), 1, 1e-4);
    EXPECT_LT(n.dot(d), 1e-6);
    // Just below the surface is inside, just above it outside.
    EXPECT_TRUE(s.contains(p - 2e-3 * n) || s.shape == Shape::kCylinder);
    EXPECT_FALSE(s.contains(p + 2e-3 * n));
  }
  EXPECT_GT(on_solids, 300);
}

TEST(Scene, PacketsAnswerAsSingleRaysDo) {
  const Scene scene(clutter(7, 15));
  Dice dice(9);
  for (int round = 0; round < 200; ++round) {
    const Vector3f o = dice.in_box({-4, -4, 1}, {4, 4, 3}).cast<float>();
    RayPacket packet;
    packet.count = 1 + round % RayPacket::kSize;
    for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
      const Vector3f d = dice.direction().cast<float>();
      packet.dx[i] = d.x(), packet.dy[i] = d.y(), packet.dz[i] = d.z();
    }
    std::array<RayHit, RayPacket::kSize> hits;
    scene.cast(o, packet, hits);
    for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
      if (static_cast<int>(i) >= packet.count) {
        EXPECT_FALSE(hits[i].met());
        continue;
      }
      const RayHit one =
          scene.cast(o.cast<double>(), Vector3f(packet.dx[i], packet.dy[i], packet.dz[i]).cast<double>());
      EXPECT_EQ(one.surface, hits[i].surface);
      EXPECT_EQ(one.distance, hits[i].distance);
    }
  }
}

TEST(Scene, SeesAPointUnlessSomethingIsBetween) {
  World w;
  w.things.push_back({"post", Solid::cylinder({0, 0, 0}, 0.2, 2), 0});
  const Scene scene(w);
  EXPECT_FALSE(scene.sees({-1, 0, 1}, {1, 0, 1}));
  EXPECT_TRUE(scene.sees({-1, 0.3, 1}, {1, 0.3, 1}));
  EXPECT_TRUE(scene.sees({-1, 0, 1}, {-0.2, 0, 1})) << "a point on the surface is seen from its own side";
  EXPECT_FALSE(scene.sees({1, 0, 1}, {-0.2, 0, 1})) << "but not through the post";
  EXPECT_TRUE(scene.sees({-1, 0, 2.5}, {1, 0, 2.5}));
}

TEST(Scene, MovesWhatMovesAndItsTextureWithIt) {
  World w;
  MovingThing m;
  m.thing = {"cart", Solid::box({2, 0, 0.5}, {1, 1, 1}), 0};
  m.path = path_at_speed({{2, 0, 0}, {2, 3, 0}, {2, 3, std::numbers::pi / 2}}, 0.5);
  m.starts = {Trigger::Kind::kRobotWithin, 1.0, {0, 0}};
  w.moving.push_back(m);
  Scene scene(w);
  const Vector3d o(0, 0.1, 0.7), x = Vector3d::UnitX();
  const RayHit before = scene.cast(o, x);
  EXPECT_NEAR(static_cast<double>(before.distance), 1.5, 1e-6);
  EXPECT_EQ(scene.name_of(before.surface), "cart");
  scene.advance(at_seconds(1), {-3, 0, 0});
  EXPECT_EQ(scene.cast(o, x).distance, before.distance) << "the robot is not near";
  scene.advance(at_seconds(2), {-0.5, 0, 0});
  EXPECT_EQ(scene.cast(o, x).distance, before.distance) << "it has just set off";
  scene.advance(at_seconds(4), {-0.5, 0, 0});
  EXPECT_FALSE(scene.cast(o, x).met()) << "one metre to the left by now";
  const RayHit after = scene.cast(o + Vector3d(0, 1, 0), x);
  EXPECT_LT((after.own_point - before.own_point).norm(), 1e-5F);
  scene.advance(at_seconds(100), {-0.5, 0, 0});
  const RayHit turned = scene.cast(o + Vector3d(0, 3, 0), x);
  EXPECT_NEAR(turned.own_point.y(), 0.5F, 1e-5F) << "turned by 90 degrees it shows its left side";
  // The state is a value: setting it again brings everything back.
  const WorldState late = scene.state();
  WorldState start = late;
  start.set_off = {std::nullopt};
  scene.set_state(start);
  EXPECT_EQ(scene.cast(o, x).distance, before.distance);
  scene.set_state(late);
  EXPECT_EQ(scene.cast(o + Vector3d(0, 3, 0), x).own_point, turned.own_point);
}

// Do two sets of points meet? By trying points of `a` on a fine lattice.
template <class InA, class InB>
bool share_a_point(const Vector3d& low, const Vector3d& high, int steps, InA in_a, InB in_b) {
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j)
      for (int k = 0; k < steps; ++k) {
        const Vector3d share((i + 0.5) / steps, (j + 0.5) / steps, (k + 0.5) / steps);
        const Vector3d p = low + share.cwiseProduct(high - low);
        if (in_a(p) && in_b(p)) return true;
      }
  return false;
}

Solid grown(Solid s, double by) {
  s.length += 2 * by, s.width += 2 * by, s.radius += by, s.bottom -= by, s.top += by;
  return s;
}

TEST(Overlap, AgreesWithTryingPoints) {
  Dice dice(21);
  int apart = 0, together = 0;
  for (int i = 0; i < 1500; ++i) {
    const Solid a = dice.solid(0.9), b = dice.solid(0.9);
    const double r = a.reach();
    const Vector3d low(a.pose.x - r, a.pose.y - r, a.bottom), high(a.pose.x + r, a.pose.y + r, a.top);
    const bool points = share_a_point(
        low, high, 24, [&](const Vector3d& p) { return a.contains(p); },
        [&](const Vector3d& p) { return b.contains(p); });
    if (points) {
      ++together;
      EXPECT_TRUE(overlap(a, b)) << i;
    } else if (!overlap(grown(a, 0.05), grown(b, 0.05))) {
      ++apart;
      EXPECT_FALSE(overlap(a, b)) << i;
    } else if (overlap(a, b)) {
      // Between the lattice's points: there must at least be some when both grow a little.
      EXPECT_TRUE(share_a_point(
          low, high, 24, [&](const Vector3d& p) { return grown(a, 0.06).contains(p); },
          [&](const Vector3d& p) { return grown(b, 0.06).contains(p); }))
          << i;
    }
    EXPECT_EQ(overlap(a, b), overlap(b, a)) << i;
  }
  EXPECT_GT(apart, 200);
  EXPECT_GT(together, 300);
}

TEST(Collision, IsFoundAtTheRobotsTruePoseAndNotBesideIt) {
  World w;
  w.things.push_back({"post", Solid::cylinder({2, 1, 0}, 0.1, 0.7), 0});
  w.things.push_back({"lamp", Solid::box({0, 0, 2.2}, {0.5, 0.5, 0.4}), 0});
  const Scene scene(w);
  const std::vector<Solid> body{Solid::box({0, 0, 0.4}, {0.3, 0.4, 0.8}),
                                Solid::box({0, 0, 1.2}, {0.3, 0.7, 0.8})};
  EXPECT_FALSE(scene.collides(body, {0, 0, 0})) << "the lamp hangs above it";
  EXPECT_FALSE(scene.collides(body, {2, 0.69, 0}));
  const auto touched = scene.collides(body, {2, 0.71, 0});
  ASSERT_TRUE(touched);
  EXPECT_EQ(touched->part, 0U);
  EXPECT_EQ(scene.name_of(static_cast<int>(touched->solid)), "post");
  EXPECT_FALSE(scene.collides(body, {2, 0.71, std::numbers::pi / 2}))
      << "turned, it is only 0.3 m deep that way";
}

TEST(Truth, KnowsTheInsideOfSolidsAndTheDistanceAlongARay) {
  World w;
  w.things.push_back({"crate", Solid::box({1, 0, 0.5}, {1, 1, 1}), 0});
  const Scene scene(w);
  EXPECT_TRUE(scene.occupied({1, 0.4, 0.9}));
  EXPECT_FALSE(scene.occupied({1, 0.4, 1.1}));
  EXPECT_TRUE(scene.occupied({5, 5, -0.01}));
  EXPECT_NEAR(scene.distance({-1, 0, 0.5}, {2, 0, 0}), 1.5, 1e-6);
  EXPECT_NEAR(scene.distance({-1, 0, 3}, {0, 0, -5}), 3, 1e-6);
  EXPECT_EQ(scene.distance({-1, 0, 3}, {0, 0, 1}), kInfinity);
}

}  // namespace
}  // namespace headway::sim
