#include "app/fault_totals.h"

#include <algorithm>

#include <fmt/format.h>

namespace headway::app {

FaultTotals::FaultTotals() : kinds_(sim::fault_kinds().size()) {}

void FaultTotals::add(const FaultCheck& check) {
  for (const FaultCheck::Row& row : check.rows()) {
    if (!row.begun) {
      ++not_begun_;
      continue;
    }
    OfKind& of = kinds_[static_cast<std::size_t>(row.fault.kind)];
    ++of.begun;
    of.noticed += row.noticed.has_value();
    if (row.noticed) of.notice = std::max(of.notice, after(row, *row.noticed));
    of.asking += row.demand.has_value();
    if (row.demand && row.answered) of.reaction = std::max(of.reaction, after(row, *row.answered));
    of.late += is_late(row);
    of.late_steps += row.late_steps;
  }
}

Json FaultTotals::report() const {
  Json by_kind = Json::object();
  for (const sim::FaultTraits& kind : sim::fault_kinds()) {
    const OfKind& of = kinds_[static_cast<std::size_t>(kind.kind)];
    by_kind[std::string(kind.name)] = {
        {"begun", of.begun},
        {"noticed", of.noticed},
        {"notice_max_s", of.noticed ? rounded(of.notice, 3) : Json(nullptr)},
        {"asking", of.asking},
        {"reaction_max_s", of.asking ? rounded(of.reaction, 3) : Json(nullptr)},
        {"late", of.late},
        {"late_steps", of.late_steps}};
  }
  return {{"not_begun", not_begun_}, {"kinds", by_kind}};
}

std::string FaultTotals::table() const {
  std::string text = fmt::format("{:20} {:>6} {:>8} {:>12} {:>7} {:>13} {:>5} {:>10}\n", "fault", "begun",
                                 "noticed", "at worst [s]", "asking", "reaction [s]", "late", "late steps");
  for (const sim::FaultTraits& kind : sim::fault_kinds()) {
    const OfKind& of = kinds_[static_cast<std::size_t>(kind.kind)];
    if (of.begun == 0) continue;
    text += fmt::format("{:20} {:6} {:8} {:>12} {:7} {:>13} {:5} {:10}\n", kind.name, of.begun, of.noticed,
                        of.noticed ? fmt::format("{:.3f}", of.notice) : "-", of.asking,
                        of.asking ? fmt::format("{:.3f}", of.reaction) : "-", of.late, of.late_steps);
  }
  if (not_begun_ > 0) text += fmt::format("{} more did not begin: the run was over before\n", not_begun_);
  return text;
}

bool FaultTotals::good() const {
  return std::all_of(kinds_.begin(), kinds_.end(),
                     [](const OfKind& of) { return of.late == 0 && of.late_steps == 0; });
}

}  // namespace headway::app
