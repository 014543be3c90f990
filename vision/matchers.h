// The matchers there are, and the choice among them.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "vision/census_matcher.h"
#include "vision/opencv_matchers.h"

namespace headway::vision {

enum class MatcherKind {
  kCensus,  ///< our own
  kSgbm,    ///< OpenCV's semi-global matcher
  kBm,      ///< OpenCV's block matcher
};

struct MatcherConfig {
  MatcherKind kind = MatcherKind::kCensus;
  CensusConfig census;
  SgbmConfig sgbm;
  BmConfig bm;
};

/// Throws InputError where the chosen matcher refuses its configuration. The processors, which must outlive
/// it, are for those that can divide their work; what they find is the same.
std::unique_ptr<Matcher> make_matcher(DisparityRange range, const MatcherConfig& config,
                                      hal::TwoProcessors& processors = hal::one_processor());

/// Their names in files and on the command line, in the order of MatcherKind: "census", "sgbm", "bm".
const std::vector<std::string>& matcher_names();
/// Throws InputError for another name.
MatcherKind matcher_kind(std::string_view name);

}  // namespace headway::vision
