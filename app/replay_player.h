// Plays a recording to the operator's page by the clock of the wall: with a time line, to and fro.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "app/operator_page.h"
#include "app/replay_session.h"

namespace headway::app {

class ReplayPlayer {
 public:
  /// `first`: the first file of a recording. Throws as ReplaySession and OperatorPage.
  ReplayPlayer(std::filesystem::path first, const ServeOptions& options, hal::Clock& clock);

  std::string address() const { return page_->address(); }
  const OperatorPage::Beside::Played& played() const { return played_; }
  /// Until `asked_to_end` says so. Throws as ReplaySession::run.
  void play(const std::function<bool()>& asked_to_end);

  /// {"play": true or false, "speed": 0.1 to 20, "at": seconds}, each of them optional; the answer as
  /// OperatorDesk::answer. In the main loop's thread, as all of this.
  std::string steer(const std::string& body);

 private:
  struct Over {};   ///< thrown to leave the recording
  struct Again {};  ///< thrown to begin anew
  void begin();
  void go_through(const std::function<bool()>& asked_to_end);
  void before(Time at, const std::function<bool()>& asked_to_end);
  void serve();
  void find_span();

  std::filesystem::path first_;
  ServeOptions options_;
  hal::Clock& clock_;
  std::unique_ptr<ReplaySession> session_;
  std::unique_ptr<runtime::Links> unheard_;
  runtime::OperatorLine line_;
  std::optional<OperatorPage> page_;
  OperatorPage::Beside beside_;
  OperatorPage::Beside::Played& played_;
  std::optional<Time> wanted_;  ///< to be gone to as fast as it goes
  Time wall_{}, since_{};       ///< from when on it is played: the wall's clock, and the recording's
};

}  // namespace headway::app
