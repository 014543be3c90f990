// headway reconstruct: one stereo pair in, uncertain points out.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/drawing.h"
#include "app/finite_range.h"
#include "app/map_view.h"
#include "app/output_folder.h"
#include "app/pictures.h"
#include "app/report.h"
#include "app/sight_report.h"
#include "app/standard_streams.h"
#include "hal/error.h"
#include "hal/head_kinematics.h"
#include "nav/cloud_file.h"
#include "nav/integrate.h"
#include "nav/octomap_files.h"
#include "nav/voxel_map.h"
#include "vision/evaluation.h"
#include "vision/image_files.h"
#include "vision/rig_files.h"
#include "vision/stereo.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

constexpr double kDisparityUnit = 256;  // of disparity.png, as Middlebury and KITTI have it

struct ReconstructOptions {
  fs::path left, right, out;
  std::string rig, truth;
  std::optional<double> focal, baseline, cx, cy, near, far;
  double offset = 0, resolution = 0.02;
  std::string matcher = "census";
};

/// What the options say of a pair that is rectified already.
vision::StereoRig rectified_rig(const ReconstructOptions& options, const hal::GrayImage& left) {
  vision::StereoRig rig;
  rig.name = "of the options";
  vision::CameraIntrinsics& c = rig.left;
  c.width = left.width, c.height = left.height;
  c.fx = c.fy = *options.focal;
  c.cx = options.cx.value_or((left.width - 1) / 2.0);
  c.cy = options.cy.value_or((left.height - 1) / 2.0);
  rig.right = c;
  rig.right.cx += options.offset;
  rig.right_from_left.translation().x() = -*options.baseline;
  return rig;
}

vision::StereoRig rig_of(const ReconstructOptions& options, const hal::GrayImage& left) {
  if (options.rig.empty() && !(options.focal && options.baseline)) {
    throw InputError(
        "reconstruct: no calibration, expected --rig FILE, or --focal and --baseline of a rectified pair");
  }
  vision::RigDefaults defaults;
  defaults.width = left.width, defaults.height = left.height;
  vision::StereoRig rig =
      options.rig.empty() ? rectified_rig(options, left) : vision::read_rig(options.rig, defaults);
  rig.nearest = options.near.value_or(rig.nearest);
  rig.farthest = options.far.value_or(rig.farthest);
  vision::require_usable(rig);
  return rig;
}

/// 16 bits, disparity times 256; 0 is unknown, and so is what is not positive.
cv::Mat disparity_image(const vision::DisparityImage& disparity) {
  cv::Mat out = cv::Mat::zeros(disparity.height, disparity.width, CV_16U);
  for (int v = 0; v < disparity.height; ++v) {
    for (int u = 0; u < disparity.width; ++u) {
      const double units = static_cast<double>(disparity.values[disparity.index(u, v)]) * kDisparityUnit;
      if (units >= 0.5)
        out.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(std::min(std::round(units), 65535.0));
    }
  }
  return out;
}

/// The camera's field from just before it to its farthest, in a frame with x forward, y left, z up at the
/// camera.
nav::VoxelMapConfig box_of(const vision::RangeView& view, const Eigen::Isometry3d& map_from_camera,
                           double resolution) {
  Eigen::AlignedBox3d box(Eigen::Vector3d(map_from_camera.translation()));
  const vision::PinholeCamera& c = view.camera;
  for (const double u : {0.0, c.width - 1.0}) {
    for (const double v : {0.0, c.height - 1.0}) box.extend(map_from_camera * c.point(u, v, view.far));
  }
  nav::VoxelMapConfig config;
  config.resolution = resolution;
  config.lowest = box.min();
  config.highest = box.max();
  return config;
}

class Reconstruction {
 public:
  explicit Reconstruction(const ReconstructOptions& options) : options_(options) {}

  int run() {
    Stopwatch watch;
    hal::StereoFrame frame;
    frame.left = vision::read_gray(options_.left);
    frame.right = vision::read_gray(options_.right);
    times_["read_ms"] = rounded(watch.lap_ms(), 3);
    require_two_images(frame, options_.left, options_.right);
    vision::VisionConfig config;
    config.matcher.kind = vision::matcher_kind(options_.matcher);
    vision::StereoVision eyes(rig_of(options_, frame.left), config);
    show_progress("matching");
    watch.lap_ms();
    const vision::RangeView& view = eyes.see(frame);
    times_["see_ms"] = rounded(watch.lap_ms(), 3);
    if (!eyes.fault().empty()) throw InputError(options_.left.string() + ": " + eyes.fault());
    const auto truth = read_truth(eyes.disparity());
    nav::VoxelMap voxels(box_of(view, map_from_camera(), options_.resolution));
    out_.emplace(options_.out, "reconstruct");
    show_progress("pictures");
    write_pictures(eyes, view);
    show_progress("map");
    map(view, voxels);
    describe(eyes, view);
    if (truth) compare(eyes.disparity(), *truth);
    progress_.reset();
    write_json(out_->file("timing.json"), times_);
    out_->report(report_);
    fmt::print("{}; {} points, {:.1f} % of all pixels matched, {:.1f} % within {:g} to {:g} m\n",
               out_->list(), points_, 100 * matched_, 100 * within_reach(view), view.near, view.far);
    print_findings(eyes.sight(), options_.left, options_.right);
    if (points_ == 0)
      say_error(
          "headway: {}, {}: no point was found from {:g} to {:g} m; check the calibration, and "
          "--near and --far\n",
          options_.left.string(), options_.right.string(), view.near, view.far);
    return points_ == 0 || eyes.sight().fault() ? kNotReached : kSuccess;
  }

