#include "app/sim_outputs.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "app/false_obstacles.h"
#include "app/frames_report.h"
#include "app/map_view.h"
#include "app/pictures.h"
#include "app/safety_report.h"
#include "app/sight_report.h"
#include "app/whole_map.h"
#include "nav/cold_map_file.h"
#include "nav/explored.h"
#include "nav/octomap_files.h"
#include "runtime/durable_file.h"
#include "sim_hal/render.h"

namespace headway::app {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::array<std::size_t, 3> kViewsShown{1, 5, 9};
constexpr std::size_t kMostShown = 64'000'000;  // voxels of the picture of the whole map, a byte each

double ms(Duration d) { return to_seconds(d) * 1e3; }

Json spread(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return rounded(values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))], 3);
  };
  return {{"p50_ms", at(0.5)}, {"p99_ms", at(0.99)}, {"max_ms", at(1)}};
}

Json step_row(const runtime::StepRecord& record) {
  const hal::Footstep& s = record.step.step;
  return {{"session", record.session},
          {"index", record.step.index},
          {"committed_s", rounded(to_seconds(record.committed), 3)},
          {"foot", s.foot == hal::Foot::kLeft ? "left" : "right"},
          {"dx_m", rounded(s.landing.x, 3)},
          {"dy_m", rounded(s.landing.y, 3)},
          {"dyaw_deg", rounded(s.landing.yaw * kDegrees, 2)},
          {"seconds", rounded(to_seconds(s.duration), 3)},
          {"clear_m", rounded(s.clear, 3)},
          {"frame_age_s", rounded(to_seconds(record.frame_age), 3)}};
}

std::vector<std::vector<Eigen::Vector2d>> outlines(const sim::Scene& scene) {
  std::vector<std::vector<Eigen::Vector2d>> all;
  for (const sim::Solid& solid : scene.solids()) {
    std::vector<Eigen::Vector2d> corners;
    if (solid.shape == sim::Shape::kBox) {
      for (const auto& [sx, sy] : {std::pair{1, 1}, {-1, 1}, {-1, -1}, {1, -1}})
        corners.push_back(solid.pose * Eigen::Vector2d(sx * solid.length / 2, sy * solid.width / 2));
    } else {
      for (int i = 0; i < 24; ++i) {
        const double a = i * std::numbers::pi / 12;
        corners.push_back(solid.pose *
                          Eigen::Vector2d(solid.radius * std::cos(a), solid.radius * std::sin(a)));
      }
    }
    all.push_back(std::move(corners));
  }
  return all;
}

std::vector<Eigen::Vector2d> positions(const std::vector<Pose2>& poses) {
  std::vector<Eigen::Vector2d> out;
  for (const Pose2& p : poses) out.push_back(p.position());
  return out;
}

/// How far the points of one polyline are from those of another, at most [m].
double farthest(const std::vector<Eigen::Vector2d>& from, const std::vector<Eigen::Vector2d>& to) {
  double worst = 0;
  for (const auto& p : from) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& q : to) nearest = std::min(nearest, (p - q).norm());
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// Without ceiling-high walls between the eye and the room.
MapViewConfig room_view(std::string title) {
  MapViewConfig config;
  config.highest.z() = 1.7;
  config.title = std::move(title);
  return config;
}

/// The world as it is now, from a corner of the room above its walls.
cv::Mat scene_picture(const sim::Scene& scene) {
  const sim::World& world = scene.world();
  const sim::Lens lens = sim::Lens::pinhole(800, 560, 640, 399.5, 279.5);
  const Eigen::Vector3d target(world.floor.centre.x(), world.floor.centre.y(), 0.3);
  const Eigen::Vector3d eye =
      target + Eigen::Vector3d(-0.62 * world.floor.size.x(), -0.75 * world.floor.size.y(), 5.5);
  Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  map_from_camera.linear() << right, forward.cross(right), forward;
  map_from_camera.translation() = eye;
  hal::GrayImage image;
  sim::render(scene, lens, sim::ray_table(lens), {.noise_sigma = 0, .vignetting = 0}, map_from_camera, 0,
              image);
  return image_picture(image);
}

