#include "nav/walking/preview_control.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "hal/error.h"

namespace headway::nav {
namespace {

using Eigen::Vector2d;

double between(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 100001) / 100000.0;
}

/// ZMP references, one per tick.
class Reference {
 public:
  explicit Reference(double period) : period_(period) {}

  Reference& hold(const Vector2d& p, double duration) { return move(p, p, duration); }
  Reference& move(const Vector2d& from, const Vector2d& to, double duration) {
    const long n = std::lround(duration / period_);
    for (long i = 1; i <= n; ++i)
      points_.push_back(from + (to - from) * static_cast<double>(i) / static_cast<double>(n));
    return *this;
  }
  const std::vector<Vector2d>& points() const { return points_; }

 private:
  double period_;
  std::vector<Vector2d> points_;
};

struct Walk {
  std::vector<Vector2d> com, zmp, capture_point;
};

Walk run(PreviewControl& control, const std::vector<Vector2d>& reference) {
  Walk out;
  const std::size_t window = control.gains().preview.size();
  for (std::size_t k = 0; k + window <= reference.size(); ++k) {
    control.tick(std::span(reference).subspan(k));
    out.com.push_back(control.com());
    out.zmp.push_back(control.zmp());
    out.capture_point.push_back(control.capture_point());
  }
  return out;
}

/// Ten steps of 0.2 m as in planning.md: 2 s of rest, feet 0.095 m to either side, rest again.
constexpr double kRest = 2.0, kStep = 0.8;
std::vector<Vector2d> ten_steps(double double_support) {
  Reference r(0.005);
  Vector2d sole(0, 0);
  r.hold(sole, kRest);
  for (int k = 0; k < 10; ++k) {
    const Vector2d next(0.2 * k, k % 2 == 1 ? 0.095 : -0.095);
    r.move(sole, next, double_support).hold(next, kStep - double_support);
    sole = next;
  }
  return r.move(sole, {1.8, 0}, double_support).hold({1.8, 0}, 5).points();
}

struct Errors {
  double largest = 0, rms = 0, margin = 1;
};

/// The margin is that inside a 0.23 x 0.13 m sole in single support.
Errors errors_of(const Walk& walked, const std::vector<Vector2d>& reference, double double_support) {
  Errors e;
  for (std::size_t k = 0; k < walked.zmp.size(); ++k) {
    const Vector2d error = walked.zmp[k] - reference[k];
    e.largest = std::max(e.largest, error.cwiseAbs().maxCoeff());
    e.rms += error.squaredNorm() / 2 / static_cast<double>(walked.zmp.size());
    const double since = static_cast<double>(k + 1) * 0.005 - kRest;
    if (since <= 0 || since >= 10 * kStep || std::fmod(since, kStep) <= double_support + 1e-9) continue;
    e.margin = std::min({e.margin, 0.13 - error.x(), 0.10 + error.x(), 0.065 - std::abs(error.y())});
  }
  e.rms = std::sqrt(e.rms);
  return e;
}

TEST(PreviewGains, AreThoseOfTheWorkedExample) {
  const PreviewGains g = preview_gains({});
  EXPECT_NEAR(g.integral, 618.7016, 1e-4);
  EXPECT_NEAR(g.state(0), 72719.44, 1e-2);
  EXPECT_NEAR(g.state(1), 21549.60, 1e-2);
  EXPECT_NEAR(g.state(2), 177.0127, 1e-4);
  ASSERT_EQ(g.preview.size(), 320U);
  const std::array first{618.70, 777.51, 952.26, 1082.28};
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_NEAR(g.preview[i], first[i], 5e-3);
  EXPECT_NEAR(g.spectral_radius, 0.982792, 1e-6);
}

TEST(PreviewGains, AgreeWithTheGainsOfAnotherPatternGenerator) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) GTEST_SKIP() << "HEADWAY_DATA is not set";
  std::ifstream file(std::string(data) + "/walkgen/PreviewControlParameters.ini");
  ASSERT_TRUE(file);
  double height = 0, period = 0, window = 0, integral = 0, value = 0;
  Eigen::RowVector3d state;
  file >> height >> period >> window >> state(0) >> state(1) >> state(2) >> integral;
  const PreviewGains g = preview_gains({.com_height = height, .period = period, .window = window});
  EXPECT_NEAR(g.integral, integral, 0.05);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(g.state(i), state(i), 1e-4 * state(i));
  std::size_t n = 0;
  for (; n < g.preview.size() && file >> value; ++n) EXPECT_NEAR(g.preview[n], value, 6e-5 * value) << n;
  EXPECT_EQ(n, 320U);
}

