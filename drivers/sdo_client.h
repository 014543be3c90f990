// Reads and writes objects of one CANopen node, one expedited transfer at a time, without waiting for it.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/canopen_master.h"
#include "hal/bus_codec.h"
#include "hal/cia402.h"

namespace headway::drivers {

/// Real-time safe. start, then tick() and receive() until done() or failed().
class SdoClient {
 public:
  struct Config {
    Duration timeout = hal::bus::SdoAnswer::kTimeout;  ///< for one try
    int tries = 3;
  };
  enum class Status : std::uint8_t { kIdle, kBusy, kDone, kRefused, kTimedOut };

  SdoClient(CanopenMaster& master, std::uint8_t node, const Config& config) noexcept
      : master_(master), node_(node), config_(config) {}

  /// Each gives up whatever was under way.
  void write(const hal::cia402::Object& object, std::uint32_t value) noexcept;
  void read(const hal::cia402::Object& object) noexcept;
  void cancel() noexcept { status_ = Status::kIdle; }

  void receive(const hal::CanFrame& frame) noexcept;
  void tick(Time now) noexcept;

  Status status() const noexcept { return status_; }
  const hal::cia402::Object& object() const noexcept { return object_; }
  std::uint32_t value() const noexcept { return value_; }            ///< what was read, once done
  std::uint32_t abort_code() const noexcept { return abort_code_; }  ///< why it was refused

 private:
  void start(const hal::cia402::Object& object, const hal::bus::SdoRequest& request) noexcept;
  bool is_answer(const hal::bus::SdoAnswer& answer) const noexcept;

  CanopenMaster& master_;
  std::uint8_t node_;
  Config config_;
  Status status_ = Status::kIdle;
  hal::cia402::Object object_;
  hal::bus::SdoRequest request_;
  bool is_read_ = false;
  int tries_left_ = 0;
  std::optional<Time> sent_;
  std::uint32_t value_ = 0, abort_code_ = 0;
};

}  // namespace headway::drivers
