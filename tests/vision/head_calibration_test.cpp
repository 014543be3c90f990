#include "vision/head_calibration.h"

#include <limits>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/angle.h"
#include "hal/error.h"
#include "simulated_head.h"
#include "vision/head_observability.h"

namespace headway::vision {
namespace {

using Eigen::Vector3d;
using test::PlantedErrors;
using test::Session;
using test::SimulatedHead;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// 2 deg at both zeros and both turns, 10 mm along each axis, 20 ms.
PlantedErrors two_degrees_ten_millimetres_twenty_milliseconds(double sign = 1) {
  PlantedErrors e;
  e.shift = sign * Vector3d(0.010, -0.010, 0.010);
  e.turn = sign * Vector3d(2 * kDegree, 0, -2 * kDegree);
  e.zero = {sign * 2 * kDegree, -sign * 2 * kDegree};
  e.time_offset = sign * 0.020;
  return e;
}

std::map<std::string, double> truth_of(const PlantedErrors& e) {
  return {{"camera.x", e.shift.x()},     {"camera.y", e.shift.y()},     {"camera.z", e.shift.z()},
          {"camera.turn_x", e.turn.x()}, {"camera.turn_z", e.turn.z()}, {"tilt_zero", e.zero.tilt},
          {"pan_zero", e.zero.pan},      {"time_offset", e.time_offset}};
}

HeadCalibrationInput recorded(const PlantedErrors& errors, std::uint32_t seed, const Session& session = {}) {
  SimulatedHead head(errors, seed);
  HeadCalibrationInput input = head.record(session);
  input.corner = head.measured_corner(0.001);
  return input;
}

std::string message_of(const HeadCalibrationInput& input) {
  try {
    calibrate_head(input);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(HeadCalibration, RecoversTwoDegreesTenMillimetresAndTwentyMilliseconds) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const PlantedErrors planted = two_degrees_ten_millimetres_twenty_milliseconds(seed % 2 == 0 ? 1 : -1);
    const HeadCalibration found = calibrate_head(recorded(planted, seed));
    ASSERT_EQ(found.estimates.size(), 8U);
    for (const Estimate& e : found.estimates) {
      const double allowed = e.unit == "rad" ? 0.1 * kDegree : e.unit == "m" ? 0.001 : 0.002;
      EXPECT_NEAR(e.value, truth_of(planted).at(e.name), allowed) << e.name << " of seed " << seed;
    }
    EXPECT_NEAR(found.rms, std::sqrt(2) * 0.25, 0.02);
    EXPECT_NEAR(to_seconds(found.time_offset), planted.time_offset, 0.002);
    EXPECT_NEAR(found.neck.zero.pan, planted.zero.pan, 0.1 * kDegree);
  }
}

TEST(HeadCalibration, StatesHonestStandardDeviations) {
  std::map<std::string, double> squares;
  constexpr int kSeeds = 16;
  for (std::uint32_t seed = 1; seed <= kSeeds; ++seed) {
    const PlantedErrors planted = two_degrees_ten_millimetres_twenty_milliseconds();
    Session session;
    session.images = 60;
    for (const Estimate& e : calibrate_head(recorded(planted, seed, session)).estimates) {
      const double z = (e.value - truth_of(planted).at(e.name)) / e.sigma;
      squares[e.name] += z * z;
    }
  }
  double all = 0;
  for (const auto& [name, sum] : squares) {
    const double rms = std::sqrt(sum / kSeeds);
    EXPECT_GT(rms, 0.6) << name;
    // Samples 20 ms apart leave the angles between them, and so the time offset, uncertain by some
    // microseconds more than the corners do.
    EXPECT_LT(rms, name == "time_offset" ? 2.5 : 1.5) << name;
    all += sum;
  }
  EXPECT_GT(std::sqrt(all / (kSeeds * 8)), 0.8);
  EXPECT_LT(std::sqrt(all / (kSeeds * 8)), 1.3);
}

TEST(HeadCalibration, HoldsThePanZeroWhenNobodyMeasuredWhereTheBoardIs) {
  const PlantedErrors planted = two_degrees_ten_millimetres_twenty_milliseconds();
  HeadCalibrationInput input = recorded(planted, 3);
  input.corner.reset();
  const HeadCalibration found = calibrate_head(input);
  EXPECT_EQ(found.neck.zero.pan, 0);
  auto truth = truth_of(planted);
  for (const Estimate& e : found.estimates) {
    EXPECT_NE(e.name, "pan_zero");
    const double allowed = e.unit == "rad" ? 0.1 * kDegree : e.unit == "m" ? 0.001 : 0.002;
    EXPECT_NEAR(e.value, truth.at(e.name), allowed) << e.name << " needs no measured corner";
  }
}

TEST(HeadCalibration, CountsTheCamerasOwnPitchAsTiltZeroAndStillKnowsWhereItLooks) {
  PlantedErrors planted;
  planted.turn = {0, 1.5 * kDegree, 0};
  planted.zero.tilt = 0.5 * kDegree;
  SimulatedHead head(planted, 5);
  HeadCalibrationInput input = head.record({});
  input.corner = head.measured_corner(0.001);
  const HeadCalibration found = calibrate_head(input);
  EXPECT_NEAR(found.neck.zero.tilt, 2 * kDegree, 0.1 * kDegree);
  for (const hal::HeadAngles reported :
       {hal::HeadAngles{0, 0}, hal::HeadAngles{0.3, 0.5}, hal::HeadAngles{-0.4, -0.2}}) {
    const Eigen::Isometry3d off =
        head.chest_from_camera(reported.pan + planted.zero.pan, reported.tilt + planted.zero.tilt).inverse() *
        found.neck.chest_from_camera(reported);
    EXPECT_LT(off.translation().norm(), 0.002);
    EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), 0.1 * kDegree);
  }
}

