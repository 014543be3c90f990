#include "runtime/bus_tap.h"

#include "runtime/recorded_values.h"

namespace headway::runtime {

void BusTap::drain(const std::function<void(const Row&)>& visit,
                   const std::function<void(const BusReport&)>& watch) {
  const auto row = [&](Topic topic, std::uint32_t sequence, Time time, const auto& message) {
    bytes_.clear();
    recording::append_cdr(message, bytes_);
    visit({topic, sequence, time, bytes_});
  };
  CanRow can;
  while (can_.pop(can))
    row(can.sent ? Topic::kCanSent : Topic::kCanReceived, can.sequence, can.time,
        can_frame(can.frame, can.time));
  BusReport report;
  while (reports_.pop(report)) {
    row(Topic::kBus, report_number_++, report.stamp, to_recorded(report, false));
    watch(report);
  }
  StepRecord step;
  while (steps_.pop(step)) row(Topic::kSteps, step_number_++, step.committed, to_recorded(step));
}

void BusTap::count(recorded::Drops& drops) const {
  drops.can_frames = can_.dropped();
  drops.bus_reports = reports_.dropped();
  drops.steps = steps_.dropped();
}

}  // namespace headway::runtime
