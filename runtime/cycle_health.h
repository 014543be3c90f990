// Whether the bus loop's cycles come in time.
#pragma once

#include <cstdint>

namespace headway::runtime {

enum class CycleHealth : std::uint8_t {
  kOnTime,   ///< none was missed lately
  kLate,     ///< some were, no more than is borne
  kFailing,  ///< more were
};

}  // namespace headway::runtime
