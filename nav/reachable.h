// Where the robot can get to at all.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "nav/floor_chunks.h"

namespace headway::nav {

/// For each cell (row-major) the headings in which it can be reached (bit h), from a cell and some headings
/// there.
std::vector<std::uint8_t> reachable_headings(const FloorChunks& floor, const Eigen::Vector2i& start,
                                             unsigned headings);

}  // namespace headway::nav