 private:
  void show_progress(const char* stage) { progress_->show(++stage_, 3, stage); }

  void write_pictures(const vision::StereoVision& eyes, const vision::RangeView& view) {
    Stopwatch watch;
    write_png(image_picture(eyes.rectified_left()), out_->file("left.png"));
    write_png(depth_picture(view), out_->file("depth.png"));
    write_png(uncertainty_picture(view), out_->file("uncertainty.png"));
    write_png(disparity_image(eyes.disparity()), out_->file("disparity.png"));
    times_["pictures_ms"] = rounded(watch.lap_ms(), 3);
  }

  /// Share of all pixels whose depth lies between the view's limits.
  static double within_reach(const vision::RangeView& view) {
    const auto within = std::ranges::count_if(view.depth, [&](float z) {
      return static_cast<double>(z) >= view.near && static_cast<double>(z) <= view.far;
    });
    return static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(1, view.depth.size()));
  }

  /// Where the camera stands is not known: the map's frame is the camera's, with x forward and z up.
  static Eigen::Isometry3d map_from_camera() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = hal::body_from_optical();
    return pose;
  }

  void map(const vision::RangeView& view, nav::VoxelMap& voxels) {
    Stopwatch watch;
    nav::integrate(voxels, view, map_from_camera(), Time{});
    times_["integrate_ms"] = rounded(watch.lap_ms(), 3);
    nav::write_bt(voxels, out_->file("map.bt"));
    nav::CloudFile cloud;
    cloud.add(view, map_from_camera());
    cloud.write(out_->file("cloud.ply"));
    points_ = cloud.size();
    report_["points"] = points_;
    watch.lap_ms();
    write_png(voxel_picture(voxels, view), out_->file("map_view.png"));
    times_["map_view_ms"] = rounded(watch.lap_ms(), 3);
  }

  static cv::Mat voxel_picture(const nav::VoxelMap& voxels, const vision::RangeView& view) {
    MapViewConfig config;
    config.floor_height = MapViewConfig::kNoFloor;
    config.colour_lowest = std::max(voxels.lowest().z(), -1.0);
    config.colour_highest = std::min(voxels.highest().z(), 1.0);
    config.title = "what was reconstructed, from beside the camera";
    Lookout from;
    const double middle = (std::max(view.near, 0.3) + view.far) / 2;
    from.eye = {-0.12 * middle, 0.22 * middle, 0.14 * middle};
    from.target = {0.8 * middle, 0, -0.05 * middle};
    return map_view(voxels, from, config);
  }

  void describe(const vision::StereoVision& eyes, const vision::RangeView& view) {
    const auto& found = eyes.disparity().values;
    const auto matched = std::count_if(found.begin(), found.end(), [](float d) { return std::isfinite(d); });
    matched_ = static_cast<double>(matched) / static_cast<double>(std::max<std::size_t>(1, found.size()));
    report_["density"] = rounded(matched_);
    report_["density_is"] = "share of all pixels matched";
    report_["density_within_near_and_far"] = rounded(within_reach(view));
    report_["sight"] = sight_report(eyes.sight());
    report_["near_m"] = view.near;
    report_["far_m"] = view.far;
    report_["frame"] = "the rectified left camera's, turned to x forward, y left, z up";
    const vision::DisparityRange& range = eyes.searched();
    report_["matcher"] = options_.matcher;
    report_["disparities"] = {{"lowest", range.lowest}, {"count", range.count}};
  }

  /// Of the size of what was found. Nothing where none is given.
  std::optional<vision::DisparityImage> read_truth(const vision::DisparityImage& found) const {
    if (options_.truth.empty()) return std::nullopt;
    vision::DisparityImage truth = vision::read_disparity(options_.truth);
    if (truth.width != found.width || truth.height != found.height) {
      throw InputError(fmt::format("{}: has {} x {} px, expected {} x {} as the rectified images",
                                   options_.truth, truth.width, truth.height, found.width, found.height));
    }
    return truth;
  }

  void compare(const vision::DisparityImage& found, const vision::DisparityImage& truth) {
    const vision::MatchQuality quality = vision::compare(found, truth);
    // Where the truth is known and its partner lies in the right image; before, of all pixels.
    report_["density_of_pixels"] = report_["density"];
    report_["density"] = rounded(quality.density);
    report_["density_is"] =
        "share of the pixels matched whose true disparity is known, and whose partner lies in the right "
        "image; "
        "density_of_pixels is that of all pixels, density_of_all_truth of all whose true disparity is known";
    report_["density_of_all_truth"] = rounded(quality.density_of_all);
    report_["bad_1"] = rounded(quality.bad_1);
    report_["bad_2"] = rounded(quality.bad_2);
    report_["inlier_rms_px"] = rounded(quality.inlier_rms);
    report_["coverage_3_sigma"] = rounded(quality.coverage_3_sigma);  // each counted with its inlier weight
    report_["weight_auc"] = rounded(quality.weight_auc);
    report_["coverage_3_sigma_of_inliers"] = rounded(quality.inlier_coverage);
    report_["sigma_px"] = {{"p10", rounded(quality.sigma_p10)},
                           {"median", rounded(quality.sigma_median)},
                           {"p90", rounded(quality.sigma_p90)}};
    report_["outside_3_sigma"] = {{"hidden_from_the_right_camera", rounded(quality.outside_hidden)},
                                  {"at_a_depth_edge", rounded(quality.outside_at_edge)},
                                  {"elsewhere", rounded(quality.outside_elsewhere)}};
  }

  ReconstructOptions options_;
  std::optional<OutputFolder> out_;
  std::optional<Progress> progress_{"reconstructing"};
  std::size_t stage_ = 0;
  double matched_ = 0;  ///< share of all pixels
  std::size_t points_ = 0;
  Json report_ = Json::object(), times_ = Json::object();
};

}  // namespace

