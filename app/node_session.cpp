#include "app/node_session.h"

#include "vision/rectify.h"

namespace headway::app {

NodeSession::NodeSession(const Robot& robot, const sim::World& world, const SimulatedRobotOptions& options,
                         bool range_mode, Time begin)
    : scene_(world), body_(simulated_robot(robot, options), world.start, begin) {
  clock_.set(begin);
  if (range_mode) make_depth_camera(robot, options.seed);
  body_.on_exposure([this](Time t, const Eigen::Isometry3d& map_from_camera) {
    if (exposed_) exposed_(t, map_from_camera, scene_.state());
    if (depth_) depth_->expose(t, map_from_camera * depth_eyes_.left_from_view);
  });
  body_.on_touch([this](const sim::BodyBox& box, Time) { return touched(scene_, box); });
}

void NodeSession::make_depth_camera(const Robot& robot, std::uint64_t seed) {
  const vision::Rectifier rectifier(robot.rig);
  const auto model = simulated_depth(robot, rectifier.rig(), seed);
  depth_ = std::make_unique<sim::SimDepthCamera>(scene_, clock_, model);
  depth_eyes_ = app::depth_eyes(model, rectifier.rectified_from_left().inverse());
}

void NodeSession::catch_up(Time now) {
  while (clock_.now() + sim::SimRobot::kPeriod <= now) {
    clock_.advance(sim::SimRobot::kPeriod);
    scene_.advance(clock_.now(), body_.stance().base());
    body_.step(clock_.now());
  }
}

}  // namespace headway::app
