#include "nav/planner_config.h"

#include <string>

#include "hal/error.h"

namespace headway::nav {

namespace {

void expect(bool good, const std::string& key, double value, const std::string& expected) {
  if (!good) throw InputError("planner: " + key + ": is " + std::to_string(value) + ", expected " + expected);
}

}  // namespace

void PlannerConfig::validate() const {
  const auto within = [](double v, double lowest, double highest, const char* key, const char* unit = "") {
    expect(v >= lowest && v <= highest, key, v,
           std::to_string(lowest) + " to " + std::to_string(highest) + unit);
  };
  within(unseen_price, 0, 100, "unseen_price");
  within(corridor, 0, 1, "corridor", " m");
  within(near_price, 0, 100, "near_price");
  within(near_range, 0, 3, "near_range", " m");
  within(turn_price, 0, 100, "turn_price");
  within(mode_change, 0, 100, "mode_change", " s");
  within(ticks_per_cell, 1, 1000, "ticks_per_cell");
}

}  // namespace headway::nav
