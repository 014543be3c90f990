// What a campaign through moving worlds comes to.
#pragma once

#include <string>
#include <vector>

#include "app/report.h"
#include "app/sim_session.h"

namespace headway::app {

class MovingTotals {
 public:
  /// How long the robot takes to stand after it has noticed a cause, at most [s].
  static constexpr double kStopping = 2.7;

  void add(const SimSession& session);

  Json report() const;
  std::string line() const;  ///< for people
  bool good() const;

 private:
  double replanned_share() const;
  double latency(double share) const;

  int runs_ = 0, replanned_ = 0, answering_ = 0, threats_ = 0, late_ = 0, stops_ = 0, left_ = 0;
  std::uint64_t outside_mask_ = 0;
  double farthest_ = 0;                ///< [m]
  std::vector<double> warnings_;       ///< [s]
  std::vector<double> frame_periods_;  ///< from picture to changed steps
};

}  // namespace headway::app