void add_reconstruct(CLI::App& app, Run& run) {
  auto options = std::make_shared<ReconstructOptions>();
  CLI::App* command =
      app.add_subcommand("reconstruct", "Turns one stereo pair into uncertain points and a map.");
  command->footer(
      "With --rig FILE the images are rectified first. A pair that is rectified already needs no file:\n"
      "  headway reconstruct left.png right.png --focal 994.978 --baseline 0.193001 --offset 31.086 \\\n"
      "    --cx 311.193 --cy 254.877 --near 2 --far 10 --out DIR\n"
      "(these are the numbers of Middlebury's Motorcycle; offset is its doffs)\n"
      "Writes report.json, timing.json, left.png, depth.png, uncertainty.png, disparity.png (16 bit,\n"
      "times 256), map_view.png, cloud.ply and map.bt, in the camera's frame: x forward, y left, z up.");
  command->add_option("left", options->left, "Left image")->required()->type_name("LEFT");
  command->add_option("right", options->right, "Right image")->required()->type_name("RIGHT");
  command->add_option("--out", options->out, kOutHelp)->required()->type_name("DIR");
  CLI::Option* rig =
      command
          ->add_option(
              "--rig", options->rig,
              "Rig: our YAML, Kalibr's camchain, OpenCV's yml; left.yaml,right.yaml of ROS; or a folder")
          ->type_name("FILE");
  const auto for_rectified = [&](const char* name, auto& value, const char* help, const char* unit,
                                 double lowest = -1e6, double highest = 1e6) {
    return command->add_option(name, value, help)
        ->check(finite_in(lowest, highest))
        ->type_name(unit)
        ->excludes(rig);
  };
  for_rectified("--focal", options->focal, "Focal length of a rectified pair", "PX", 1);
  for_rectified("--baseline", options->baseline, "Distance between its cameras", "M", 0.02, 1);
  for_rectified("--cx", options->cx, "Its left principal point; the image's centre unless given", "PX");
  for_rectified("--cy", options->cy, "The same, downwards", "PX");
  for_rectified("--offset", options->offset, "Its right principal point's x less the left one's (doffs)",
                "PX");
  command
      ->add_option("--near", options->near, "Nearest depth to match: sets how many disparities are searched")
      ->check(finite_in(0.05, 100))
      ->type_name("M");
  command->add_option("--far", options->far, "Points farther away do not enter the map")
      ->check(finite_in(0.05, 1000))
      ->type_name("M");
  command->add_option("--resolution", options->resolution, "Edge of a voxel")
      ->check(finite_in(0.005, 0.5))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--matcher", options->matcher, "census, sgbm or bm")
      ->check(CLI::IsMember(vision::matcher_names()))
      ->type_name("NAME")
      ->capture_default_str();
  command
      ->add_option("--truth", options->truth,
                   "True disparities (16-bit PNG, times 256, 0 unknown) to compare with")
      ->type_name("FILE");
  command->callback([options, &run] { run = [options] { return Reconstruction(*options).run(); }; });
}

}  // namespace headway::app