RC_GTEST_PROP(PreviewGains, SolveTheRiccatiEquationAndMakeTheLoopStable, ()) {
  PreviewConfig config;
  config.com_height = between(0.3, 1.5);
  config.period = between(0.002, 0.02);
  config.window = config.period * *rc::gen::inRange(1, 400);
  config.error_weight = std::pow(10, between(-1, 2));
  config.state_weight = *rc::gen::inRange(0, 2) * between(0, 10);
  config.jerk_weight = std::pow(10, between(-7, -3));
  const PreviewGains g = preview_gains(config);
  RC_ASSERT(g.residual <= 1e-9);
  RC_ASSERT(g.spectral_radius < 1);
  RC_ASSERT(g.preview.size() == config.ticks());
}

TEST(PreviewGains, RefuseWhatCannotBe) {
  EXPECT_THROW(preview_gains({.com_height = 0}), InputError);
  EXPECT_THROW(preview_gains({.period = -0.005}), InputError);
  EXPECT_THROW(preview_gains({.window = 0}), InputError);
  EXPECT_THROW(preview_gains({.jerk_weight = 0}), InputError);
  EXPECT_THROW(preview_gains({.com_height = std::nan("")}), InputError);
}

TEST(PreviewControl, KeepsTheZmpInTheSoleWithAlmostNoDoubleSupport) {
  PreviewControl control({});
  const auto reference = ten_steps(0.02);
  const Errors e = errors_of(run(control, reference), reference, 0.02);
  EXPECT_LE(e.largest, 0.032);
  EXPECT_LE(e.rms, 0.0031);
  EXPECT_GE(e.margin, 0.035);
}

TEST(PreviewControl, KeepsTheZmpNearTheReferenceWithShortDoubleSupport) {
  PreviewControl control({});
  const auto reference = ten_steps(0.10);
  const Errors e = errors_of(run(control, reference), reference, 0.10);
  EXPECT_LE(e.largest, 0.0065);
  EXPECT_GE(e.margin, 0.060);
}

TEST(PreviewControl, EndsAtRestOverTheLastReference) {
  PreviewControl control({});
  run(control, ten_steps(0.10));
  EXPECT_NEAR(control.com().x(), 1.8, 1e-4);
  EXPECT_NEAR(control.com().y(), 0, 1e-4);
  EXPECT_LT(control.velocity().norm(), 1e-4);
}

/// Random footprints, with the rest before and after them.
std::vector<Vector2d> random_walk(int steps, double ahead = 5) {
  Reference r(0.005);
  Vector2d sole(0, 0);
  r.hold(sole, kRest);
  for (int k = 0; k < steps; ++k) {
    const Vector2d next(sole.x() + between(-0.1, 0.2), (k % 2 == 1 ? 1 : -1) * between(0.08, 0.13));
    r.move(sole, next, 0.1).hold(next, 0.7);
    sole = next;
  }
  return r.hold(sole, ahead).points();
}

