// What a campaign with faults comes to.
#pragma once

#include <string>
#include <vector>

#include "app/fault_check.h"
#include "app/report.h"

namespace headway::app {

class FaultTotals {
 public:
  FaultTotals();

  void add(const FaultCheck& check);

  Json report() const;
  std::string table() const;  ///< for people
  /// Every fault that asks for a reaction got it, in time, and no step was committed after it.
  bool good() const;

 private:
  struct OfKind {
    int begun = 0, noticed = 0, asking = 0, late = 0, late_steps = 0;
    double notice = 0, reaction = 0;  ///< the worst [s]
  };
  std::vector<OfKind> kinds_;  ///< as sim::fault_kinds()
  int not_begun_ = 0;          ///< the run was over before
};

}  // namespace headway::app