TEST(HeadCalibration, RefusesTheTimeOffsetOfAHeadThatStandsStillAtEveryExposure) {
  Session at_rest;
  at_rest.while_moving = false;
  at_rest.images = 60;
  const std::string said = message_of(recorded({}, 1, at_rest));
  EXPECT_THAT(said, HasSubstr("do not determine time_offset; expected views while the head moves"));
}

TEST(HeadCalibration, RefusesAHeadThatOnlyPans) {
  Session only_pans;
  only_pans.tilt_span = 0;
  HeadCalibrationInput input = recorded({}, 1, only_pans);
  EXPECT_THAT(message_of(input), AllOf(HasSubstr("pan_zero"), HasSubstr("camera.turn_z"),
                                       HasSubstr("at tilt angles 20 deg apart"), HasSubstr("span 0.0 deg"),
                                       Not(HasSubstr("time_offset"))));
  input.corner.reset();
  EXPECT_THAT(message_of(input), AllOf(HasSubstr("camera.z"), HasSubstr("camera.turn_z"),
                                       HasSubstr("at tilt angles 20 deg apart")));
}

TEST(HeadCalibration, RefusesAHeadThatOnlyTilts) {
  Session only_tilts;
  only_tilts.pan_span = 0;
  HeadCalibrationInput input = recorded({}, 1, only_tilts);
  input.corner.reset();
  EXPECT_THAT(message_of(input),
              AllOf(HasSubstr("camera.y"), HasSubstr("tilt_zero"), HasSubstr("at pan angles 20 deg apart"),
                    Not(HasSubstr("time_offset"))));
}

TEST(HeadCalibration, RefusesAHeadThatNeverMoves) {
  Session still;
  still.pan_span = still.tilt_span = 0;
  HeadCalibrationInput input = recorded({}, 1, still);
  input.corner.reset();
  EXPECT_THAT(message_of(input),
              AllOf(HasSubstr("time_offset"), HasSubstr("camera.x"), HasSubstr("tilt_zero"),
                    HasSubstr("pan angles"), HasSubstr("tilt angles"), HasSubstr("while the head moves")));
}

TEST(HeadCalibration, RefusesAPanZeroFromACarelesslyMeasuredCorner) {
  HeadCalibrationInput input = recorded({}, 1);
  input.corner->sigma = 0.05;
  EXPECT_THAT(message_of(input), HasSubstr("do not determine pan_zero"));
}

TEST(HeadCalibration, RefusesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  HeadCalibrationInput input = recorded({}, 1);
  input.corner->place.y() = nan;
  EXPECT_THAT(message_of(input), HasSubstr("corner and its sigma must be finite"));
  input = recorded({}, 1);
  input.corner->sigma = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message_of(input), HasSubstr("corner and its sigma must be finite"));
  input = recorded({}, 1);
  input.views[5].board.pixels[3].x() = nan;
  EXPECT_THAT(message_of(input), HasSubstr("does not settle"));
}

TEST(Undetermined, IsEverythingWhereTheInformationIsNotFinite) {
  Eigen::Matrix2d information = 100 * Eigen::Matrix2d::Identity();
  EXPECT_TRUE(undetermined(information, Eigen::Vector2d::Ones(), {"a", "b"}).empty());
  information(0, 1) = information(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(undetermined(information, Eigen::Vector2d::Ones(), {"a", "b"}),
            (std::vector<std::string>{"a", "b"}));
}

TEST(HeadCalibration, NeedsViewsAndSamplesAroundThem) {
  HeadCalibrationInput few = recorded({}, 1);
  few.views.resize(3);
  EXPECT_THAT(message_of(few), HasSubstr("seen in 3 views, expected 4 or more"));
  HeadCalibrationInput gap = recorded({}, 1);
  const Time hole = gap.views[20].exposure;
  std::erase_if(gap.samples, [&](const HeadSample& s) {
    return s.stamp > hole - seconds(0.06) && s.stamp < hole + seconds(0.06);
  });
  EXPECT_THAT(message_of(gap), HasSubstr("no head samples around"));
  HeadCalibrationInput none = recorded({}, 1);
  none.samples.clear();
  EXPECT_THAT(message_of(none), HasSubstr("no head samples around"));
}

TEST(HeadSamples, CoverAnExposureWithTheWidestOffsetToBothSides) {
  std::vector<HeadSample> samples;
  for (int i = 0; i <= 50; ++i) samples.push_back({at_seconds(0.02 * i), {}});
  EXPECT_TRUE(samples_cover(samples, at_seconds(0.5)));
  EXPECT_TRUE(samples_cover(samples, at_seconds(0.2)));
  EXPECT_TRUE(samples_cover(samples, at_seconds(0.8)));
  EXPECT_FALSE(samples_cover(samples, at_seconds(0.199)));
  EXPECT_FALSE(samples_cover(samples, at_seconds(0.801)));
  EXPECT_FALSE(samples_cover({}, at_seconds(0.5)));
  samples.erase(samples.begin() + 30, samples.begin() + 36);
  EXPECT_FALSE(samples_cover(samples, at_seconds(0.5)));
  EXPECT_TRUE(samples_cover(samples, at_seconds(0.3)));
}

}  // namespace
}  // namespace headway::vision
