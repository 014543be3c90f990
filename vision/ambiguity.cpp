#include "vision/ambiguity.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/ambiguity.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace headway::vision::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

/// The pixels from column u on, as many as D has lanes; `lane` numbers these.
template <class D>
HWY_INLINE void write(D d, hn::Vec<D> lane, const FoundRow& row, const AmbiguityRules& rules, int u,
                      float* disparities, float* ambiguities) {
  const hn::RebindToSigned<D> whole;
  const auto bytes = [&](const std::uint8_t* from) HWY_ATTR {
    return hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(hn::Rebind<std::uint8_t, D>(), from + u)));
  };
  const auto found =
      hn::ConvertTo(d, hn::PromoteTo(whole, hn::LoadU(hn::Rebind<std::int16_t, D>(), row.disparity + u)));
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0F),
             none = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  const auto disparity = hn::Add(hn::Set(d, rules.lowest), hn::Mul(found, hn::Set(d, 1.0F / 16)));
  const auto partner = hn::Sub(hn::Add(lane, hn::Set(d, static_cast<float>(u))), disparity);
  const auto ratio = hn::Div(hn::Add(bytes(row.least), one), hn::Add(bytes(row.second), one));
  const auto disagree = hn::Gt(bytes(row.disagreement), hn::Set(d, static_cast<float>(rules.agreeing)));
  const auto doubt = hn::IfThenElse(disagree, hn::Set(d, rules.doubtful), hn::LoadU(d, row.alone + u));
  const auto ambiguity = hn::Max(ratio, doubt);
  const auto inside =
      hn::And(hn::Ge(partner, zero), hn::Le(partner, hn::Set(d, static_cast<float>(row.width - 1))));
  const auto clear = hn::And(hn::Ge(found, zero), hn::Le(ambiguity, hn::Set(d, rules.most_ambiguous)));
  const auto good = hn::And(inside, clear);
  hn::StoreU(hn::IfThenElse(good, disparity, none), d, disparities + u);
  hn::StoreU(hn::IfThenElse(good, ambiguity, none), d, ambiguities + u);
}

}  // namespace

void WriteMatches(const FoundRow& row, const AmbiguityRules& rules, float* disparities, float* ambiguities) {
  const hn::ScalableTag<float> d;
  const hn::CappedTag<float, 1> single;
  const auto lane = hn::Iota(d, 0);
  const int lanes = static_cast<int>(hn::Lanes(d));
  int u = 0;
  for (; u + lanes <= row.width; u += lanes) write(d, lane, row, rules, u, disparities, ambiguities);
  for (; u < row.width; ++u) write(single, hn::Zero(single), row, rules, u, disparities, ambiguities);
}

}  // namespace headway::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace headway::vision {

namespace {
HWY_EXPORT(WriteMatches);
}

void write_matches(const FoundRow& row, const AmbiguityRules& rules, float* disparities, float* ambiguities) {
  HWY_DYNAMIC_DISPATCH(WriteMatches)(row, rules, disparities, ambiguities);
}

}  // namespace headway::vision
#endif
