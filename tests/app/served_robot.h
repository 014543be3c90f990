// A simulated robot in an empty room with an operator's desk.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "app/operator_desk.h"
#include "app/sim_session.h"
#include "tests/source_dir/source_dir.h"

namespace headway::app {

constexpr std::uint64_t kSomebody = 7, kOther = 8;

inline sim::World room() {
  sim::World world;
  world.name = "room";
  sim::add_room(world, {0.5, 0}, {5, 4}, 2.2, 0);
  world.start = {-0.8, 0, 0};
  return world;
}

/// A robot in an empty room, its desk, and the time.
struct Served {
  Served() : desk(session.robot(), session.mapper().floor().grid, room().start, session.line()) {
    session.observe([this](const runtime::FrameSnapshot& snapshot) { desk.see(snapshot); });
    desk.on_preview([this](const std::vector<Pose2>& way) { shown = way; });
  }
  static SimOptions options() {
    SimOptions options;
    options.range_mode = true;
    options.waits = true;
    return options;
  }

  void pass(double time) {
    const Time end = session.now() + seconds(time);
    const SimOutcome outcome = session.run_while([&] {
      desk.attend(session.status(), session.now());
      return session.now() < end;
    });
    ASSERT_EQ(outcome.end, "ended") << outcome.reason;
  }
  /// Up to `longest` seconds.
  template <class Done>
  bool pass_until(const Done& done, double longest = 60) {
    const Time end = session.now() + seconds(longest);
    session.run_while([&] {
      desk.attend(session.status(), session.now());
      return !done() && session.now() < end;
    });
    return done();
  }
  bool pass_until(runtime::MissionState state) {
    return pass_until([&] { return session.status().state == state; });
  }
  Json ask(const char* service, const Json& body = Json::object(), std::uint64_t client = kSomebody) {
    return Json::parse(desk.answer(client, service, body.dump(), session.status(), session.now()));
  }
  std::string refusal(const char* service, const Json& body = Json::object(),
                      std::uint64_t client = kSomebody) {
    const Json answer = ask(service, body, client);
    return answer.at("ok").get<bool>() ? "it was done" : answer.at("error").get<std::string>();
  }
  remote::OperatorStatus status() const {
    remote::OperatorStatus out;
    desk.fill(out, session.status());
    return out;
  }
  double distance(double x, double y) const {
    return (session.body().stance().base().position() - Eigen::Vector2d(x, y)).norm();
  }

  SimSession session{read_robot(source_dir() / "config/hrp2/robot.yaml"), room(), options()};
  OperatorDesk desk;
  std::vector<Pose2> shown;
};

}  // namespace headway::app
