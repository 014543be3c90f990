// How far the samples of a range image err, whatever their sigma claims.
#pragma once

#include "nav/ring_image.h"

namespace headway::nav {

/// What samples `w` [1/m] err by, as a share of `sigma` [1/m], 0 to 1. Sigma is one pixel's; a mean over
/// pixels errs less, by how much depends on what neighbours err by together, and no sensor tells that.
///
/// Second differences of samples `apart` from one another are zero on planes, whatever their slope; elsewhere
/// they hold the errors of three samples. Those beyond two sigma reach across an edge and do not count; of
/// the others the lower quartile withstands corners and curved things, as the median absolute deviation does
/// (Hampel, "The influence curve and its role in robust estimation", 1974). Errors that samples farther apart
/// than `apart` have in common stay hidden. Where too few are known, the usual share of matchers.
double sample_errors(const RingImage<float>& w, const RingImage<float>& sigma, int apart);

}  // namespace headway::nav
