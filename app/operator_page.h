// The operator's page of a running program: server, desk, and what is shown, put together. Commands offer it
// with --serve.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "app/live_status.h"
#include "app/operator_desk.h"
#include "app/robot_file.h"
#include "operator/server.h"
#include "operator/telemetry.h"

namespace headway::app {

struct ServeOptions {
  bool serve = false;
  std::string address = "127.0.0.1";
  std::uint16_t port = 8760;
  bool token = false;                    ///< asked for even at a loopback address
  std::string token_file;                ///< empty: with the user's state
  std::string tls_certificate, tls_key;  ///< files; empty: nothing is encrypted
};
/// --serve, --port, --address, --token, --token-file, --tls-cert, --tls-key.
void add_serve_options(CLI::App& command, ServeOptions& options);

class OperatorPage {
 public:
  /// Listens. Throws InputError and Error as remote::Server. Line and clock must outlive it.
  OperatorPage(const ServeOptions& options, const Robot& robot, const nav::FloorGrid& grid, const Pose2& home,
               runtime::OperatorLine& line, const hal::Clock& clock);

  /// In the frame loop's thread.
  void see(const runtime::FrameSnapshot& snapshot);
  /// What comes next is another run.
  void begin_again() { telemetry_.begin_again(); }

  /// What the main loop knows beside the status.
  struct Beside {
    std::uint64_t bus_cycles = 0, bus_missed = 0;
    Duration bus_wake_max{};
    bool simulated = false;
    double speed = 1;     ///< of a simulation against real time
    std::string metrics;  ///< Prometheus' text; may be empty
    /// Of a recording that is played, in place of a robot.
    struct Played {
      std::string name;
      Time at{}, from{}, to{};
      double speed = 1;
      bool paused = false;
    };
    std::optional<Played> played;
  };
  /// In the main loop's thread, often: does what was asked for and shows how the robot is.
  void serve(const LiveStatus& status, const Beside& beside, Time now);

  OperatorDesk& desk() { return desk_; }
  /// The page begins and ends recordings, in the folder. The recorder must outlive it.
  void offer_recording(runtime::Recorder& recorder, const std::filesystem::path& folder);
  /// Answers in the desk's place; nothing: the desk does.
  using Answer = std::function<std::optional<std::string>(const remote::Ask&)>;
  void answer_first(Answer answer) { first_ = std::move(answer); }
  /// To be opened in a browser.
  std::string address() const { return server_.address_to_open(); }

 private:
  void tell(const LiveStatus& status, const Beside& beside, Time now);

  runtime::OperatorLine& line_;
  const hal::Clock& clock_;
  hal::HeadLimits head_;
  OperatorDesk desk_;
  remote::Telemetry telemetry_;
  remote::Server server_;
  std::atomic<std::int64_t> exposure_ns_{0};
  Time told_at_{};
  remote::OperatorStatus status_;
  Answer first_;
  runtime::Recorder* recorder_ = nullptr;
};

}  // namespace headway::app
