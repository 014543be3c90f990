#include "app/pictures.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace headway::app {
namespace {

/// A flat wall at 2 m, with one column that was not measured.
vision::RangeView wall() {
  vision::RangeView view;
  view.camera = {40, 30, 50, 19.5, 14.5};
  view.near = 0.5;
  view.far = 5;
  view.depth.assign(40 * 30, 2.0F);
  view.sigma_depth.assign(40 * 30, 0.02F);
  for (int v = 0; v < 30; ++v) view.depth[view.index(7, v)] = view.sigma_depth[view.index(7, v)] = NAN;
  return view;
}

std::size_t count(const cv::Mat& image, const Colour& wanted) {
  return static_cast<std::size_t>(std::count(image.begin<Colour>(), image.end<Colour>(), wanted));
}

TEST(ImagePicture, ShowsTheGreyValues) {
  const cv::Mat out = image_picture({2, 1, {10, 240}});
  EXPECT_EQ(out.at<Colour>(0, 0), Colour::all(10));
  EXPECT_EQ(out.at<Colour>(0, 1), Colour::all(240));
}

TEST(DepthPicture, IsDarkWhereNothingWasMeasured) {
  const cv::Mat out = depth_picture(wall());
  const int top = out.rows - 30;
  EXPECT_EQ(out.at<Colour>(top + 5, 7), colours::kBackground);
  EXPECT_NE(out.at<Colour>(top + 5, 8), colours::kBackground);
  EXPECT_GT(out.cols, 40);  // the legend
}

TEST(DepthPicture, PaintsFartherThingsBrighter) {
  vision::RangeView view = wall();
  for (int v = 0; v < 30; ++v) {
    for (int u = 20; u < 40; ++u) view.depth[view.index(u, v)] = 4.0F;
  }
  const cv::Mat out = depth_picture(view);
  const Colour near = out.at<Colour>(out.rows - 10, 3), far = out.at<Colour>(out.rows - 10, 30);
  EXPECT_LT(near[1], far[1]);
}

TEST(DepthPicture, OfAnEmptyViewIsDarkButWhole) {
  vision::RangeView view = wall();
  std::fill(view.depth.begin(), view.depth.end(), NAN);
  const cv::Mat out = depth_picture(view);
  EXPECT_EQ(out.at<Colour>(out.rows - 1, 0), colours::kBackground);
}

RC_GTEST_PROP(Uncertainty, IsTheLargestStandardDeviationInAnyDirection, ()) {
  vision::RangeView view = wall();
  const int u = *rc::gen::inRange(8, 40), v = *rc::gen::inRange(0, 30);
  view.sigma_depth[view.index(u, v)] = static_cast<float>(*rc::gen::inRange(1, 400)) * 1e-3F;
  const double found = uncertainty(view, u, v);
  const Eigen::Matrix3d sigma = view.covariance(u, v);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {  // directions spread over the half sphere
    const double z = (i + 0.5) / 2000, a = 2.399963 * i, r = std::sqrt(1 - z * z);
    const Eigen::Vector3d d(r * std::cos(a), r * std::sin(a), z);
    const double along = std::sqrt(d.dot(sigma * d));
    RC_ASSERT(along <= found * (1 + 1e-6));
    most = std::max(most, along);
  }
  RC_ASSERT(most > 0.98 * found);
}

TEST(Uncertainty, IsNotANumberWhereNothingWasMeasured) { EXPECT_TRUE(std::isnan(uncertainty(wall(), 7, 3))); }

TEST(UncertaintyPicture, PaintsBlurredPointsBrighter) {
  vision::RangeView view = wall();
  for (int v = 0; v < 30; ++v) view.sigma_depth[view.index(30, v)] = 0.4F;
  const cv::Mat out = uncertainty_picture(view);
  const Colour sharp = out.at<Colour>(out.rows - 5, 29), blurred = out.at<Colour>(out.rows - 5, 30);
  EXPECT_LT(sharp[1], blurred[1]);
  EXPECT_EQ(out.at<Colour>(out.rows - 5, 7), colours::kBackground);
}

nav::FloorMap small_floor() {
  nav::FloorMap floor = nav::unseen_floor({0.05, {-1, -1}, 40, 40});
  for (int y = 5; y < 35; ++y) {
    for (int x = 5; x < 35; ++x) floor.cells[floor.grid.index({x, y})] = nav::Floor::kFree;
  }
  for (int y = 10; y < 14; ++y) floor.cells[floor.grid.index({30, y})] = nav::Floor::kBlocked;
  return floor;
}

TEST(FloorPicture, IsLargeEnoughToRead) {
  const cv::Mat out = floor_picture(small_floor());
  EXPECT_GE(std::max(out.cols, out.rows), 900);
  EXPECT_LE(std::max(out.cols, out.rows), 2400);
}

TEST(FloorPicture, ShowsFreeBlockedAndUnseenInTheSharesOfTheirCells) {
  FloorPictureConfig config;
  config.crop = false;
  const cv::Mat out = floor_picture(small_floor(), {}, config);
  // Of the cells: 896 free, 4 blocked. Grid lines and letters take a little.
  const double ratio =
      static_cast<double>(count(out, {250, 250, 250})) / static_cast<double>(count(out, {72, 62, 56}));
  EXPECT_NEAR(ratio, 896.0 / 4, 0.25 * 896 / 4);
}

TEST(FloorPicture, HasXToTheRightAndYUp) {
  FloorPictureConfig config;
  config.crop = false;
  const cv::Mat out = floor_picture(small_floor(), {}, config);
  cv::Point2d blocked(0, 0), free(0, 0);
  double n_blocked = 0, n_free = 0;
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols * 4 / 5; ++x) {  // without the legend
      if (out.at<Colour>(y, x) == Colour(72, 62, 56)) blocked += cv::Point2d(x, y), ++n_blocked;
      if (out.at<Colour>(y, x) == Colour(250, 250, 250)) free += cv::Point2d(x, y), ++n_free;
    }
  }
  EXPECT_GT(blocked.x / n_blocked, free.x / n_free);  // cells 30 of 40 along x
  EXPECT_GT(blocked.y / n_blocked, free.y / n_free);  // cells 10 to 13 of 40 along y: below the middle
}

