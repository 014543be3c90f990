#include "app/replay_player.h"

#include <algorithm>
#include <utility>

#include "config/yaml_limits.h"
#include "hal/error.h"

namespace headway::app {

namespace {

constexpr Duration kLook = seconds(0.01);  // between two looks at what the page asks
constexpr double kSlowest = 0.1, kFastest = 20;
constexpr double kLongest = 1e9;  // of a recording [s]

Time time_at(double s) { return Time(seconds(s)); }

std::string said(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

ReplayPlayer::ReplayPlayer(std::filesystem::path first, const ServeOptions& options, hal::Clock& clock)
    : first_(std::move(first)),
      options_(options),
      clock_(clock),
      unheard_(std::make_unique<runtime::Links>()),
      line_(*unheard_),
      played_(beside_.played.emplace()) {
  played_.name = first_.filename().string();
  beside_.simulated = true;
  find_span();
  begin();
  page_.emplace(options_, session_->robot(), session_->mapper().floor().grid, session_->setup().start, line_,
                clock_);
  page_->answer_first([this](const remote::Ask& ask) -> std::optional<std::string> {
    if (ask.service == "play") return steer(ask.body);
    return said({{"ok", false}, {"error", "this is a recording: no robot hears that"}});
  });
}

void ReplayPlayer::find_span() {
  played_.from = Time::max(), played_.to = Time::min();
  for (const std::filesystem::path& part : parts_of(first_)) {
    const recording::McapReader file(part);
    for (const recording::McapChunkIndex& chunk : file.chunks()) {
      played_.from = std::min(played_.from, chunk.first);
      played_.to = std::max(played_.to, chunk.last);
    }
  }
  if (played_.from > played_.to) throw InputError(first_.string() + ": holds no messages");
  played_.at = played_.from;
}

void ReplayPlayer::begin() {
  recording::McapReader first(first_);
  session_ = std::make_unique<ReplaySession>(first);
}

void ReplayPlayer::play(const std::function<bool()>& asked_to_end) {
  for (;;) {
    try {
      go_through(asked_to_end);
      played_.paused = true;
      while (!asked_to_end() && played_.paused && !wanted_) serve();
      if (asked_to_end()) return;
    } catch (const Over&) {
      return;
    } catch (const Again&) {
    }
    begin();
  }
}

void ReplayPlayer::go_through(const std::function<bool()>& asked_to_end) {
  page_->begin_again();
  session_->observe([this](const runtime::FrameSnapshot& snapshot) { page_->see(snapshot); });
  session_->before_each_work([&](Time at) { before(at, asked_to_end); });
  wall_ = clock_.now();
  since_ = played_.from;
  for (const std::filesystem::path& part : parts_of(first_)) {
    recording::McapReader file(part);
    session_->run(file);
  }
}

/// Waits for the moment of the work that comes next.
void ReplayPlayer::before(Time at, const std::function<bool()>& asked_to_end) {
  played_.at = at;
  for (;;) {
    if (asked_to_end()) throw Over();
    if (wanted_ && *wanted_ < at - seconds(1)) throw Again();
    if (wanted_ && *wanted_ > at) {
      wall_ = clock_.now(), since_ = at;
      page_->serve(session_->status(), beside_, at);
      return;
    }
    wanted_.reset();
    const Time due = wall_ + seconds(to_seconds(at - since_) / played_.speed);
    if (!played_.paused && clock_.now() >= due) break;
    serve();
    if (played_.paused) wall_ = clock_.now(), since_ = at;
  }
  page_->serve(session_->status(), beside_, at);
}

void ReplayPlayer::serve() {
  page_->serve(session_->status(), beside_, played_.at);
  clock_.sleep_until(clock_.now() + kLook);
}

std::string ReplayPlayer::steer(const std::string& body) try {
  const Json asked = Json::parse(body, nullptr, false);
  if (!asked.is_object()) throw InputError("expected a JSON object");
  for (const auto& [key, value] : asked.items()) {
    const double number = value.is_number() ? value.get<double>() : -1;
    if (key == "play" && value.is_boolean()) {
      played_.paused = !value.get<bool>();
    } else if (key == "speed" && number >= kSlowest && number <= kFastest) {
      wall_ = clock_.now(), since_ = played_.at;
      played_.speed = number;
    } else if (key == "at" && number >= 0) {
      wanted_ = std::clamp(time_at(std::min(number, kLongest)), played_.from, played_.to);
    } else {
      throw InputError(key + ": expected \"play\": true or false, \"speed\": 0.1 to 20, or \"at\": seconds");
    }
  }
  return said({{"ok", true}});
} catch (const std::exception& fault) {
  return said({{"ok", false}, {"error", config::one_line(fault.what())}});
}

}  // namespace headway::app
