// Kernels of Highway, run on each instruction set that was compiled and that this processor has.
#pragma once

#include <cstdint>

#include <hwy/targets.h>

namespace headway::test {

/// Calls `check(name)` once for each; then the best is chosen again.
template <class Check>
void on_every_target(const Check& check) {
  constexpr std::int64_t kPlain = HWY_SCALAR | HWY_EMU128;  // what every processor has
  for (std::int64_t left = HWY_TARGETS & (hwy::SupportedTargets() | kPlain); left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    hwy::GetChosenTarget().Update(target);
    check(hwy::TargetName(target));
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace headway::test