TEST(FloorPicture, ShowsEachLayerItIsGiven) {
  const nav::FloorMap floor = small_floor();
  const cv::Mat plain = floor_picture(floor);
  const auto differs = [&](const FloorLayers& layers) {
    const cv::Mat out = floor_picture(floor, layers);
    return out.size() != plain.size() || count(out, {250, 250, 250}) != count(plain, {250, 250, 250});
  };
  FloorLayers layers;
  EXPECT_FALSE(differs(layers));
  layers.path = {{-0.5, 0}, {0.5, 0.2}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.feet = {{{0, 0.1, 0}, hal::Foot::kLeft, true}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.bodies = {{0.1, 0, 0.3}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.trail = {{0, 0}, {0.3, 0.3}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.believed_trail = {{0, 0}, {0.3, 0.3}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.obstacles = {{{0, 0}, {0.3, 0}, {0.3, 0.3}}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.collisions = {{0.2, 0.2}};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.start = Pose2{0, 0, 1};
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.goal = Eigen::Vector2d(0.2, 0.3);
  layers.goal_yaw = 0.5;
  EXPECT_TRUE(differs(layers));
  layers = {};
  layers.robot = Pose2{0, 0, 2};
  EXPECT_TRUE(differs(layers));
}

TEST(FloorPicture, ShowsTheBelievedWayWhereItAgreesWithTheTrueOne) {
  FloorLayers layers;
  layers.trail = {{-0.5, 0}, {0.5, 0.2}};
  const Colour believed{210, 130, 220}, walked{150, 30, 130};
  EXPECT_EQ(count(floor_picture(small_floor(), layers), believed), 0U);
  const auto key = count(floor_picture(small_floor(), layers), walked);
  layers.believed_trail = layers.trail;
  const cv::Mat out = floor_picture(small_floor(), layers);
  EXPECT_GT(count(out, believed), 300U) << "beside the other, and in the legend";
  EXPECT_GT(count(out, walked), key / 2);
}

TEST(FloorPicture, SaysWhatLiesOutsideTheMap) {
  const Colour outside{222, 218, 214};
  FloorPictureConfig config;
  config.crop = false;
  EXPECT_EQ(count(floor_picture(small_floor(), {}, config), outside), 0U);
  FloorLayers layers;
  layers.goal = Eigen::Vector2d(40, 0);
  const cv::Mat out = floor_picture(small_floor(), layers);
  int in_legend = 0;
  for (int y = 0; y < out.rows; ++y)
    for (int x = out.cols - 185; x < out.cols; ++x) in_legend += out.at<Colour>(y, x) == outside ? 1 : 0;
  EXPECT_GT(in_legend, 100);
}

TEST(FloorPicture, SaysWhatMayBeSteppedOverWhereSomethingMay) {
  nav::FloorMap floor = small_floor();
  EXPECT_EQ(count(floor_picture(floor, {}), colours::kLow), 0U);
  floor.cells[floor.grid.index({1, 1})] = nav::Floor::kLow;
  const cv::Mat out = floor_picture(floor, {});
  int in_legend = 0;
  for (int y = 0; y < out.rows; ++y)
    for (int x = out.cols - 185; x < out.cols; ++x)
      in_legend += out.at<Colour>(y, x) == colours::kLow ? 1 : 0;
  EXPECT_GT(in_legend, 100);
  EXPECT_GT(count(out, colours::kLow), static_cast<std::size_t>(in_legend)) << "the cell itself";
}

TEST(FloorPicture, StaysOfReasonableSizeWhenALayerRunsAway) {
  FloorLayers layers;
  layers.trail = {{0, 0}, {1e6, -1e9}, {NAN, 0}};
  const cv::Mat out = floor_picture(small_floor(), layers);
  EXPECT_LE(std::max(out.cols, out.rows), 4000);
}

TEST(FloorPicture, OfNothingSeenShowsTheWholeGrid) {
  const cv::Mat out = floor_picture(nav::unseen_floor({0.05, {0, 0}, 20, 10}));
  EXPECT_GE(std::max(out.cols, out.rows), 900);
}

TEST(Polyline, LeadsFromTheStartOverTheCellsToTheEnd) {
  const nav::FloorGrid grid{0.1, {0, 0}, 20, 20};
  nav::Path path;
  EXPECT_TRUE(polyline(path, grid).empty());
  path.start = {0.52, 0.51, 0};
  path.states = {
      {{5, 5}, 0, nav::Mode::kForward}, {{6, 5}, 0, nav::Mode::kForward}, {{6, 5}, 0, nav::Mode::kSideway}};
  path.end = {0.66, 0.55};
  const auto line = polyline(path, grid);
  ASSERT_EQ(line.size(), 4U);
  EXPECT_EQ(line.front(), path.start.position());
  EXPECT_TRUE(line[2].isApprox(Eigen::Vector2d(0.65, 0.55)));
  EXPECT_EQ(line.back(), path.end);
}

TEST(FootPrints, AreThoseOfTheFeetThatLandAndMarkTheCommitted) {
  nav::Walk walk;
  hal::Stance stance = hal::Stance::parallel({}, 0.19);
  hal::Foot foot = hal::Foot::kRight;
  for (int i = 0; i < 4; ++i, foot = hal::other(foot)) {
    hal::Footstep step;
    step.foot = foot;
    step.landing = {0.15, foot == hal::Foot::kLeft ? 0.19 : -0.19, 0};
    stance = stance.after(step);
    walk.steps.push_back(step);
    walk.stances.push_back(stance);
  }
  const auto feet = foot_prints(walk, 2);
  ASSERT_EQ(feet.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(feet[i].foot, walk.steps[i].foot);
    EXPECT_NEAR(feet[i].pose.x, 0.15 * static_cast<double>(i + 1), 1e-9);
    EXPECT_EQ(feet[i].committed, i < 2);
  }
  std::vector<FootPrint> both;
  add_stance(stance, both);
  EXPECT_EQ(both.size(), 2U);
}

}  // namespace
}  // namespace headway::app
