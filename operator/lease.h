// Who has control of the robot: one at a time, as long as he renews it and sees what he does.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "hal/time.h"

namespace headway::remote {

class Lease {
 public:
  static constexpr Duration kGone = seconds(5);        ///< without a renewal
  static constexpr Duration kFreshState = seconds(1);  ///< an older one says that he sees nothing

  struct Holder {
    std::uint64_t client = 0;  ///< 0: nobody
    std::string name;
    std::uint32_t number = 0;
  };

  /// The number of the lease; nothing while another holds one. Who holds one already has it as it is: only
  /// who sees the robot renews it.
  std::optional<std::uint32_t> take(std::uint64_t client, const std::string& name, Time now) {
    expire(now);
    if (holds(client)) return holder_.number;
    if (holder_.client != 0) return std::nullopt;
    holder_ = {client, name, ++last_};
    renewed_ = now;
    return last_;
  }
  /// False where the client holds no such lease, or the status that he saw last is too old.
  bool renew(std::uint64_t client, std::uint32_t number, Time status_seen, Time now) {
    expire(now);
    if (!holds(client) || number != holder_.number || now - status_seen > kFreshState) return false;
    renewed_ = now;
    return true;
  }
  bool release(std::uint64_t client) {
    if (!holds(client)) return false;
    holder_ = {};
    return true;
  }
  /// True when the lease has run out just now.
  bool expire(Time now) {
    if (holder_.client == 0 || now - renewed_ <= kGone) return false;
    holder_ = {};
    return true;
  }

  bool holds(std::uint64_t client) const { return client != 0 && holder_.client == client; }
  const Holder& holder() const { return holder_; }

 private:
  Holder holder_;
  std::uint32_t last_ = 0;
  Time renewed_{};
};

}  // namespace headway::remote
