// Rooms of the simulator, seen by a pair with 61 deg of view. The askew right camera is rendered for itself.
#include <cmath>
#include <stdexcept>

#include "hal/clock.h"
#include "hal/head_kinematics.h"
#include "sim_hal/random_world.h"
#include "sim_hal/scene.h"
#include "sim_hal/sim_camera.h"
#include "sim_hal/world_file.h"
#include "tests/source_dir/source_dir.h"
#include "tests/true_pairs/true_pairs.h"

namespace headway {

namespace {

constexpr double kFocal = 540, kBaseline = 0.144;  // [px], [m]
const sim::Lens kLens = sim::Lens::pinhole(640, 480, kFocal, 319.5, 239.5);

hal::StereoFrame taken(const sim::Scene& scene, const Eigen::Isometry3d& map_from_left, double lower) {
  sim::StereoCameraModel model;
  model.left = model.right = kLens;
  model.right.cy += lower;
  model.right_from_left.translation().x() = -kBaseline;
  hal::ManualClock clock;
  sim::SimStereoCamera camera(scene, clock, model);
  camera.expose(clock.now(), map_from_left);
  clock.advance(seconds(0.1));
  hal::StereoFrame frame;
  if (!camera.take_newest(frame)) throw std::runtime_error("the simulated camera gave no frame");
  return frame;
}

TruePair room_pair(const std::string& name, const sim::World& world) {
  const sim::Scene scene(world);
  Eigen::Isometry3d map_from_left = world.start.lifted(1.4);  // [m]
  map_from_left.linear() *= hal::body_from_optical(0.3);
  const hal::StereoFrame level = taken(scene, map_from_left, 0);
  TruePair pair{name, 0, level.left, level.right, taken(scene, map_from_left, 0.5).right, {}};
  pair.truth.resize(kLens.width, kLens.height);
  for (int v = 0; v < kLens.height; ++v)
    for (int u = 0; u < kLens.width; ++u) {
      const Eigen::Vector3d ray((u - kLens.cx) / kFocal, (v - kLens.cy) / kFocal, 1);
      const double z = scene.distance(map_from_left.translation(), map_from_left.linear() * ray) / ray.norm();
      if (std::isfinite(z))
        pair.truth.values[pair.truth.index(u, v)] = static_cast<float>(kFocal * kBaseline / z);
    }
  search_all(pair);
  leave_out_first_columns(pair);
  return pair;
}

}  // namespace

std::vector<TruePair> room_pairs() {
  const auto worlds = source_dir() / "config/worlds";
  return {room_pair("lab", sim::read_world(worlds / "lab.yaml")),
          room_pair("maze", sim::read_world(worlds / "maze.yaml")),
          room_pair("room_one", sim::random_world(1)), room_pair("room_two", sim::random_world(2))};
}

}  // namespace headway
