#include "nav/walking/forecast.h"

#include <cstdio>
#include <limits>

namespace headway::nav {

std::string complaint(const std::optional<Forecast>& forecast, double required) {
  if (!forecast) return "the walking pattern does not take the planned steps";
  if (forecast->margin >= required) return {};
  const std::string when =
      forecast->step ? "in step " + std::to_string(*forecast->step + 1) : "while coming to rest";
  char line[160];
  std::snprintf(line, sizeof line,
                "the planned steps would tip the robot: %s the ZMP comes to %.0f mm from the sole's edge, "
                "expected %.0f mm or more",
                when.c_str(), 1e3 * forecast->margin, 1e3 * required);
  return line;
}

WalkForecaster::WalkForecaster(const WalkingConfig& config, double sole_length, double sole_width)
    : pattern_(config, hal::Stance{}), sole_length_(sole_length), sole_width_(sole_width) {}

/// The pattern is taken on to the moment at which the step that commits next has to be known.
bool WalkForecaster::commit(const hal::Footstep& step) noexcept {
  if (!pattern_.push(step)) return false;
  while (!pattern_.wants_step()) {
    pattern_.begin();
    pattern_.tick();
  }
  return true;
}

WalkForecaster::Run::Run(const WalkForecaster& from, std::span<const hal::Footstep> steps)
    : pattern_(from.pattern_),
      steps_(steps),
      sole_length_(from.sole_length_),
      sole_width_(from.sole_width_),
      before_(from.pattern_.pushed()),
      worst_{std::numeric_limits<double>::infinity(), std::nullopt} {}

bool WalkForecaster::Run::feed() {
  for (; fed_ < steps_.size() && pattern_.queue_free() > 0; ++fed_) {
    if (!pattern_.push(steps_[fed_])) return false;
  }
  return true;
}

const WalkingSample* WalkForecaster::Run::tick() {
  refused_ = refused_ || !feed();
  if (refused_) return nullptr;
  pattern_.begin();
  if (pattern_.phase() == WalkingPattern::Phase::kStanding) return nullptr;
  const WalkingSample& sample = pattern_.tick();
  judge(sample);
  return &sample;
}

void WalkForecaster::Run::judge(const WalkingSample& sample) {
  const SupportPolygon support =
      sample.support == Support::kBoth
          ? SupportPolygon(sample.left.pose, sample.right.pose, sole_length_, sole_width_)
          : SupportPolygon(sample.support == Support::kLeft ? sample.left.pose : sample.right.pose,
                           sole_length_, sole_width_);
  margin_ = support.margin(sample.zmp);
  if (margin_ >= worst_.margin) return;
  worst_ = {margin_, std::nullopt};
  if (pattern_.phase() != WalkingPattern::Phase::kWalking) return;
  const std::uint32_t under_way = pattern_.started();
  worst_.step = under_way > before_ ? under_way - before_ - 1 : 0;
}

std::optional<Forecast> WalkForecaster::Run::result() const {
  if (refused_) return std::nullopt;
  return worst_;
}

}  // namespace headway::nav
