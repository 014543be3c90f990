// What systemd is told of a program that it started: that it is ready, how it is, that it lives
// (sd_notify(3)).
#pragma once

#include <optional>
#include <string>

#include "hal/time.h"

namespace headway::app {

/// Says nothing where no service manager asked for it.
class ServiceManager {
 public:
  ServiceManager();

  void ready() const;
  /// One line for `systemctl status`.
  void status(const std::string& line) const;
  /// To be called often while all goes on, by real time: told on at half of the time after which the manager
  /// would think it hung (WatchdogSec=).
  void alive(Time now);
  void stopping() const;

 private:
  std::optional<Duration> every_;  ///< nothing: it has no watchdog
  std::optional<Time> told_;
};

}  // namespace headway::app
