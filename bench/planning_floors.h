// Real floors for the planning benchmark: SBPL's environments of (x, y, theta), pooled to half their
// resolution.
#pragma once

#include <string>

#include "nav/floor_map.h"

namespace headway::bench {

/// NAME.cfg in the folder `maps` of HEADWAY_DATA, or else the only file in NAME.zip there. Of each 2x2 cells
/// at least one blocked makes a cell blocked. Throws Error when it is missing or malformed.
nav::FloorMap read_floor(const std::string& name);

}  // namespace headway::bench
