// A walk before it is walked: steps are run through the walking pattern, to see how far the ZMP stays inside
// the soles and where the waist goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "nav/walking/support_polygon.h"
#include "nav/walking/walking_pattern.h"

namespace headway::nav {

struct Forecast {
  /// Of the model's ZMP inside the support polygon, at its least [m]; negative: outside; infinity: the robot
  /// stays where it is.
  double margin = 0;
  std::optional<std::size_t> step;  ///< under way at that moment; nothing while the robot comes to rest
};

/// Why such a walk should not be walked, for people: no forecast (a step was not taken), or a margin less
/// than `required` [m]. Empty when it may.
std::string complaint(const std::optional<Forecast>& forecast, double required);

/// Follows the steps that are committed and foresees those that are planned after them. Frames as those of
/// the stance.
class WalkForecaster {
 public:
  /// Soles of `sole_length` x `sole_width` [m], centred on the feet. Throws InputError as
  /// WalkingConfig::validate.
  WalkForecaster(const WalkingConfig& config, double sole_length, double sole_width);

  /// The robot rests on both feet.
  void rest_at(const hal::Stance& stance) noexcept { pattern_.stand_at(stance); }
  /// A step that will be walked. False, and nothing done, for one that the pattern does not take.
  [[nodiscard]] bool commit(const hal::Footstep& step) noexcept;

  /// The walk from now on over the committed steps and `steps` to rest. `visit` gets the WalkingSample of
  /// each period (com and yaw tell where the waist is) and how far the ZMP is inside the support polygon [m].
  /// Nothing when the pattern does not take one of the steps.
  template <class Visit>
  std::optional<Forecast> foresee(std::span<const hal::Footstep> steps, const Visit& visit) const {
    Run run(*this, steps);
    while (const WalkingSample* sample = run.tick()) visit(*sample, run.margin());
    return run.result();
  }
  std::optional<Forecast> foresee(std::span<const hal::Footstep> steps) const {
    return foresee(steps, [](const WalkingSample&, double) {});
  }

 private:
  class Run {
   public:
    Run(const WalkForecaster& from, std::span<const hal::Footstep> steps);
    /// The next period; nothing when the robot rests, or a step was not taken.
    const WalkingSample* tick();
    double margin() const { return margin_; }
    std::optional<Forecast> result() const;

   private:
    bool feed();
    void judge(const WalkingSample& sample);

    WalkingPattern pattern_;
    std::span<const hal::Footstep> steps_;
    double sole_length_, sole_width_;
    std::uint32_t before_;  ///< steps committed by then
    std::size_t fed_ = 0;
    bool refused_ = false;
    double margin_ = 0;
    Forecast worst_;
  };

  WalkingPattern pattern_;
  double sole_length_, sole_width_;
};

}  // namespace headway::nav
