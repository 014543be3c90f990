#include "drivers/v4l2_camera.h"

#include <algorithm>
#include <utility>

#include "drivers/depth_image.h"
#include "drivers/grey_image.h"
#include "drivers/v4l2_listing.h"
#include "hal/error.h"

namespace headway::drivers {

namespace {

using hal::CameraState;

constexpr int kPeriods = 3;
constexpr int kRestartsInVain = 2;
constexpr int kUndecodable = 3;

const V4l2CameraConfig& validated(const V4l2CameraConfig& config) {
  config.validate();
  return config;
}

/// Throws unless the camera streams.
V4l2Stream opened(DeviceCalls& calls, const V4l2CameraConfig& config) {
  V4l2Fault fault;
  std::optional<V4l2Stream> stream = V4l2Stream::open(calls, config, fault);
  if (stream) return std::move(*stream);
  std::string text = text_of(fault, config);
  if (fault.step == V4l2Fault::Step::kFormat || fault.step == V4l2Fault::Step::kRate)
    text += "; it offers " + one_line(offered_formats(calls, config.path.c_str()));
  if (fault.is_wrong_setting() || fault.step == V4l2Fault::Step::kOpen) throw InputError(text);
  throw Error(text);
}

FrameMeasure measure_of(const V4l2Settings& settings, const V4l2CameraConfig& config) {
  return {least_bytes(settings.layout), settings.exposure.value_or(Duration::zero()), config.readout};
}

}  // namespace

V4l2Camera::V4l2Camera(const V4l2CameraConfig& config, const hal::Clock& clock, DeviceCalls& calls)
    : config_(validated(config)),
      clock_(clock),
      calls_(calls),
      stream_(opened(calls, config_)),
      settings_(stream_->settings()),
      judge_(measure_of(settings_, config_)),
      good_at_(clock.now()),
      trouble_(CameraState::kSilent),
      retry_(config.retry) {}

void V4l2Camera::poll() noexcept {
  const Time now = clock_.now();
  if (!stream_ && retry_.is_due(now)) open_again(now);
  for (std::uint32_t i = 0; stream_ && i < V4l2Stream::kBuffers; ++i) {
    FilledBuffer buffer;
    const V4l2Stream::Taken taken = stream_->take(buffer);
    if (taken == V4l2Stream::Taken::kFailed) give_up(stream_->fault(), CameraState::kGone, now);
    if (taken != V4l2Stream::Taken::kFrame) break;
    buffer.stamp = clock_.at_monotonic(Time(buffer.stamp)).time_since_epoch();
    admit(buffer, clock_.now());  // not earlier: a frame that came just now must not lie in the future
  }
  if (stream_) watch(clock_.now());
}

void V4l2Camera::admit(const FilledBuffer& buffer, Time now) noexcept {
  const FrameVerdict verdict = judge_.judge(buffer, now);
  stats_.lost += verdict.lost;
  sequence_ += 1 + verdict.lost;
  if (verdict.kind == FrameKind::kUsable) return keep(buffer, verdict, now);
  count(verdict.kind);
  give_back(buffer);
}

void V4l2Camera::keep(const FilledBuffer& buffer, const FrameVerdict& verdict, Time now) noexcept {
  ++stats_.usable;
  good_at_ = now;
  is_first_ = false;
  restarts_in_vain_ = 0;
  has_worked_ = true;
  trouble_ = CameraState::kSilent;
  if (undecodable_ < kUndecodable) stats_.state = CameraState::kStreaming;
  if (waiting_count_ == kMostWaiting) skip();
  // Skipping may have found the device gone, and the buffer with it.
  if (stream_) waiting_[waiting_count_++] = {verdict.exposure, sequence_, buffer};
}

void V4l2Camera::count(FrameKind unusable) noexcept {
  switch (unusable) {
    case FrameKind::kUsable:
      return;
    case FrameKind::kDamaged:
      ++stats_.damaged;
      trouble_ = CameraState::kDamaged;
      return;
    case FrameKind::kFrozen:
      ++stats_.frozen;
      trouble_ = CameraState::kFrozen;
      return;
    case FrameKind::kWrongClock:
      ++stats_.wrong_clock;
      trouble_ = CameraState::kWrongClock;
      return;
  }
}

Duration V4l2Camera::patience() const noexcept {
  if (is_first_) return std::max(config_.first_frame, kPeriods * period());
  // In the dark an automatic exposure stretches the period, to four times and more with some cameras.
  constexpr Duration kAutomatic = std::chrono::milliseconds(500);
  return std::max(kPeriods * period(), settings_.exposure ? Duration::zero() : kAutomatic);
}

void V4l2Camera::watch(Time now) noexcept {
  if (now - good_at_ <= patience()) return;
  stats_.state = trouble_;
  if (restarts_in_vain_ == kRestartsInVain)
    return give_up({.step = V4l2Fault::Step::kSilence}, stats_.state, now);
  ++restarts_in_vain_;
  ++stats_.restarts;
  stats_.skipped += std::exchange(waiting_count_, 0);
  if (!stream_->restart()) return give_up(stream_->fault(), CameraState::kGone, now);
  judge_.forget_sequence();
  good_at_ = now;
  is_first_ = true;
  trouble_ = CameraState::kSilent;
}

void V4l2Camera::give_up(const V4l2Fault& fault, CameraState state, Time now) noexcept {
  fault_ = fault;
  stats_.state = state;
  ++stats_.gone;
  stats_.skipped += std::exchange(waiting_count_, 0);
  stream_.reset();
  has_worked_ ? retry_.begin(now) : retry_.failed(now);
}

void V4l2Camera::open_again(Time now) noexcept {
  V4l2Fault fault;
  if (std::optional<V4l2Stream> stream = V4l2Stream::open(calls_, config_, fault))
    return accept(std::move(*stream), now);
  retry_.failed(now);
  fault_ = fault;
  stats_.state =
      fault.is_wrong_setting() && fault.error == 0 ? CameraState::kWrongFormat : CameraState::kGone;
}

void V4l2Camera::accept(V4l2Stream stream, Time now) noexcept {
  stream_.emplace(std::move(stream));
  settings_ = stream_->settings();
  judge_.measure_by(measure_of(settings_, config_));
  judge_.forget_sequence();
  good_at_ = now;
  is_first_ = true;
  has_worked_ = false;
  restarts_in_vain_ = 0;
  trouble_ = CameraState::kSilent;
}

void V4l2Camera::give_back(const FilledBuffer& buffer) noexcept {
  if (!stream_->give_back(buffer)) give_up(stream_->fault(), CameraState::kGone, clock_.now());
}

V4l2Camera::Waiting V4l2Camera::pop() noexcept {
  const Waiting oldest = waiting_[0];
  std::copy(waiting_.begin() + 1, waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_),
            waiting_.begin());
  --waiting_count_;
  return oldest;
}