/// What did not fit into the queues between the loops.
Json dropped(const runtime::Links& links) {
  return {{"chest", links.chest.dropped()}, {"head", links.head.dropped()}, {"steps", links.steps.dropped()}};
}

/// Frames of the control computer that could not be used, by reason, and those that never came.
Json unused(const drivers::WalkerCounts& counts) {
  return {{"wrong_crc", counts.wrong_crc},
          {"repeated", counts.repeated},
          {"wrong_sequence", counts.wrong_sequence},
          {"undeclared", counts.undeclared},
          {"lost", counts.lost}};
}

/// How the head was found to err, and in how many views the floor told of it.
Json levelling_report(const nav::Levelling& levelling) {
  const auto& counts = levelling.counters();
  return {{"tilt_deg", rounded(levelling.tilt() * kDegrees, 3)},
          {"roll_deg", rounded(levelling.roll() * kDegrees, 3)},
          {"height_m", rounded(levelling.height())},
          {"fitted", counts.fitted},
          {"unseen", counts.unseen},
          {"refused", counts.refused},
          {"revised", counts.revised}};
}

Json false_obstacles_report(const SimSession& session) {
  const FalseObstacleLimits limits;
  const FalseObstacles found =
      false_obstacles(session.mapper().floor(), session.robot().mapper.obstacle_heights(), session.scene(),
                      {session.trail().truth, SimTrail::kPeriod}, limits);
  return {{"cells", found.floor.size()},         {"seen_from_afar", found.from_afar.size()},
          {"fringe_cells", found.fringe.size()}, {"within_m", limits.within},
          {"margin_m", limits.margin},           {"fringe_m", limits.fringe}};
}

Json findings_report(const std::vector<SimSightFinding>& findings) {
  Json out = Json::array();
  for (const SimSightFinding& f : findings)
    out.push_back({{"severity", name(f.first.severity)},
                   {"what", f.first.what},
                   {"first_s", rounded(to_seconds(f.time), 3)},
                   {"frames", f.frames}});
  return out;
}

/// What moved before the robot's eyes, and how soon it answered.
Json moving_report(const SimSession& session) {
  const ReactionCheck& check = session.reactions();
  const double period = 1 / session.robot().simulation.frame_rate;
  Json seen = Json::array(), answered = Json::array();
  for (const ReactionCheck::Sighting& s : check.sightings())
    seen.push_back({{"thing", session.scene().world().moving[s.thing].thing.name},
                    {"set_off_s", rounded(to_seconds(s.set_off), 3)},
                    {"seen_s", rounded(to_seconds(s.seen), 3)},
                    {"visible_to_contact_s", rounded(s.warning, 3)}});
  for (const ReactionCheck::Reaction& r : check.reactions())
    answered.push_back({{"shown_s", rounded(to_seconds(r.shown), 3)},
                        {"frame_periods", rounded(to_seconds(r.handed - r.shown) / period, 3)},
                        {"frames", r.frames},
                        {"stopped", r.stopped},
                        {"left", r.left}});
  return {{"seen", seen}, {"answered", answered}};
}

Json body_mask_report(const BodyMaskCheck& check) {
  return {{"samples", check.samples()},
          {"outside_mask", check.outside()},
          {"farthest_m", rounded(check.farthest(), 3)}};
}

Json map_memory(const runtime::Mapper& mapper) {
  const Eigen::Vector3d window = mapper.voxels().highest() - mapper.voxels().lowest();
  const auto mib = [](std::size_t bytes) { return rounded(static_cast<double>(bytes) / (1 << 20), 2); };
  return {{"window_m", {rounded(window.x(), 2), rounded(window.y(), 2), rounded(window.z(), 2)}},
          {"window_mib", mib(mapper.voxels().bytes())},
          {"bricks_aside", mapper.aside().size()},
          {"aside_mib", mib(mapper.aside().bytes())}};
}

}  // namespace

