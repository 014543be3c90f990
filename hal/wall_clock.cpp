#include "hal/wall_clock.h"

#include <ctime>

namespace headway::hal {

Duration wall_clock() noexcept {
  timespec ts{};
  clock_gettime(CLOCK_REALTIME, &ts);
  return std::chrono::seconds(ts.tv_sec) + Duration(ts.tv_nsec);
}

}  // namespace headway::hal
