// The floor with what is drawn over it, as a vector graphic that can be enlarged at will.
#pragma once

#include <string>

#include "app/pictures.h"

namespace headway::app {

/// An SVG 1.1 document, 100 units a metre, y up: cells in rows, bodies, feet, path, waist, ZMP, start and
/// goal, each kind a group with its name as id. The whole grid.
std::string floor_svg(const nav::FloorMap& floor, const FloorLayers& layers, const std::string& title);

}  // namespace headway::app
