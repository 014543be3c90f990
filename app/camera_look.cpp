#include "app/camera_look.h"

#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace headway::app {

namespace {

using drivers::PairStats, drivers::V4l2Camera;
using hal::CameraState;

constexpr Duration kPause = std::chrono::milliseconds(2);

/// Counts usable frames from the first one on.
class RateMeter {
 public:
  void see(const hal::CameraStats& stats, Time now) {
    if (!first_ && stats.usable > 0) first_ = {now, stats.usable};
    if (first_ && now > first_->at)
      rate_ = static_cast<double>(stats.usable - first_->usable) / to_seconds(now - first_->at);
  }
  double rate() const { return rate_; }

 private:
  struct First {
    Time at;
    std::uint64_t usable;
  };
  std::optional<First> first_;
  double rate_ = 0;
};

EyeLook eye_of(std::string name, const V4l2Camera& camera, const RateMeter& meter, hal::GrayImage image) {
  return {std::move(name), camera.config().path, camera.settings(), camera.stats(),
          meter.rate(),    std::move(image),     camera.fault()};
}

Duration bin_begin(std::size_t bin) {
  return (static_cast<Duration::rep>(bin) - static_cast<Duration::rep>(PairStats::kBins / 2)) *
         PairStats::kBinWidth;
}

/// The lower end of the inner bin in which half of what the inner ones hold is reached; none where most lies
/// in the outer two.
std::optional<Duration> median_of(const PairStats& stats) {
  const std::uint64_t all = stats.pairs + stats.unpaired;
  const std::uint64_t inner = all - stats.differences.front() - stats.differences.back();
  if (2 * inner <= all) return std::nullopt;
  std::size_t bin = 1;
  for (std::uint64_t sum = stats.differences[1]; 2 * sum < inner; sum += stats.differences[bin]) ++bin;
  return bin_begin(bin);
}

double milliseconds(Duration d) { return to_seconds(d) * 1e3; }

std::string text_of(const EyeLook& eye) {
  const auto& [layout, period, exposure] = eye.settings;
  const hal::CameraStats& s = eye.stats;
  std::string text =
      fmt::format("{} {}: {}; {} x {} px of {}", eye.name, eye.path, hal::text_of(s.state), layout.width,
                  layout.height, drivers::code_text(drivers::code_of(layout.format)));
  if (period) text += fmt::format(", {:.4g} frames/s", 1 / to_seconds(*period));
  text += exposure ? fmt::format(", exposure {:.1f} ms", milliseconds(*exposure)) : ", automatic exposure";
  text += fmt::format(
      "\n  {} usable frames, {:.1f} /s; {} lost, {} damaged, {} with a repeated stamp, {} with a wrong one\n",
      s.usable, eye.rate, s.lost, s.damaged, s.frozen, s.wrong_clock);
  if (!eye.fault.empty()) text += fmt::format("  {}\n", eye.fault);
  return text;
}

std::string text_of(const PairLook& pair) {
  const std::string gap =
      pair.exposure_gap ? fmt::format("the right eye's exposure comes {:+.1f} to {:+.1f} ms after the left's",
                                      milliseconds(*pair.exposure_gap),
                                      milliseconds(*pair.exposure_gap + PairStats::kBinWidth))
                        : "the eyes' exposures are more than 5 ms apart";
  return fmt::format("pair: {}; {} pairs, {:.0f} /s; {} frames without a partner within {:.1f} ms\n  {}\n",
                     hal::text_of(pair.state), pair.stats.pairs, pair.rate, pair.stats.unpaired,
                     milliseconds(pair.tolerance), gap);
}

Json json_of(const EyeLook& eye) {
  const hal::CameraStats& s = eye.stats;
  Json json{{"device", eye.path},
            {"state", hal::text_of(s.state)},
            {"width_px", eye.settings.layout.width},
            {"height_px", eye.settings.layout.height},
            {"format", drivers::code_text(drivers::code_of(eye.settings.layout.format))}};
  json["set_rate_hz"] = eye.settings.period ? rounded(1 / to_seconds(*eye.settings.period)) : Json();
  json["exposure_ms"] = eye.settings.exposure ? rounded(milliseconds(*eye.settings.exposure)) : Json();
  json["measured_rate_hz"] = rounded(eye.rate, 2);
  json["usable"] = s.usable;
  json["lost"] = s.lost;
  json["skipped"] = s.skipped;
  json["damaged"] = s.damaged;
  json["repeated_stamp"] = s.frozen;
  json["wrong_clock"] = s.wrong_clock;
  json["restarts"] = s.restarts;
  json["gone"] = s.gone;
  if (!eye.fault.empty()) json["fault"] = eye.fault;
  return json;
}

Json json_of(const PairLook& pair) {
  Json json{{"state", hal::text_of(pair.state)},
            {"pairs", pair.stats.pairs},
            {"unpaired", pair.stats.unpaired},
            {"rate_hz", rounded(pair.rate, 2)},
            {"tolerance_ms", rounded(milliseconds(pair.tolerance))},
            {"histogram_bin_ms", rounded(milliseconds(PairStats::kBinWidth))},
            {"histogram_first_bin_from_ms", rounded(milliseconds(bin_begin(0)))}};
  json["right_after_left_histogram"] = pair.stats.differences;
  return json;
}

CameraLook look_at_pair(const drivers::StereoPairConfig& config, Duration time, hal::Clock& clock,
                        drivers::DeviceCalls& calls, const std::function<bool()>& asked) {
  drivers::StereoPair pair(config, clock, calls);
  RateMeter left, right;
  hal::StereoFrame frame;
  for (const Time end = clock.now() + time; clock.now() < end && !asked();
       clock.sleep_until(clock.now() + kPause)) {
    pair.take_newest(frame);
    left.see(pair.left().stats(), clock.now());
    right.see(pair.right().stats(), clock.now());
  }
  return {{eye_of("left", pair.left(), left, std::move(frame.left)),
           eye_of("right", pair.right(), right, std::move(frame.right))},
          PairLook{pair.stats(), pair.state(), pair.rate(clock.now()), pair.tolerance(),
                   median_of(pair.stats())}};
}

}  // namespace