void V4l2Camera::skip() noexcept {
  ++stats_.skipped;
  give_back(pop().buffer);
}

template <class Read>
bool V4l2Camera::take_oldest(Read read) {
  const FilledBuffer buffer = pop().buffer;
  const bool is_read = read(stream_->data(buffer));
  if (is_read) {
    undecodable_ = 0;
    stats_.state = CameraState::kStreaming;
  } else {
    ++stats_.damaged;
    if (++undecodable_ >= kUndecodable) stats_.state = CameraState::kDamaged;
  }
  // Only now: the driver may fill it at once, and tear the image.
  give_back(buffer);
  return is_read;
}

bool V4l2Camera::take(hal::GrayImage& into) {
  const ImageLayout& layout = settings_.layout;
  return take_oldest([&](std::span<const std::uint8_t> data) {
    return layout.format == PixelFormat::kMjpeg ? jpeg_.decode(data, layout.width, layout.height, into)
                                                : copy_grey(data, layout, config_.y16_bits, into);
  });
}

bool V4l2Camera::take(hal::DepthFrame& into) {
  return take_oldest([&](std::span<const std::uint8_t> data) {
    return copy_depth(data, settings_.layout, config_.metres_per_count, into);
  });
}

std::string V4l2Camera::fault() const { return fault_ ? text_of(fault_, config_) : ""; }

}  // namespace headway::drivers
