// Which known word somebody may have meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace headway::config {

/// The least number of letters put in, left out, changed or exchanged with their neighbour that makes one
/// word the other (optimal string alignment).
std::size_t letters_apart(std::string_view one, std::string_view other);

/// The known word that is `word` but for capitals or for radians in place of degrees; else the one nearest to
/// it: at most two letters apart, and no more than a third of it; else one that begins with it, or it with
/// that, up to a _ or - (exposure, exposure_ms). Empty where there is none. Words that differ in a number
/// only (cam1, cam2) are never meant by each other. The first of several.
std::string meant_by(std::string_view word, const std::vector<std::string>& known);

}  // namespace headway::config
