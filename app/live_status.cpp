#include "app/live_status.h"

#include <algorithm>

namespace headway::app {

const char* text_of(hal::HeadHealth health) {
  switch (health) {
    case hal::HeadHealth::kStarting:
      return "starting";
    case hal::HeadHealth::kReady:
      return "ready";
    case hal::HeadHealth::kDegraded:
      return "degraded: its position stays away";
    case hal::HeadHealth::kNotHomed:
      return "not homed: a drive does not know where its joint is";
    case hal::HeadHealth::kFault:
      return "at fault";
  }
  return "?";
}

const char* text_of(hal::WalkerHealth health) {
  switch (health) {
    case hal::WalkerHealth::kStarting:
      return "not heard yet";
    case hal::WalkerHealth::kReady:
      return "ready";
    case hal::WalkerHealth::kNoChest:
      return "without chest pose";
    case hal::WalkerHealth::kLost:
      return "lost";
  }
  return "?";
}

LiveStatus live_status(const runtime::FrameLoop& frames, const runtime::Mission& mission,
                       const runtime::BusReport& bus) {
  LiveStatus status;
  status.stamp = bus.stamp;
  status.state = mission.state();
  const std::string& reason = mission.reason();
  std::copy_n(reason.begin(), std::min(reason.size(), status.reason.size() - 1), status.reason.begin());
  status.base = frames.localisation().steady() * bus.committed.stance.base();
  status.head = bus.head.health;
  status.angles = bus.head.position;
  status.walker = bus.walker;
  status.level = frames.level();
  status.at_rest = bus.committed.at_rest;
  status.goal = mission.goal();
  status.short_of_goal = mission.short_of_goal();
  status.frames = frames.counters();
  status.mission = mission.counters();
  status.times = frames.times();
  return status;
}

}  // namespace headway::app
