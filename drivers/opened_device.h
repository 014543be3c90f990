// An open device and memory mapped from it, given back when they go out of scope.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "drivers/device_calls.h"

namespace headway::drivers {

class OpenedDevice {
 public:
  /// Takes over an open descriptor. The calls must outlive it.
  OpenedDevice(DeviceCalls& calls, int descriptor) noexcept : calls_(&calls), descriptor_(descriptor) {}
  OpenedDevice(OpenedDevice&& other) noexcept
      : calls_(other.calls_), descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenedDevice& operator=(OpenedDevice&&) = delete;
  ~OpenedDevice() {
    if (descriptor_ >= 0) calls_->close(descriptor_);
  }

  /// As DeviceCalls' of the same name.
  int ioctl(unsigned long request, void* argument) const noexcept {
    return calls_->ioctl(descriptor_, request, argument);
  }
  int poll() const noexcept { return calls_->poll(descriptor_); }
  DeviceCalls::Mapped mmap(std::size_t length, std::int64_t offset) const noexcept {
    return calls_->mmap(descriptor_, length, offset);
  }
  DeviceCalls& calls() const noexcept { return *calls_; }

 private:
  DeviceCalls* calls_;
  int descriptor_;
};

class MappedMemory {
 public:
  MappedMemory() = default;
  /// Takes over what was mapped. The calls must outlive it.
  MappedMemory(DeviceCalls& calls, void* memory, std::size_t length) noexcept
      : calls_(&calls), bytes_(static_cast<std::uint8_t*>(memory), length) {}
  MappedMemory(MappedMemory&& other) noexcept
      : calls_(other.calls_), bytes_(std::exchange(other.bytes_, {})) {}
  MappedMemory& operator=(MappedMemory&& other) noexcept {
    std::swap(calls_, other.calls_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~MappedMemory() {
    if (bytes_.data()) calls_->munmap(bytes_.data(), bytes_.size());
  }

  std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

 private:
  DeviceCalls* calls_ = nullptr;
  std::span<std::uint8_t> bytes_;
};

}  // namespace headway::drivers
