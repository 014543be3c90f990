#include "runtime/live_loops.h"

#include <fmt/format.h>

namespace headway::runtime {

void LiveLoops::start() {
  bus_round_ = frame_round_ = clock_.now();
  bus_cycle_ = std::make_unique<Cycle>(config_.period, config_.missed);
  bus_thread_ = std::make_unique<Thread>(
      ThreadId::kBus, [this](const auto& stop) { run_bus(stop); }, config_.real_time);
  frame_thread_ = std::make_unique<Thread>(
      ThreadId::kFrames, [this](const auto& stop) { run_frames(stop); }, config_.real_time);
}

void LiveLoops::run_bus(const std::atomic<bool>& stop) {
  const PageFaults before = page_faults();
  std::optional<Time> give_up;
  while (!(stop && (at_rest_ || (give_up && clock_.now() >= *give_up)))) {
    clock_.sleep_until(bus_cycle_->due());
    const Time now = clock_.now();
    bus_round_ = now;
    if (stop && !give_up) {
      bus_.come_to_rest();
      give_up = now + config_.rest_within;
    }
    bus_.cycle(now, bus_cycle_->begin(now));
    at_rest_ = bus_.committed().at_rest;
    bus_cycle_->end(clock_.now());
  }
  bus_faults_ = page_faults() - before;
}

void LiveLoops::run_frames(const std::atomic<bool>& stop) {
  // However it ends, nothing more is planned.
  struct Rest {
    FrameLoop& frames;
    ~Rest() { frames.rest(); }
  } rest{frames_};
  while (!stop) {
    const Time now = clock_.now();
    frame_round_ = now;
    if (!frames_.work(now)) {
      clock_.sleep_until(clock_.now() + config_.look_every);
      continue;
    }
    frame_run_.add(clock_.now() - now);
    frames_.publish();
    if (updated_) updated_();
  }
}

bool LiveLoops::stop() noexcept {
  const Time asked = clock_.now();
  if (frame_thread_) frame_thread_->ask_to_stop();
  if (bus_thread_) bus_thread_->ask_to_stop();
  const bool rests =
      ends(bus_thread_.get(), asked + config_.rest_within + config_.bus_hangs) && bus_.stands();
  ends(frame_thread_.get(), asked + config_.frames_end_within);
  return rests;
}

/// True when the thread has ended, by then at the latest: what it used is the caller's again.
bool LiveLoops::ends(const Thread* thread, Time until) noexcept {
  if (thread == nullptr) return false;
  while (!thread->ended() && clock_.now() < until) clock_.sleep_until(clock_.now() + config_.look_every);
  return thread->ended();
}

const char* LiveLoops::left_hanging() const noexcept {
  if (bus_thread_ && !bus_thread_->ended()) return "bus";
  return frame_thread_ && !frame_thread_->ended() ? "frame" : "";
}

LoopFigures LiveLoops::figures() const noexcept {
  LoopFigures figures;
  if (bus_cycle_) {
    figures.missed = bus_cycle_->missed();
    figures.bus_wake_up = bus_cycle_->wake_up_delay().spread();
    figures.bus_run = bus_cycle_->run_time().spread();
  }
  figures.frame_run = frame_run_.spread();
  if (bus_thread_ && bus_thread_->ended()) figures.bus_faults = bus_faults_;
  return figures;
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
