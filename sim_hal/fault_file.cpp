#include "sim_hal/fault_file.h"

#include <algorithm>
#include <string>
#include <vector>

namespace headway::sim {

using config::Range;
using config::Section;

namespace {

constexpr Range kTime{0, 36000, "s"};
constexpr std::size_t kMostFaults = 1000;  // more is a mistake

FaultKind kind_of(const Section& s) {
  std::vector<std::string> names;
  for (const FaultTraits& known : fault_kinds()) names.emplace_back(known.name);
  const std::string name = s.choice("kind", names);
  const auto found = std::find(names.begin(), names.end(), name);
  return fault_kinds()[static_cast<std::size_t>(found - names.begin())].kind;
}

/// What a kind does not read is no key of it, and refused by finish().
Fault fault(const Section& s) {
  Fault f;
  f.kind = kind_of(s);
  const FaultParameters& uses = traits(f.kind).uses;
  f.after = s.choice_or("after", "power_on", {"power_on", "first_step"}) == "power_on"
                ? FaultClock::kPowerOn
                : FaultClock::kFirstStep;
  f.begin = seconds(s.number("begin_s", kTime));
  if (uses.length) f.length = seconds(s.number("length_s", kTime));
  if (uses.share) f.share = s.number_or("share", f.share, {0, 1});
  if (uses.id && s.has("id")) f.id = static_cast<std::uint32_t>(s.integer("id", {0, 0x7ff}));
  if (uses.delay) f.delay = seconds(s.number("delay_s", {0, 60, "s"}));
  if (uses.noise) f.noise = s.number("noise", {0, 255, "grey levels"});
  if (uses.light) f.light = s.number("light", {0, 1});
  if (uses.jump) f.jump = seconds(s.number("jump_s", {-36000, 36000, "s"}));
  return f;
}

}  // namespace

FaultPlan faults_from(const Section& section) {
  FaultPlan plan;
  for (const Section& s : section.sections("faults")) plan.push_back(fault(s));
  section.finish();
  if (!section.has("faults")) section.fail("", "the key 'faults' is missing");
  if (plan.size() > kMostFaults)
    section.fail("faults",
                 std::to_string(plan.size()) + " of them, expected at most " + std::to_string(kMostFaults));
  return plan;
}

FaultPlan read_faults(const std::filesystem::path& file) {
  return faults_from(Section::load(file, "fault plan"));
}

}  // namespace headway::sim
