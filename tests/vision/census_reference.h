// The census matcher by its definitions, one pixel and one disparity at a time: the oracle of the fast one.
#pragma once

#include "vision/census_matcher.h"

namespace headway::vision::test {

/// What CensusMatcher must give, to the bit.
DisparityImage census_reference(const hal::GrayImage& left, const hal::GrayImage& right, DisparityRange range,
                                const CensusConfig& config);

}  // namespace headway::vision::test
