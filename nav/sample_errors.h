// How far the samples of a range image err, whatever their sigma claims.
#pragma once

#include "nav/ring_image.h"

namespace headway::nav {

/// What samples `w` [1/m] err by, as a share of `sigma` [1/m], 0 to 1. Sigma is one pixel's; means over
/// pixels err less, and how much less depends on the errors that neighbours share, which no sensor tells.
///
/// Second differences of samples `apart` from one another are zero on planes, whatever their slope; elsewhere
/// they hold the errors of three samples. Those of more than five sigma of a sample reach across an edge and
/// do not count; of the others the lower quartile withstands corners and curved things, as the median
/// absolute deviation does (Hampel, "The influence curve and its role in robust estimation", 1974). Samples
/// must be too far apart to share pixels; errors that reach farther than `apart` stay hidden. 0 where too few
/// are known.
double sample_errors(const RingImage<float>& w, const RingImage<float>& sigma, int apart);

}  // namespace headway::nav
