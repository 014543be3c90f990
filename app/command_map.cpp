// headway map: a recorded sequence in, the map of what it saw out.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "app/command_map_convert.h"
#include "app/commands.h"
#include "app/drawing.h"
#include "app/finite_range.h"
#include "app/level.h"
#include "app/map_view.h"
#include "app/output_folder.h"
#include "app/pictures.h"
#include "app/report.h"
#include "app/sequence.h"
#include "app/sequence_eyes.h"
#include "app/standard_streams.h"
#include "hal/angle.h"
#include "hal/error.h"
#include "nav/cloud_file.h"
#include "nav/explored.h"
#include "nav/floor_fit.h"
#include "nav/floor_map.h"
#include "nav/floor_projection.h"
#include "nav/integrate.h"
#include "nav/octomap_files.h"
#include "nav/voxel_map.h"

namespace headway::app {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kFramesToLevel = 6;  // to find up and the floor by
constexpr std::size_t kSurfelsPerFrame = 4000;
constexpr std::size_t kMostCloudPoints = 1'500'000;
// Recorded poses may be off level by more than a robot's head.
constexpr nav::FloorFitConfig kFloorOfSequence{.widest_tilt = 5 * kDegree, .greatest_height = 0.1};
constexpr double kBelowFloor = 0.4, kAboveFloor = 3.6;  // the map's box [m]

struct MapOptions {
  fs::path sequence, out;
  std::string rig;
  std::string matcher;  ///< empty: census
  double resolution = 0.05;
  std::optional<double> near, far;
};

/// `count` indices spread over 0..n-1, the first and the last among them.
std::vector<std::size_t> spread(std::size_t n, std::size_t count) {
  std::set<std::size_t> picks;
  for (std::size_t i = 0; i < count; ++i) picks.insert(count == 1 ? 0 : i * (n - 1) / (count - 1));
  return {picks.begin(), picks.end()};
}

/// Where the map lies in the world of the poses, and how that was found.
struct Ground {
  Eigen::Isometry3d map_from_world = Eigen::Isometry3d::Identity();
  Json report;
};

/// How the floor lies in the map by the plane that most views show near the camera; as assumed without one.
nav::FloorPlane fit_floor(const Sequence& sequence, SequenceEyes& eyes,
                          const Eigen::Isometry3d& map_from_world) {
  nav::FloorFitter fitter(kFloorOfSequence);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  nav::FloorPlane mean;
  for (const std::size_t i : spread(sequence.frames.size(), kFramesToLevel)) {
    const SequenceEyes::Look look = eyes.look(sequence.frames[i]);
    const nav::FloorFit fit = fitter.fit(*look.view, map_from_world * look.world_from_view);
    if (!fit) continue;
    // Over the map's origin, like those of the other views.
    Eigen::Matrix3d foot_from_origin = Eigen::Matrix3d::Identity();
    foot_from_origin.block<1, 2>(0, 1) = fit.plane.foot.transpose();
    const Eigen::Vector3d values(fit.plane.height, fit.plane.slope.x(), fit.plane.slope.y());
    const Eigen::Matrix3d told = foot_from_origin.transpose() * fit.plane.covariance.inverse();
    information += told * foot_from_origin;
    sum += told * values;
    mean.points += fit.plane.points;
  }
  if (mean.points == 0) return mean;
  const Eigen::Vector3d values = information.inverse() * sum;
  mean.height = values.x();
  mean.slope = values.tail<2>();
  return mean;
}

Ground find_ground(const Sequence& sequence, SequenceEyes& eyes) {
  std::vector<Surfel> surfels;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  Progress progress("finding the floor");
  for (const std::size_t i : spread(sequence.frames.size(), kFramesToLevel)) {
    progress.show(i, sequence.frames.size(), sequence.frames[i].name);
    const SequenceEyes::Look look = eyes.look(sequence.frames[i]);
    add_surfels(*look.view, look.world_from_view, kSurfelsPerFrame, surfels);
    up -= look.world_from_view.linear().col(1);  // cameras are held upright, more or less
  }
  Ground ground;
  if (sequence.world_is_level) {
    up = Eigen::Vector3d::UnitZ();
    ground.report["up"] = "z of the recorded poses";
    if (sequence.rotations_inverted)
      ground.report["rotations"] = "of the pose table read as camera from world";
  } else {
    const Eigen::Vector3d guess =
        up.norm() > 1e-6 ? Eigen::Vector3d(up.normalized()) : -Eigen::Vector3d::UnitY();
    up = estimate_up(surfels, guess);
    ground.report["up"] = "direction to which most surfaces seen lie level or upright";
    ground.report["off_the_cameras_mean_up_deg"] =
        rounded(std::acos(std::clamp(up.dot(guess), -1.0, 1.0)) * 180 / std::numbers::pi, 2);
  }
  const FloorHeight floor = estimate_floor(surfels, up);
  ground.map_from_world = map_from_world(up, floor.height, sequence.frames.front().world_from_camera);
  const nav::FloorPlane plane = fit_floor(sequence, eyes, ground.map_from_world);
  if (plane.points > 0) {
    const Eigen::Vector3d normal = Eigen::Vector3d(-plane.slope.x(), -plane.slope.y(), 1).normalized();
    Eigen::Isometry3d level = Eigen::Isometry3d::Identity();
    level.linear() = Eigen::Quaterniond::FromTwoVectors(normal, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    level.translation().z() = -plane.height * normal.z();
    ground.map_from_world = level * ground.map_from_world;
    ground.report["levelled_by_deg"] = rounded(std::atan(plane.slope.norm()) * 180 / std::numbers::pi, 2);
    ground.report["raised_by_m"] = rounded(-plane.height, 3);
  }
  ground.report["floor"] = floor.how;
  const double eye = (ground.map_from_world * sequence.frames.front().world_from_camera).translation().z();
  ground.report["first_camera_above_floor_m"] = rounded(eye, 3);
  return ground;
}

/// Everything that any frame can see within its range, between just below the floor and a ceiling.
nav::VoxelMapConfig map_box(const Sequence& sequence, const Ground& ground, const SequenceEyes& eyes,
                            double resolution) {
  const vision::PinholeCamera& c = eyes.camera();
  Eigen::AlignedBox3d seen;
  for (const SequenceFrame& frame : sequence.frames) {
    const Eigen::Isometry3d map_from_camera = ground.map_from_world * frame.world_from_camera;
    seen.extend(Eigen::Vector3d(map_from_camera.translation()));
    for (const double u : {0.0, c.width - 1.0}) {
      for (const double v : {0.0, c.height - 1.0})
        seen.extend(map_from_camera * c.point(u, v, eyes.range().far));
    }
  }
  nav::VoxelMapConfig config;
  config.resolution = resolution;
  config.lowest << seen.min().x(), seen.min().y(), std::max(seen.min().z() - 0.2, -kBelowFloor);
  config.highest << seen.max().x(), seen.max().y(), std::min(seen.max().z() + 0.2, kAboveFloor);
  // A camera that only looks up, or down from high above, still gets a box.
  config.highest.z() = std::max(config.highest.z(), config.lowest.z() + 1);
  return config;
}

Json box_report(const nav::VoxelMap& map) {
  const auto corner = [](const Eigen::Vector3d& p) {
    return Json::array({rounded(p.x(), 3), rounded(p.y(), 3), rounded(p.z(), 3)});
  };
  const std::size_t voxels = map.brick_count() * nav::VoxelMap::kBrickVoxels;
  return {{"resolution_m", map.resolution()},
          {"lowest", corner(map.lowest())},
          {"highest", corner(map.highest())},
          {"voxels", voxels},
          {"memory_mib", rounded(static_cast<double>(voxels) / (1 << 20), 1)}};
}

std::size_t points_within(const vision::RangeView& view, double near, double far) {
  return static_cast<std::size_t>(std::count_if(view.depth.begin(), view.depth.end(), [&](float z) {
    return static_cast<double>(z) >= near && static_cast<double>(z) <= far;
  }));
}

vision::VisionConfig vision_of(const MapOptions& options) {
  vision::VisionConfig config;
  if (!options.matcher.empty()) config.matcher.kind = vision::matcher_kind(options.matcher);
  return config;
}

class MapRun {
 public:
  explicit MapRun(const MapOptions& options)
      : options_(options),
        sequence_(read(options)),
        eyes_(sequence_, options.near, options.far, vision_of(options)) {}

  int run() {
    refuse_among_images();
    out_.emplace(options_.out, "map",
                 std::initializer_list<const char*>{"map_view.png", "map_above.png", "floor.png", "cloud.ply",
                                                    "map.bt", "floor.pgm", "floor.yaml"});
    ground_ = find_ground(sequence_, eyes_);
    map_ = std::make_unique<nav::VoxelMap>(map_box(sequence_, ground_, eyes_, options_.resolution));
    floor_ = nav::unseen_floor(nav::floor_grid(*map_));
    projection_.emplace(floor_.grid);
    const Json box = box_report(*map_);
    fmt::print("{} frames{}; map of {} voxels, {} MiB\n", sequence_.frames.size(), left_out(),
               box["voxels"].dump(), box["memory_mib"].dump());
    integrate_all();
    write_map();
    write_report(box);
    fmt::print("{}; {} points seen\n", out_->list(), points_);
    if (points_ > 0) return kSuccess;
    say_error("headway: {}: nothing was seen{}\n", options_.sequence.string(),
              sequence_.skipped.empty() ? " between --near and --far" : "; " + sequence_.skipped.front());
    return kNotReached;
  }

 private:
  static Sequence read(const MapOptions& options) {
    SequenceOptions reading;
    if (!options.rig.empty()) reading.rig = options.rig;
    Sequence sequence = read_sequence(options.sequence, reading);
    const char* idle = !options.rig.empty() ? "--rig" : !options.matcher.empty() ? "--matcher" : nullptr;
    if (sequence.layout == Sequence::Layout::kDepth && idle)
      throw InputError(fmt::format("map: {} is for stereo pairs, but {} holds depth images; leave it out",
                                   idle, options.sequence.string()));
    return sequence;
  }

  /// Pictures beside a sequence's images would be taken for some of them the next time.
  void refuse_among_images() const {
    std::error_code ignored;
    const fs::path out = fs::weakly_canonical(options_.out / "file", ignored).parent_path();
    for (const SequenceFrame& frame : sequence_.frames) {
      for (const fs::path& image : {frame.left, frame.right}) {
        if (image.empty() || fs::weakly_canonical(image, ignored).parent_path() != out) continue;
        throw InputError(fmt::format("map: --out: {} holds the sequence's own images; choose another folder",
                                     options_.out.string()));
      }
    }
  }

  std::string left_out() const {
    if (sequence_.skipped.empty()) return "";
    return fmt::format(" ({} left out: {}{})", sequence_.skipped.size(), sequence_.skipped.front(),
                       sequence_.skipped.size() > 1 ? ", and others" : "");
  }

  void integrate_all() {
    const std::size_t n = sequence_.frames.size();
    const std::vector<std::size_t> shown = spread(n, std::min<std::size_t>(n, 3));
    const double pixels =
        static_cast<double>(eyes_.camera().width) * eyes_.camera().height * static_cast<double>(n);
    cloud_ = nav::CloudFile(
        {.every = std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / kMostCloudPoints))))});
    Progress progress("mapping");
    for (std::size_t i = 0; i < n; ++i) {
      progress.show(i, n, sequence_.frames[i].name);
      integrate(sequence_.frames[i]);
      if (std::binary_search(shown.begin(), shown.end(), i)) draw_last(i);
    }
  }

  void integrate(const SequenceFrame& frame) {
    look_ = eyes_.look(frame);
    if (look_.fault) {
      sequence_.skipped.push_back(frame.name + ": " + look_.fault->what);
      return;
    }
    const Eigen::Isometry3d map_from_view = ground_.map_from_world * look_.world_from_view;
    Stopwatch watch;
    const nav::IntegrationStats stats = integrator_.integrate(*map_, *look_.view, map_from_view, frame.stamp);
    const double integrate_ms = watch.lap_ms();
    projection_->update(*map_, floor_);
    const double floor_ms = watch.lap_ms();
    cloud_.add(*look_.view, map_from_view);
    const std::size_t points = points_within(*look_.view, look_.view->near, look_.view->far);
    points_ += points;
    const double pixels = static_cast<double>(look_.view->depth.size());
    frames_.push_back({{"frame", frame.name},
                       {"pose", describe(frame.pose_source)},
                       {"density", rounded(static_cast<double>(points_within(*look_.view, 0, 1e9)) / pixels)},
                       {"points", points},
                       {"points_rejected", stats.rejected},
                       {"voxels_hit", stats.hits},
                       {"voxels_emptied", stats.misses},
                       {"voxels_first_seen", stats.first_seen},
                       {"bricks_changed", stats.bricks_changed},
                       {"read_ms", rounded(look_.read_ms, 3)},
                       {"see_ms", rounded(look_.see_ms, 3)},
                       {"integrate_ms", rounded(integrate_ms, 3)},
                       {"floor_ms", rounded(floor_ms, 3)}});
  }

  void draw_last(std::size_t i) {
    const auto file = [&](const char* what) { return out_->file(fmt::format("{}_{:03}.png", what, i)); };
    if (look_.left) write_png(image_picture(*look_.left), file("left"));
    write_png(depth_picture(*look_.view), file("depth"));
    write_png(uncertainty_picture(*look_.view), file("uncertainty"));
  }

  void write_map() {
    const Eigen::Isometry3d first = ground_.map_from_world * sequence_.frames.front().world_from_camera;
    MapViewConfig config;
    config.title = "as the camera looked, from behind it";
    const Eigen::Vector3d behind = -first.linear().col(2);
    const double elevation = std::clamp(std::asin(std::clamp(behind.z(), -1.0, 1.0)), 0.2, 0.9);
    write_png(
        map_view(*map_, bird_view(*map_, config, std::atan2(behind.y(), behind.x()), elevation), config),
        out_->file("map_view.png"));
    config.title = "from above, through the backs of walls and ceiling";
    write_png(map_view(*map_, bird_view(*map_, config, std::numbers::pi + 0.5, 0.9), config),
              out_->file("map_above.png"));
    FloorLayers layers;
    for (const SequenceFrame& frame : sequence_.frames) {
      layers.trail.push_back((ground_.map_from_world * frame.world_from_camera).translation().head<2>());
    }
    FloorPictureConfig floor;
    floor.title = "floor map, and the camera's way";
    write_png(floor_picture(floor_, layers, floor), out_->file("floor.png"));
    cloud_.write(out_->file("cloud.ply"));
    nav::write_bt(*map_, out_->file("map.bt"));
    write_floor(floor_, *out_);
  }

  void write_report(const Json& box) {
    const nav::ExploredSpace space = nav::explored(*map_);
    const nav::ExploredFloor area = nav::explored(floor_);
    Json report = {{"layout", sequence_.rig ? "stereo" : "depth"},
                   {"near_m", eyes_.range().near},
                   {"far_m", eyes_.range().far},
                   {"map", box},
                   {"ground", ground_.report},
                   {"points", points_},
                   {"volume_m3",
                    {{"occupied", rounded(space.occupied, 3)},
                     {"empty", rounded(space.empty, 3)},
                     {"unseen", rounded(space.unseen, 3)}}},
                   {"floor_m2",
                    {{"blocked", rounded(area.blocked, 3)},
                     {"free", rounded(area.free, 3)},
                     {"unseen", rounded(area.unseen, 3)}}},
                   {"skipped", sequence_.skipped},
                   {"frames", frames_}};
    out_->report(report);
  }

  MapOptions options_;
  std::optional<OutputFolder> out_;
  Sequence sequence_;
  SequenceEyes eyes_;
  Ground ground_;
  std::unique_ptr<nav::VoxelMap> map_;
  nav::Integrator integrator_;
  std::optional<nav::FloorProjection> projection_;
  nav::FloorMap floor_;
  nav::CloudFile cloud_;
  SequenceEyes::Look look_;
  std::size_t points_ = 0;
  Json frames_ = Json::array();
};

}  // namespace

