// Kernels of Highway held to one instruction set, so that the figures of two machines can be compared.
#pragma once

#include <cstdint>

#include <hwy/targets.h>

namespace headway::bench {

/// Highway's AVX2 kernels, or the best that this processor has below it. Returns the name.
inline const char* hold_to_avx2() {
  constexpr std::int64_t kBeyond = HWY_AVX3 | HWY_AVX3_DL;
  hwy::DisableTargets(kBeyond);
  const std::int64_t left = hwy::SupportedTargets();
  hwy::GetChosenTarget().Update(left);
  return hwy::TargetName(left & -left);  // the lowest bit is the best target
}

}  // namespace headway::bench
