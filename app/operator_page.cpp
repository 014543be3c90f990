#include "app/operator_page.h"

#include <utility>

#include "app/field_markers.h"
#include "app/recording_folder.h"
#include "app/safety_report.h"
#include "app/state_folder.h"

namespace headway::app {

namespace {

constexpr Duration kTellEvery = seconds(0.05);

remote::TelemetryConfig telemetry_config(const Robot& robot, const nav::FloorGrid& grid) {
  remote::TelemetryConfig config;
  config.resolution = robot.mapper.voxels.resolution;
  config.sole_length = robot.mission.gait.sole_length;
  config.sole_width = robot.mission.gait.sole_width;
  config.outline = robot.mission.outline;
  config.grid = grid;
  config.field = field_markers(robot.rig, robot.vision);
  return config;
}

remote::ServerConfig server_config(const ServeOptions& options, const Robot& robot) {
  remote::ServerConfig config;
  config.address = options.address;
  config.port = options.port;
  config.robot = robot.name;
  config.require_token = options.token;
  config.token_file =
      options.token_file.empty() ? state_folder() / "page_tokens" : std::filesystem::path(options.token_file);
  if (!options.tls_certificate.empty())
    config.tls = remote::TlsFiles{options.tls_certificate, options.tls_key};
  config.page = remote::page_files();
  return config;
}

double milliseconds(Duration time) { return 1e3 * to_seconds(time); }

}  // namespace

void add_serve_options(CLI::App& command, ServeOptions& options) {
  CLI::Option* serve =
      command.add_flag("--serve", options.serve, "Serve the operator's page; its address is printed");
  command.add_option("--port", options.port, "Port of the page; 0: any that is free")
      ->capture_default_str()
      ->needs(serve);
  command
      .add_option("--address", options.address,
                  "Address to listen at; any but a loopback's asks for the token")
      ->capture_default_str()
      ->needs(serve);
  command.add_flag("--token", options.token, "Ask for the token at a loopback address too")->needs(serve);
  command
      .add_option("--token-file", options.token_file,
                  "Where the page's tokens are kept; default: with the user's state")
      ->needs(serve);
  CLI::Option* certificate = command.add_option(
      "--tls-cert", options.tls_certificate, "Certificate (PEM) to serve the page with: https and wss only");
  CLI::Option* key = command.add_option("--tls-key", options.tls_key, "Its private key (PEM)");
  certificate->needs(serve)->needs(key)->type_name("FILE");
  key->needs(certificate)->type_name("FILE");
}

OperatorPage::OperatorPage(const ServeOptions& options, const Robot& robot, const nav::FloorGrid& grid,
                           const Pose2& home, runtime::OperatorLine& line, const hal::Clock& clock)
    : line_(line),
      clock_(clock),
      head_(robot.mission.head),
      desk_(robot, grid, home, line),
      telemetry_(telemetry_config(robot, grid)),
      server_(server_config(options, robot), telemetry_, clock) {
  desk_.on_preview([this](const std::vector<Pose2>& way) { telemetry_.preview(way); });
}

void OperatorPage::offer_recording(runtime::Recorder& recorder, const std::filesystem::path& folder) {
  recorder_ = &recorder;
  desk_.on_record(folder.string(), [&recorder, folder](bool on) {
    if (on) require_room_to_record(folder);
    recorder.record(on);
  });
}

void OperatorPage::see(const runtime::FrameSnapshot& snapshot) {
  exposure_ns_ = snapshot.stamp.exposure.time_since_epoch().count();
  telemetry_.see(snapshot);
  desk_.see(snapshot);
}

void OperatorPage::serve(const LiveStatus& status, const Beside& beside, Time now) {
  server_.serve([&](const remote::Ask& ask) {
    told_at_ = Time{};  // what came of it is shown at once
    if (first_)
      if (auto answered = first_(ask)) return *std::move(answered);
    return desk_.answer(ask.client, ask.service, ask.body, status, now);
  });
  desk_.attend(status, now);
  // By the clock that does not stand still when a recording does.
  const Time clock = clock_.now();
  if (clock - told_at_ < kTellEvery) return;
  told_at_ = clock;
  tell(status, beside, now);
}

void OperatorPage::tell(const LiveStatus& status, const Beside& beside, Time now) {
  const runtime::SafetyReport& safety = line_.safety();
  remote::OperatorStatus& out = status_;
  out.stamp_ns = now.time_since_epoch().count();
  ++out.number;
  out.state = name(status.state);
  out.reason = status.reason.data();
  out.safety = name(safety.state);
  out.safety_reason = describe(safety);
  out.x = status.base.x, out.y = status.base.y, out.yaw = status.base.yaw;
  out.pan = status.angles.pan, out.tilt = status.angles.tilt;
  out.pan_low = head_.lower.pan, out.pan_high = head_.upper.pan;
  out.tilt_low = head_.lower.tilt, out.tilt_high = head_.upper.tilt;
  out.at_rest = status.at_rest;
  out.has_goal = status.goal.has_value();
  out.goal_has_yaw = status.goal && status.goal->yaw;
  if (status.goal) {
    out.goal_x = status.goal->position.x();
    out.goal_y = status.goal->position.y();
    out.goal_yaw = status.goal->yaw.value_or(0);
  }
  out.head = text_of(status.head);
  out.control_computer = text_of(status.walker);
  out.frame_level = name(status.level);
  out.frames = status.frames.frames;
  out.frames_lost = status.frames.lost;
  out.frames_no_pose = status.frames.no_pose;
  out.frames_unusable = status.frames.unusable;
  out.frames_late = status.frames.late;
  out.see_ms = milliseconds(status.times.see), out.map_ms = milliseconds(status.times.map);
  out.floor_ms = milliseconds(status.times.floor), out.plan_ms = milliseconds(status.times.plan);
  const std::int64_t exposure = exposure_ns_;
  out.frame_age_ms = exposure == 0 ? -1 : 1e-6 * static_cast<double>(out.stamp_ns - exposure);
  out.bus_cycles = beside.bus_cycles, out.bus_missed = beside.bus_missed;
  out.bus_wake_max_us = 1e6 * to_seconds(beside.bus_wake_max);
  out.plans = static_cast<std::uint32_t>(status.mission.plans);
  out.replans = static_cast<std::uint32_t>(status.mission.replans);
  out.simulated = beside.simulated;
  out.speed = beside.speed;
  if (runtime::RecordingState recording; recorder_ && recorder_->look(recording)) desk_.recording(recording);
  desk_.fill(out, status);
  // What was stopped is given up, unless it is only paused.
  if (status.state == runtime::MissionState::kStopped && !out.paused) out.has_goal = false;
  if (beside.played) {
    const Beside::Played& played = *beside.played;
    const auto s = [](Time t) { return to_seconds(t.time_since_epoch()); };
    out.recording_name = played.name;
    out.played_at = s(played.at), out.played_from = s(played.from), out.played_to = s(played.to);
    out.played_speed = played.speed, out.played_paused = played.paused;
    out.next = "a recording is played; no robot is moved";
  }
  const auto holder = server_.holder();
  out.lease_holder = holder.name;
  out.lease = holder.number;
  out.clients = server_.figures().clients;
  out.viewers = server_.viewers();
  telemetry_.tell(out);
  if (!beside.metrics.empty()) telemetry_.tell_metrics(beside.metrics);
}

}  // namespace headway::app
