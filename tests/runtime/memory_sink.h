// A disk in memory: fills up, becomes slow or fails when it is told to.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "hal/error.h"
#include "runtime/recording/byte_sink.h"

namespace headway::recording {

class MemorySink final : public ByteSink {
 public:
  void write(std::span<const std::byte> from) override {
    if (on_write) on_write();
    const std::size_t fits = std::min<std::size_t>(from.size(), room - std::min(room, bytes.size()));
    bytes.insert(bytes.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(fits));
    if (fits < from.size()) throw Error("the disk is full");
  }
  void sync() override { ++syncs; }
  void cut(std::uint64_t size) override {
    if (cuts_refused) throw Error("cannot be cut");
    bytes.resize(static_cast<std::size_t>(size));
  }

  std::vector<std::byte> bytes;
  std::size_t room = std::numeric_limits<std::size_t>::max();
  int syncs = 0;
  bool cuts_refused = false;
  std::function<void()> on_write;
};

}  // namespace headway::recording
