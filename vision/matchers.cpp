#include "vision/matchers.h"

#include <algorithm>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::vision {

std::unique_ptr<Matcher> make_matcher(DisparityRange range, const MatcherConfig& config,
                                      hal::TwoProcessors& processors) {
  switch (config.kind) {
    case MatcherKind::kSgbm:
      return std::make_unique<SgbmMatcher>(range, config.sgbm);
    case MatcherKind::kBm:
      return std::make_unique<BmMatcher>(range, config.bm);
    case MatcherKind::kCensus:
      break;
  }
  return std::make_unique<CensusMatcher>(range, config.census, processors);
}

const std::vector<std::string>& matcher_names() {
  static const std::vector<std::string> names{"census", "sgbm", "bm"};
  return names;
}

MatcherKind matcher_kind(std::string_view name) {
  const auto& names = matcher_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw InputError(fmt::format("matcher: '{}', expected census, sgbm or bm", name));
  return static_cast<MatcherKind>(found - names.begin());
}

}  // namespace headway::vision