RC_GTEST_PROP(PreviewControl, DoesNotCareWhereTheOriginIsNorHowTheAxesLie, ()) {
  const auto reference = random_walk(*rc::gen::inRange(1, 6), 2);
  const double angle = between(-3, 3);
  const Eigen::Rotation2D<double> turn(angle);
  const Vector2d shift(between(-1000, 1000), between(-1000, 1000));
  std::vector<Vector2d> moved;
  for (const Vector2d& p : reference) moved.push_back(turn * p + shift);

  PreviewControl here({}), there({});
  there.rest_at(shift);
  const Walk a = run(here, reference), b = run(there, moved);
  for (std::size_t k = 0; k < a.com.size(); ++k) {
    RC_ASSERT((turn * a.com[k] + shift - b.com[k]).norm() < 1e-8);
    RC_ASSERT((turn * a.zmp[k] + shift - b.zmp[k]).norm() < 1e-6);
  }
}

RC_GTEST_PROP(PreviewControl, IsBlindBeyondItsWindow, ()) {
  const auto reference = random_walk(*rc::gen::inRange(1, 5), 2);
  PreviewControl first({}), second({});
  const std::size_t window = first.gains().preview.size();
  const auto change = static_cast<std::size_t>(
      *rc::gen::inRange(static_cast<int>(window), static_cast<int>(reference.size())));
  auto changed = reference;
  for (std::size_t k = change; k < changed.size(); ++k) changed[k] += Vector2d(0.3, -0.2);
  const Walk a = run(first, reference), b = run(second, changed);
  for (std::size_t k = 0; k + window <= change; ++k) RC_ASSERT(a.com[k] == b.com[k]);
  if (change + 1 < reference.size() - window) RC_ASSERT(a.com[change] != b.com[change]);
}

RC_GTEST_PROP(PreviewControl, KeepsTheCapturePointNearTheFeet, ()) {
  const auto reference = random_walk(*rc::gen::inRange(1, 12));
  PreviewControl control({});
  const Walk walked = run(control, reference);
  for (std::size_t k = 0; k < walked.zmp.size(); ++k) {
    RC_ASSERT((walked.capture_point[k] - reference[k]).norm() < 0.30);
    RC_ASSERT((walked.zmp[k] - reference[k]).norm() < 0.015);
  }
}

/// Rows of the reference walk: 38 columns each 5 ms.
std::vector<std::array<double, 38>> reference_walk(const std::string& folder) {
  const std::string command = "gzip -dc '" + folder + "/walkgen/straight.datref.gz' 2>/dev/null";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 65536> part{};
  while (pipe) {
    const std::size_t got = std::fread(part.data(), 1, part.size(), pipe.get());
    if (got == 0) break;
    text.append(part.data(), got);
  }
  std::vector<std::array<double, 38>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::array<double, 38> row{};
    for (double& value : row) numbers >> value;
    if (numbers) rows.push_back(row);
  }
  return rows;
}

TEST(PreviewControl, MovesTheComAsAnotherPatternGeneratorDoes) {
  const char* data = std::getenv("HEADWAY_DATA");
  if (data == nullptr) GTEST_SKIP() << "HEADWAY_DATA is not set";
  const auto rows = reference_walk(data);
  if (rows.empty()) GTEST_SKIP() << "gzip is not there to unpack the reference";
  ASSERT_GT(rows.size(), 3000U);
  std::vector<Vector2d> zmp;
  for (const auto& row : rows) zmp.emplace_back(row[34], row[35]);
  PreviewControl control({});
  control.rest_at({rows[0][1], rows[0][2]});
  const Walk walked = run(control, zmp);
  double largest = 0, sum = 0;
  for (std::size_t k = 0; k < walked.com.size(); ++k) {
    const Vector2d error = walked.com[k] - Vector2d(rows[k][1], rows[k][2]);
    largest = std::max(largest, error.cwiseAbs().maxCoeff());
    sum += error.squaredNorm() / 2;
  }
  EXPECT_LE(largest, 0.0105);
  EXPECT_LE(std::sqrt(sum / static_cast<double>(walked.com.size())), 0.004);
}

}  // namespace
}  // namespace headway::nav