void add_map(CLI::App& app, Run& run) {
  auto options = std::make_shared<MapOptions>();
  CLI::App* command = app.add_subcommand("map", "Builds the map of a recorded sequence, or converts a map.");
  command->footer(
      "DIR holds either stereo pairs as EuRoC keeps them (cam0/data/STAMP.png, cam1/data/STAMP.png,\n"
      "cam0/sensor.yaml, cam1/sensor.yaml, left_cam_gt*.csv with poses of the left camera), or depth images\n"
      "(frame-000000.depth.png [16 bit, mm], frame-000000.pose.txt [4x4, world from camera], ...,\n"
      "camera-intrinsics.txt [3x3]), or such as TUM keeps them (depth images [16 bit, 1/5000 m], "
      "groundtruth.txt,\n"
      "associations.txt or depth.txt, and camera-intrinsics.txt, which ICL-NUIM's do without). The map lies "
      "level, its floor at z = 0 under the first camera.\n"
      "Writes report.json (with each frame's density and times), cloud.ply, map.bt, floor.pgm, floor.yaml,\n"
      "map_view.png, map_above.png, floor.png, and of three frames depth_NNN.png, uncertainty_NNN.png and, "
      "of\n"
      "pairs, left_NNN.png.");
  // Both are required unless a subcommand is asked for.
  auto* sequence = command->add_option("--sequence", options->sequence, "Folder of the sequence (required)")
                       ->type_name("DIR");
  auto* out =
      command->add_option("--out", options->out, std::string(kOutHelp) + " (required)")->type_name("DIR");
  command
      ->add_option("--rig", options->rig,
                   "Of stereo pairs: a rig file in place of cam0/ and cam1/sensor.yaml")
      ->type_name("FILE");
  command->add_option("--resolution", options->resolution, "Edge of a voxel")
      ->check(finite_in(0.01, 0.5))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--near", options->near, "Nothing nearer is measured")
      ->check(finite_in(0, 10000))
      ->type_name("M");
  command->add_option("--far", options->far, "Points farther away do not enter the map")
      ->check(finite_in(0, 10000))
      ->type_name("M");
  command->add_option("--matcher", options->matcher, "Of stereo pairs: census (unless given), sgbm or bm")
      ->check(CLI::IsMember(vision::matcher_names()))
      ->type_name("NAME");
  add_map_convert(*command, run);
  command->callback([options, command, sequence, out, &run] {
    if (!command->get_subcommands().empty()) {
      for (const CLI::Option* option : command->get_options())
        if (!option->empty() && option != command->get_help_ptr())
          throw CLI::ExcludesError(option->get_name(), command->get_subcommands().front()->get_name());
      return;
    }
    for (const CLI::Option* option : {sequence, out}) {
      if (option->empty()) throw CLI::RequiredError(option->get_name());
    }
    run = [options] { return MapRun(*options).run(); };
  });
}

}  // namespace headway::app
