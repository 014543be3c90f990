#include "drivers/stereo_pair.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::drivers {

namespace {

using hal::CameraState;
using Frames = std::span<const V4l2Camera::Waiting>;

constexpr Duration kMostApart = std::chrono::milliseconds(5);
constexpr int kPeriods = 3;

const StereoPairConfig& validated(const StereoPairConfig& config) {
  config.validate();
  return config;
}

Duration distance(Time a, Time b) noexcept { return a > b ? a - b : b - a; }

/// The place of the frame whose exposure is nearest to `t`; needs at least one.
std::size_t nearest(Frames frames, Time t) noexcept {
  const auto is_nearer = [t](const auto& a, const auto& b) {
    return distance(a.exposure, t) < distance(b.exposure, t);
  };
  return static_cast<std::size_t>(std::min_element(frames.begin(), frames.end(), is_nearer) - frames.begin());
}

}  // namespace

void StereoPairConfig::validate() const {
  left.validate();
  right.validate();
  const auto require = [&](bool fulfilled, const char* what) {
    if (!fulfilled) throw InputError(fmt::format("cameras {} and {}: {}", left.path, right.path, what));
  };
  require(left.path != right.path, "one device for both eyes, expected two");
  require(left.format != PixelFormat::kZ16 && right.format != PixelFormat::kZ16,
          "Z16 is a depth camera's format, expected one of images");
  require(left.width == right.width && left.height == right.height, "sizes differ, expected the same");
  require(left.rate == right.rate, "rates differ, expected the same");
  require(
      left.exposure == right.exposure && left.gain == right.gain && left.white_balance == right.white_balance,
      "exposure, gain or white balance differ, expected the same, or one eye's image is brighter");
  require(!tolerance || (*tolerance > Duration::zero() && *tolerance <= seconds(1)),
          "tolerance, expected more than 0, up to 1 s");
}

StereoPair::StereoPair(const StereoPairConfig& config, const hal::Clock& clock, DeviceCalls& calls)
    : clock_(clock),
      left_(validated(config).left, clock, calls),
      right_(config.right, clock, calls),
      tolerance_(config.tolerance.value_or(std::min(left_.period() / 4, kMostApart))),
      paired_at_(clock.now()) {}

bool StereoPair::take_newest(hal::StereoFrame& into) {
  left_.poll();
  right_.poll();
  bool is_taken = false;
  if (const std::optional<Match> match = newest_match()) {
    drop(left_, right_, match->left);
    drop(right_, left_, match->right);
    is_taken = hand_over(into);
  }
  drop_hopeless();
  judge(clock_.now());
  return is_taken;
}

std::optional<StereoPair::Match> StereoPair::newest_match() const noexcept {
  const Frames left = left_.waiting(), right = right_.waiting();
  if (right.empty()) return std::nullopt;
  for (std::size_t i = left.size(); i-- > 0;) {
    const std::size_t j = nearest(right, left[i].exposure);
    if (distance(left[i].exposure, right[j].exposure) <= tolerance_) return Match{i, j};
  }
  return std::nullopt;
}

/// The eye's oldest frames, which come before the pair that is taken.
void StereoPair::drop(V4l2Camera& eye, const V4l2Camera& other, std::size_t count) noexcept {
  for (; count > 0 && !eye.waiting().empty(); --count) {
    const Time exposure = eye.waiting().front().exposure;
    const bool is_left = &eye == &left_;
    if (!other.waiting().empty()) {
      const Time partner = other.waiting()[nearest(other.waiting(), exposure)].exposure;
      const bool is_pair = distance(partner, exposure) <= tolerance_;
      const Duration difference = is_left ? partner - exposure : exposure - partner;
      if (!is_pair) {
        ++stats_.unpaired;
        record(difference);
      } else if (is_left) {  // once for both
        count_pair(exposure, difference);
      }
    }
    eye.skip();
  }
}

/// Frames come in order: when the other eye has one from later than any partner could be, none will come.
void StereoPair::drop_hopeless() noexcept {
  const auto drop_before = [this](V4l2Camera& eye, const V4l2Camera& other) {
    while (!eye.waiting().empty() && !other.waiting().empty() &&
           other.waiting().back().exposure > eye.waiting().front().exposure + tolerance_)
      drop(eye, other, 1);
  };
  drop_before(left_, right_);
  drop_before(right_, left_);
}

void StereoPair::record(Duration difference) noexcept {
  constexpr auto kMiddle = static_cast<Duration::rep>(PairStats::kBins / 2);
  Duration::rep bin = difference / PairStats::kBinWidth;
  if (difference < Duration::zero() && difference % PairStats::kBinWidth != Duration::zero()) --bin;
  bin = std::clamp<Duration::rep>(bin, -kMiddle, kMiddle - 1);
  ++stats_.differences[static_cast<std::size_t>(bin + kMiddle)];
}

void StereoPair::count_pair(Time left, Duration difference) noexcept {
  exposures_[stats_.pairs % exposures_.size()] = left;
  ++stats_.pairs;
  paired_at_ = clock_.now();
  record(difference);
}

/// The oldest frame of each eye, which are a pair unless an eye failed just now.
bool StereoPair::hand_over(hal::StereoFrame& into) {
  if (left_.waiting().empty() || right_.waiting().empty()) return false;
  const V4l2Camera::Waiting left = left_.waiting().front(), right = right_.waiting().front();
  const Duration difference = right.exposure - left.exposure;
  spare_.exposure = left.exposure + difference / 2;
  spare_.sequence = left.sequence;
  count_pair(left.exposure, difference);
  const bool has_left = left_.take(spare_.left), has_right = right_.take(spare_.right);
  if (!has_left || !has_right) return false;
  std::swap(into, spare_);
  return true;
}

void StereoPair::judge(Time now) noexcept {
  const CameraState left = left_.stats().state, right = right_.stats().state;
  state_ = left != CameraState::kStreaming ? left : right;
  if (state_ != CameraState::kStreaming)
    paired_at_ = now;
  else if (now - paired_at_ > kPeriods * left_.period())
    state_ = CameraState::kUnpaired;
}

double StereoPair::rate(Time now) const noexcept {
  const auto is_recent = [now](Time t) { return t > Time{} && t > now - seconds(1) && t <= now; };
  return static_cast<double>(std::count_if(exposures_.begin(), exposures_.end(), is_recent));
}

}  // namespace headway::drivers
