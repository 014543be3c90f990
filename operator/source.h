// What a server of the operator's page shows, and who does what it asks for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "hal/time.h"
#include "operator/channels.h"

namespace headway::remote {

/// Which channels somebody has subscribed to.
using Wanted = std::array<bool, kChannels.size()>;

/// A message as it goes to all who want it; `number` is one more for each message of its channel, from 1.
struct Newest {
  std::shared_ptr<const std::vector<std::byte>> cdr;  ///< null: none yet
  std::uint64_t number = 0;
  Time time{};
};

/// Everything in the server's thread.
class Source {
 public:
  virtual ~Source() = default;

  /// Takes up what the loops have published since, and makes messages of what is wanted.
  virtual void look(const Wanted& wanted) = 0;
  /// The newest message of any channel but kVoxels.
  virtual Newest newest(Channel channel) const = 0;
  /// OperatorStatus::number of the newest one.
  virtual std::uint32_t status_number() const = 0;

  /// What has changed of the voxels since `version` (0: everything, and what was known is to be forgotten),
  /// at most some 2,000 bricks at once. `version` moves on; null when nothing has changed.
  virtual std::shared_ptr<const std::vector<std::byte>> voxels(std::uint64_t& version) = 0;

  /// A file like "map.pgm", "map.yaml" or "map.bt"; null where there is none yet.
  virtual std::shared_ptr<const std::string> file(const std::string& name) = 0;
  /// In Prometheus' text format.
  virtual std::string metrics() = 0;
};

}  // namespace headway::remote