Json sim_report(const SimSession& session, const SimOutcome& outcome) {
  const auto& mission = session.mission().counters();
  const auto& bus = session.bus_loop().counters();
  const auto& precision = session.precision();
  const auto space = nav::explored(session.mapper().everything(), session.mapper().box());
  const auto floor = nav::explored(session.mapper().floor());
  Json report;
  report["world"] = session.scene().world().name;
  report["robot"] = session.robot().name;
  report["seed"] = session.options().seed;
  report["sight"] = session.options().range_mode ? "range" : "stereo";
  report["replan"] = session.options().replan;
  report["localise"] = session.robot().localisation.use && session.options().localise;
  report["drift"] = session.options().drift;
  report["goal"] = {rounded(session.goal().position.x()), rounded(session.goal().position.y())};
  report["arrived"] = outcome.arrived;
  report["end"] = outcome.end;
  report["reason"] = outcome.reason;
  report["goal_error_m"] = rounded(outcome.goal_error);
  if (outcome.short_of_goal > 0) report["short_of_goal_m"] = rounded(outcome.short_of_goal);
  report["goal_yaw_error_deg"] =
      outcome.goal_yaw_error ? rounded(*outcome.goal_yaw_error * kDegrees, 2) : Json(nullptr);
  report["odometry_error_m"] = rounded(outcome.odometry_error);
  report["map_error_m"] = rounded(outcome.map_error);
  report["collisions"] = outcome.collision ? 1 : 0;
  report["falls"] = outcome.fallen ? 1 : 0;
  report["zmp_margin_m"] = rounded(session.body().body().smallest_margin());
  report["walked_m"] = rounded(outcome.walked, 3);
  report["simulated_s"] = rounded(outcome.seconds, 3);
  report["plans"] = mission.plans;
  report["replans"] = mission.replans;
  report["pauses"] = mission.pauses;
  report["threats"] = mission.threats;
  report["look_arounds"] = mission.look_arounds;
  report["views"] = session.mission().views_taken();
  report["moving"] = moving_report(session);
  report["body_mask"] = body_mask_report(session.body_mask());
  report["safety"] = safety_json(session.bus_loop().safety());
  report["faults"] = session.faults().report();
  report["frames"] = frames_json(session.frame_loop().counters());
  const auto& aligned = session.frame_loop().localisation().counters();
  report["views_aligned"] = {
      {"whole", aligned.whole}, {"partly", aligned.partly}, {"refused", aligned.refused}};
  report["levelling"] = levelling_report(session.frame_loop().levelling());
  report["false_obstacles"] = false_obstacles_report(session);
  report["bus"] = {{"cycles", bus.cycles},
                   {"frames", bus.frames},
                   {"plans_taken", bus.plans_taken},
                   {"plans_late", bus.plans_late},
                   {"plans_refused", bus.plans_refused},
                   {"walks_ended_early", bus.stops},
                   {"dropped", dropped(session.links())},
                   {"unused", unused(session.walker().counts())}};
  report["sight_findings"] = findings_report(session.sight_findings());
  report["precision"] = {
      {"points", precision.points},
      {"coverage_3_sigma", rounded(precision.share())},
      {"gross_outliers",
       rounded(precision.points ? static_cast<double>(precision.gross) / static_cast<double>(precision.points)
                                : 0)},
      {"outside_at_depth_edges",
       rounded(precision.points > precision.within_3_sigma
                   ? static_cast<double>(precision.at_edges) /
                         static_cast<double>(precision.points - precision.within_3_sigma)
                   : 0)}};
  report["explored"] = {
      {"occupied_m3", rounded(space.occupied, 3)},     {"empty_m3", rounded(space.empty, 3)},
      {"unseen_m3", rounded(space.unseen, 3)},         {"floor_free_m2", rounded(floor.free, 2)},
      {"floor_blocked_m2", rounded(floor.blocked, 2)}, {"floor_unseen_m2", rounded(floor.unseen, 2)}};
  report["map"] = map_memory(session.mapper());
  double oldest = 0;
  for (const auto& step : session.steps()) oldest = std::max(oldest, to_seconds(step.frame_age));
  report["oldest_frame_age_s"] = rounded(oldest, 3);
  report["events"] = Json::array();
  for (const SimEvent& event : session.events())
    report["events"].push_back({{"t_s", rounded(to_seconds(event.time), 3)},
                                {"state", name(event.state)},
                                {"x", rounded(event.base.x, 3)},
                                {"y", rounded(event.base.y, 3)}});
  report["orders"] = std::count_if(session.steps().begin(), session.steps().end(), [](const auto& record) {
    return record.step.order && record.step.order->place == 0;
  });
  report["steps"] = Json::array();
  for (const auto& step : session.steps()) report["steps"].push_back(step_row(step));
  return report;
}

