// Any bytes as lines of an operator to the running program: what fuzzers and mutation tests say to it, and
// lines that it knows.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/live_control.h"
#include "app/live_session.h"
#include "hal/clock.h"
#include "tests/fuzz/any_bytes.h"
#include "tests/fuzz/heard_bus.h"
#include "tests/fuzz/promise.h"
#include "tests/shut_eyes.h"
#include "tests/source_dir/source_dir.h"

namespace headway::fuzz {

/// The program with a silent bus, before it is started.
class Listener {
 public:
  Listener() { clock_.set(at_seconds(100)); }

  /// What it says to each line, checked.
  void hear(std::string_view input) {
    AnyBytes bytes(input);
    app::LiveStatus status;
    const std::uint8_t how = bytes.byte();
    if (how & 1) status.stamp = clock_.now() - seconds(0.1);
    if (how & 2) status.base = {0.5, -0.25, 2};
    while (!bytes.empty()) look_at(app::answer(bytes.until('\n'), session(), status, clock_.now()), status);
    if (has_changed_) session_.reset();  // so that no input sees what another has left
    has_changed_ = false;
  }

 private:
  static constexpr double kFloor = 4;  ///< edge of the floor in use [m]

  app::LiveSession& session() {
    if (!session_)
      session_.emplace(robot_, app::LiveOptions{.start = {}, .floor = {kFloor, kFloor}, .goal = {}}, bus_,
                       eyes_, clock_);
    return *session_;
  }

  void look_at(const std::string& said, const app::LiveStatus& status) {
    promise(is_plain_text(said), "an answer is one line of plain text", said);
    const app::Json json = app::Json::parse(said, nullptr, false);
    promise(json.is_object() && json.contains("ok") && json["ok"].is_boolean(), "an answer says how it went",
            said);
    if (!json["ok"].get<bool>()) {
      const bool has_reason = json.contains("error") && json["error"].is_string();
      promise(has_reason && is_plain_text(json["error"].get<std::string>()) && !json["error"].empty(),
              "a refusal says why", said);
      return;
    }
    if (json.contains("state")) {
      promise(!app::status_text(json).empty() && !app::status_metrics(json).empty(), "a status can be shown",
              said);
      return;
    }
    has_changed_ = true;
    if (!json.contains("x")) return;
    promise(status.stamp != Time{}, "nobody is sent anywhere from a place that is not known", said);
    promise(
        std::abs(json["x"].get<double>()) <= kFloor / 2 && std::abs(json["y"].get<double>()) <= kFloor / 2,
        "goals lie on the floor in use", said);
  }

  app::Robot robot_ = app::read_robot(source_dir() / "config/hrp2/robot.yaml");
  hal::ManualClock clock_;
  HeardBus bus_;
  test::ShutEyes eyes_;
  std::optional<app::LiveSession> session_;
  bool has_changed_ = false;
};

inline void answer_lines(std::string_view input) {
  static Listener listener;
  listener.hear(input);
}

inline std::vector<std::string> whole_commands() {
  return {
      "\x01{\"do\": \"status\"}\n{\"do\": \"stay\"}\n{\"do\": \"reset\"}\n",
      "\x03{\"do\": \"go\", \"to\": [0.5, -1], \"yaw_deg\": 90, \"near\": true, \"from\": \"map\"}\n"
      "{\"do\": \"go\", \"to\": [1e0, 0.25], \"from\": \"robot\"}\n",
      "\x02{\"do\": \"go\", \"to\": [1, 1]}\n{\"do\": \"dance\"}\n[]\ngo on\n",
      "\x01{\"do\": \"go\", \"to\": [1e999, null], \"near\": 1}\n{\"do\": {\"\\u0000\": \"\\ud800\"}}\n",
  };
}

}  // namespace headway::fuzz
