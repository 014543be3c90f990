#include "app/moving_totals.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace headway::app {

void MovingTotals::add(const SimSession& session) {
  const ReactionCheck& check = session.reactions();
  ++runs_;
  replanned_ += !check.sightings().empty() && session.mission().counters().replans > 0;
  answering_ += std::any_of(check.reactions().begin(), check.reactions().end(),
                            [](const ReactionCheck::Reaction& r) { return !r.left; });
  threats_ += session.mission().counters().threats;
  outside_mask_ += session.body_mask().outside();
  farthest_ = std::max(farthest_, session.body_mask().farthest());
  for (const ReactionCheck::Sighting& seen : check.sightings()) {
    warnings_.push_back(seen.warning);
    late_ += seen.warning < kStopping;
  }
  const double period = 1 / session.robot().simulation.frame_rate;
  for (const ReactionCheck::Reaction& r : check.reactions()) {
    left_ += r.left;
    if (r.left) continue;
    frame_periods_.push_back(to_seconds(r.handed - r.shown) / period);
    stops_ += r.stopped;
  }
}

double MovingTotals::replanned_share() const { return runs_ ? static_cast<double>(replanned_) / runs_ : 0; }

/// The smallest of the latencies that this share of them does not exceed.
double MovingTotals::latency(double share) const {
  if (frame_periods_.empty()) return 0;
  std::vector<double> sorted = frame_periods_;
  std::sort(sorted.begin(), sorted.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max<std::size_t>(rank, 1) - 1];
}

Json MovingTotals::report() const {
  return {
      {"replanned", replanned_},
      {"replanned_share", rounded(replanned_share(), 3)},
      {"answering", answering_},
      {"answers", frame_periods_.size()},
      {"answered_by_stop", stops_},
      {"left_by_itself", left_},
      {"frame_periods_p50", rounded(latency(0.5), 3)},
      {"frame_periods_p99", rounded(latency(0.99), 3)},
      {"frame_periods_max", rounded(latency(1), 3)},
      {"threats", threats_},
      {"seen", warnings_.size()},
      {"seen_late", late_},
      {"visible_to_contact_min_s",
       warnings_.empty() ? Json() : Json(rounded(*std::min_element(warnings_.begin(), warnings_.end()), 3))},
      {"outside_mask", outside_mask_},
      {"outside_mask_farthest_m", rounded(farthest_, 3)}};
}

std::string MovingTotals::line() const {
  return fmt::format(
      "moving things: {} seen, {} of them less than {} s before they could be touched; {} of {} robots saw "
      "one and replanned; {} had one on their steps, which they changed {} times in all ({} stops), after "
      "{:.2f} frame periods in 99 % of the cases; {} more times it left before; {} threats; true body "
      "outside "
      "its mask {} times",
      warnings_.size(), late_, kStopping, replanned_, runs_, answering_, frame_periods_.size(), stops_,
      latency(0.99), left_, threats_, outside_mask_);
}

bool MovingTotals::good() const {
  return replanned_share() >= 0.5 && latency(0.99) <= 1 && late_ == 0 && outside_mask_ == 0;
}

}  // namespace headway::app