SimOutputs::SimOutputs(SimSession& session) : session_(session) {
  session_.observe([this](const runtime::FrameSnapshot& snapshot) { see(snapshot); });
}

void SimOutputs::see(const runtime::FrameSnapshot& snapshot) {
  see_ms_.push_back(ms(snapshot.times.see));
  map_ms_.push_back(ms(snapshot.times.map));
  floor_ms_.push_back(ms(snapshot.times.floor));
  plan_ms_.push_back(ms(snapshot.times.plan));
  total_ms_.push_back(ms(snapshot.times.total()));
  walk_cost_.note(snapshot, session_.body().path_walked());
  if (snapshot.mission.views_taken() > views_taken_) take_view(snapshot);
  if (snapshot.mission.state() == runtime::MissionState::kWalk && snapshot.mission.walk())
    take_walk(snapshot);
}

void SimOutputs::take_view(const runtime::FrameSnapshot& snapshot) {
  views_taken_ = snapshot.mission.views_taken();
  cloud_.add(snapshot.view, snapshot.map_from_view);
  if (std::find(kViewsShown.begin(), kViewsShown.end(), views_taken_) == kViewsShown.end()) return;
  MapViewConfig config = room_view("");
  config.width = 700;
  config.height = 560;
  config.show_unseen = true;
  MapFigures figures;
  figures.robot = snapshot.bus.committed.stance.base();
  const auto& voxels = snapshot.mapper.voxels();
  views_.push_back(map_view(voxels, bird_view(voxels, config), config, figures));
  captions_.push_back(fmt::format("after {} view{}: {:.1f} m3 still unseen", views_taken_,
                                  views_taken_ == 1 ? "" : "s", nav::explored(voxels).unseen));
}

void SimOutputs::take_walk(const runtime::FrameSnapshot& snapshot) {
  const int replans = snapshot.mission.counters().replans;
  const auto keep = [&](std::string name, cv::Mat image) {
    pictures_.push_back({std::move(name), std::move(image)});
  };
  if (!walked_) {
    walked_ = true;
    last_path_ = polyline(snapshot.mission.walk()->path, snapshot.mapper.floor().grid);
    keep("plan", floor(snapshot.mapper, snapshot.mission, snapshot.bus, "the first plan"));
    if (snapshot.picture) keep("left", image_picture(*snapshot.picture));
    keep("depth", depth_picture(snapshot.view));
    keep("uncertainty", uncertainty_picture(snapshot.view));
  } else if (replans > replans_) {
    keep_replan(snapshot);
  }
  replans_ = replans;
}

void SimOutputs::keep_replan(const runtime::FrameSnapshot& snapshot) {
  // Of all changes of plan, the one that leads farthest away from the plan before it is shown.
  const auto path = polyline(snapshot.mission.walk()->path, snapshot.mapper.floor().grid);
  const double change = farthest(path, last_path_);
  const auto former = std::exchange(last_path_, path);
  if (change <= replan_change_) return;
  replan_change_ = change;
  replan_.clear();
  replan_.push_back(
      {"replan", floor(snapshot.mapper, snapshot.mission, snapshot.bus,
                       fmt::format("replanned at {:.1f} s", to_seconds(session_.now())), former)});
  if (snapshot.picture) replan_.push_back({"replan_left", image_picture(*snapshot.picture)});
}

std::vector<FootPrint> SimOutputs::walked_feet() const {
  std::vector<FootPrint> feet;
  add_stance(hal::Stance::parallel(session_.scene().world().start, session_.robot().mission.gait.feet_apart),
             feet);
  for (const auto& record : session_.steps()) feet.push_back({record.landing, record.step.step.foot, true});
  return feet;
}

