#include "runtime/live_loops.h"

#include <fmt/format.h>

namespace headway::runtime {

void LiveLoops::start() {
  bus_round_ = frame_round_ = clock_.now();
  bus_thread_ = std::make_unique<Thread>(ThreadId::kBus, [this](const auto& stop) { run_bus(stop); });
  frame_thread_ = std::make_unique<Thread>(ThreadId::kFrames, [this](const auto& stop) { run_frames(stop); });
}

/// Cycles at fixed times from the first one: a late cycle does not shift those after it.
void LiveLoops::run_bus(const std::atomic<bool>& stop) {
  Time next = clock_.now();
  std::optional<Time> give_up;
  while (!(stop && (at_rest_ || (give_up && clock_.now() >= *give_up)))) {
    clock_.sleep_until(next);
    const Time now = clock_.now();
    bus_round_ = now;
    bus_.cycle(now);
    at_rest_ = bus_.committed().at_rest;
    if (stop && !give_up) give_up = now + config_.rest_within;
    next += config_.period;
    if (next <= now) next += ((now - next) / config_.period + 1) * config_.period;
  }
}

void LiveLoops::run_frames(const std::atomic<bool>& stop) {
  // However it ends, nothing more is planned.
  struct Rest {
    FrameLoop& frames;
    ~Rest() { frames.rest(); }
  } rest{frames_};
  while (!stop) {
    frame_round_ = clock_.now();
    if (!frames_.work(clock_.now())) {
      clock_.sleep_until(clock_.now() + config_.look_every);
      continue;
    }
    frames_.publish();
    if (updated_) updated_();
  }
}

bool LiveLoops::stop() noexcept {
  if (frame_thread_) frame_thread_->stop();
  if (bus_thread_) bus_thread_->stop();
  links_.report.update();
  const BusReport& last = links_.report.value();
  const bool heard = last.walker == hal::WalkerHealth::kReady || last.walker == hal::WalkerHealth::kNoChest;
  return at_rest_ && heard && last.walk.state == hal::WalkState::kStanding;
}

std::optional<std::string> LiveLoops::failure() const {
  for (const auto* thread : {bus_thread_.get(), frame_thread_.get()})
    if (thread != nullptr && thread->ended() && !thread->failure().empty()) return thread->failure();
  return std::nullopt;
}

std::optional<std::string> LiveLoops::hanging(Time now) const {
  const auto look = [&](const std::unique_ptr<Thread>& thread, Time round, Duration longest,
                        const char* name) -> std::optional<std::string> {
    if (!thread || thread->ended() || now - round <= longest) return std::nullopt;
    return fmt::format("the {} loop has not gone round for {:.1f} s", name, to_seconds(now - round));
  };
  const auto bus = look(bus_thread_, bus_round_, config_.bus_hangs, "bus");
  return bus ? bus : look(frame_thread_, frame_round_, config_.frames_hang, "frame");
}

std::string LiveLoops::refusal() const { return bus_thread_ ? bus_thread_->refusal() : std::string(); }

}  // namespace headway::runtime
