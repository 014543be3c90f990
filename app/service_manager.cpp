#include "app/service_manager.h"

#include <cstdint>

#include <systemd/sd-daemon.h>

namespace headway::app {

ServiceManager::ServiceManager() {
  std::uint64_t longest = 0;  // [us]
  if (sd_watchdog_enabled(0, &longest) > 0) every_ = std::chrono::microseconds(longest / 2);
}

void ServiceManager::ready() const { sd_notify(0, "READY=1"); }

void ServiceManager::status(const std::string& line) const { sd_notify(0, ("STATUS=" + line).c_str()); }

void ServiceManager::alive(Time now) {
  if (!every_ || (told_ && now - *told_ < *every_)) return;
  told_ = now;
  sd_notify(0, "WATCHDOG=1");
}

void ServiceManager::stopping() const { sd_notify(0, "STOPPING=1"); }

}  // namespace headway::app