FloorLayers SimOutputs::layers() const {
  FloorLayers layers;
  layers.outline = session_.robot().mission.outline;
  layers.gait = session_.robot().mission.gait;
  layers.feet = walked_feet();
  layers.trail = positions(session_.trail().truth);
  layers.start = session_.scene().world().start;
  layers.goal = session_.goal().position;
  layers.goal_yaw = session_.goal().yaw;
  return layers;
}

cv::Mat SimOutputs::floor(const runtime::Mapper& mapper, const runtime::Mission& mission,
                          const runtime::BusReport& bus, const std::string& title,
                          std::vector<Eigen::Vector2d> former_path) const {
  FloorLayers layers = this->layers();
  if (!former_path.empty()) layers.obstacles = outlines(session_.scene());
  layers.former_path = std::move(former_path);
  layers.robot = bus.committed.stance.base();
  if (const auto& walk = mission.walk()) {
    const std::size_t done =
        bus.committed.session == walk->session && bus.committed.next_index >= walk->first_index
            ? bus.committed.next_index - walk->first_index
            : 0;
    layers.path = polyline(walk->path, mapper.floor().grid);
    for (std::size_t i = done; i < walk->walk.steps.size(); ++i) {
      const hal::Foot foot = walk->walk.steps[i].foot;
      layers.feet.push_back({walk->walk.stances[i].at(foot), foot, false});
      if (i % 2 == 0) layers.bodies.push_back(walk->walk.bases[i]);
    }
  }
  FloorPictureConfig config;
  config.title = title;
  return floor_picture(mapper.floor(), layers, config);
}

void SimOutputs::write(const SimOutcome& outcome, OutputFolder& folder) {
  const runtime::Mapper& mapper = session_.mapper();
  const auto save = [&](const std::string& name, const cv::Mat& image) {
    write_png(image, folder.file(name + ".png"));
  };
  for (const auto* kept : {&pictures_, &replan_})
    for (const Picture& picture : *kept) save(picture.name, picture.image);
  save("scene", scene_picture(session_.scene()));
  if (!views_.empty()) {
    std::vector<Captioned> captioned;
    for (std::size_t i = 0; i < views_.size(); ++i) captioned.push_back({views_[i], captions_[i]});
    save("views", strip(captioned));
  }
  FloorLayers layers = this->layers();
  layers.believed_trail = positions(session_.trail().believed);
  layers.obstacles = outlines(session_.scene());
  layers.robot = session_.body().stance().base();
  if (outcome.collision) layers.collisions.push_back(layers.robot->position());
  FloorPictureConfig floor_config;
  floor_config.title = fmt::format("{}: {}", session_.scene().world().name, outcome.end);
  save("floor", floor_picture(mapper.floor(), layers, floor_config));
  const MapViewConfig view =
      room_view(fmt::format("the map of {} after the walk", session_.scene().world().name));
  MapFigures figures;
  figures.robot = layers.robot;
  figures.goal = session_.goal().position;
  figures.feet = layers.feet;
  figures.gait = layers.gait;
  const nav::ColdMap known = mapper.everything();
  nav::VoxelMapConfig window = mapper.voxels().config();
  window.lowest = mapper.voxels().lowest();
  window.highest = mapper.voxels().highest();
  const nav::VoxelMap whole = whole_map_within(known, window, kMostShown);
  save("map", map_view(whole, bird_view(whole, view), view, figures));

  nav::write_bt(known, folder.file("map.bt"));
  runtime::write_durably(folder.file("map.hmap"), [&](std::ostream& out) {
    nav::write_map_file(known, session_.frame_loop().localisation().surfaces(), out);
  });
  write_floor(mapper.floor(), folder);
  cloud_.write(folder.file("cloud.ply"));
  write_json(folder.file("timing.json"), {{"wall_s", rounded(wall_.lap_ms() / 1e3, 2)},
                                          {"frames", total_ms_.size()},
                                          {"late", session_.frame_loop().counters().late},
                                          {"see", spread(see_ms_)},
                                          {"map", spread(map_ms_)},
                                          {"floor", spread(floor_ms_)},
                                          {"plan", spread(plan_ms_)},
                                          {"total", spread(total_ms_)},
                                          {"walk", walk_cost_report(walk_cost_.stretches())}});
  folder.report(sim_report(session_, outcome));
}

}  // namespace headway::app