bool CameraLook::is_well() const {
  for (const EyeLook& eye : eyes) {
    if (eye.stats.state != CameraState::kStreaming || eye.image.pixels.empty()) return false;
  }
  // Eyes that nothing synchronises drift past each other, and make a pair now and then.
  return !pair || (pair->state == CameraState::kStreaming && pair->stats.pairs > pair->stats.unpaired);
}

CameraLook look_through(const drivers::V4l2CameraConfig& config, Duration time, hal::Clock& clock,
                        drivers::DeviceCalls& calls) {
  V4l2Camera camera(config, clock, calls);
  RateMeter meter;
  hal::GrayImage image, newest;
  for (const Time end = clock.now() + time; clock.now() < end; clock.sleep_until(clock.now() + kPause)) {
    camera.poll();
    meter.see(camera.stats(), clock.now());
    while (camera.waiting().size() > 1) camera.skip();
    if (!camera.waiting().empty() && camera.take(image)) std::swap(image, newest);
  }
  return {{eye_of("camera", camera, meter, std::move(newest))}, std::nullopt};
}

CameraLook look_through(const drivers::StereoPairConfig& config, Duration time, hal::Clock& clock,
                        drivers::DeviceCalls& calls, const std::function<bool()>& asked) {
  CameraLook look = look_at_pair(config, time, clock, calls, asked);
  for (EyeLook& eye : look.eyes) {
    if (asked()) break;
    if (!eye.image.pixels.empty() || eye.stats.state != CameraState::kStreaming) continue;
    const auto& alone = eye.name == "left" ? config.left : config.right;
    eye.image = look_through(alone, std::chrono::seconds(1), clock, calls).eyes.front().image;
  }
  return look;
}

std::string text_of(const CameraLook& look) {
  std::string text;
  for (const EyeLook& eye : look.eyes) text += text_of(eye);
  if (look.pair) text += text_of(*look.pair);
  return text;
}

Json json_of(const CameraLook& look) {
  Json json;
  for (const EyeLook& eye : look.eyes) json[eye.name] = json_of(eye);
  if (look.pair) json["pair"] = json_of(*look.pair);
  return json;
}

}  // namespace headway::app
