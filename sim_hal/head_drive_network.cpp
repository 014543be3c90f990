// The drive as a node of a CANopen network (CiA 301).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "sim_hal/head_drive.h"

namespace headway::sim {
namespace {

constexpr std::uint32_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080, kSdoAnswer = 0x580,
                        kSdoRequest = 0x600, kHeartbeat = 0x700;
constexpr std::uint16_t kConnectionCode = 0x8130;
constexpr std::uint8_t kCommunicationError = 0x11;
constexpr std::uint16_t kTransmit[2] = {0x1800, 0x1801};

std::uint16_t index_of(const hal::CanFrame& sdo) {
  return static_cast<std::uint16_t>(sdo.data[1] | sdo.data[2] << 8);
}

}  // namespace

void HeadDrive::receive(const hal::CanFrame& frame) noexcept {
  if (silent_ || nmt_ == NmtState::kInitialising) return;
  move_to(frame.stamp);
  if (frame.id == kNmt) return obey_network(frame);
  const auto watched = static_cast<std::uint32_t>(objects_.get(0x1016, 1) >> 16);
  if (watched != 0 && frame.id == kHeartbeat + watched) {
    master_heard_ = now_;
    if (master_lost_) {
      master_lost_ = false;
      error_register_ = static_cast<std::uint8_t>(error_code_ == 0 ? 0 : error_register_ & ~0x10);
      send_emergency(0);
    }
  }
  if (frame.id == kSdoRequest + config_.node && nmt_ != NmtState::kStopped) answer_sdo(frame);
  if (nmt_ != NmtState::kOperational) return;
  if (frame.id == kSync) {
    transmit_on_sync();
    if (waits_for_sync_) take_receive_pdo(*std::exchange(waits_for_sync_, std::nullopt));
  }
  if (frame.id != static_cast<std::uint32_t>(objects_.get(0x1400, 1) & 0x800007ff)) return;
  if (objects_.get(0x1400, 2) <= 240)
    waits_for_sync_ = frame;
  else
    take_receive_pdo(frame);
}

void HeadDrive::tick(Time now) noexcept {
  move_to(now);
  if (nmt_ == NmtState::kInitialising) {
    if (now_ >= boots_at_) boot();
    return;
  }
  watch_master();
  produce_heartbeat();
  if (nmt_ == NmtState::kOperational) transmit_on_change();
}

void HeadDrive::send(const hal::CanFrame& frame) noexcept {
  if (!silent_) bus_.send(frame);
}

void HeadDrive::boot() noexcept {
  nmt_ = NmtState::kPreOperational;
  if (power_ == PowerState::kNotReadyToSwitchOn) enter(PowerState::kSwitchOnDisabled);
  send({.id = kHeartbeat + config_.node, .dlc = 1});
}

void HeadDrive::reboot() noexcept {
  objects_ = ObjectDictionary::head_drive(config_.node);
  enter(PowerState::kNotReadyToSwitchOn);
  error_code_ = 0;
  control_word_ = 0;
  limited_ = halted_ = homing_ = false;
  homed_ = config_.homed;
  datum_ = homed_ ? 0 : actual_;
  reset_communication();
}

void HeadDrive::reset_communication() noexcept {
  objects_.restore_communication(ObjectDictionary::head_drive(config_.node));
  nmt_ = NmtState::kInitialising;
  boots_at_ = now_ + config_.boot_time;
  master_heard_.reset();
  master_lost_ = false;
  error_register_ = error_code_ == 0 ? 0 : error_register_;
  syncs_ = {};
  waits_for_sync_.reset();
}

void HeadDrive::obey_network(const hal::CanFrame& frame) noexcept {
  if (frame.dlc != 2 || (frame.data[1] != 0 && frame.data[1] != config_.node)) return;
  switch (frame.data[0]) {
    case 1:
      nmt_ = NmtState::kOperational;
      return;
    case 2:
      if (nmt_ != NmtState::kStopped) abort_connection();
      nmt_ = NmtState::kStopped;
      return;
    case 128:
      nmt_ = NmtState::kPreOperational;
      return;
    case 129:
      return reboot();
    case 130:
      abort_connection();
      return reset_communication();
    default:
      return;
  }
}

void HeadDrive::answer(std::uint8_t command, const hal::CanFrame& request, std::uint32_t data) noexcept {
  hal::CanFrame frame{.id = kSdoAnswer + config_.node, .dlc = 8};
  frame.data = {command,
                request.data[1],
                request.data[2],
                request.data[3],
                static_cast<std::uint8_t>(data),
                static_cast<std::uint8_t>(data >> 8),
                static_cast<std::uint8_t>(data >> 16),
                static_cast<std::uint8_t>(data >> 24)};
  send(frame);
}

void HeadDrive::answer_sdo(const hal::CanFrame& frame) noexcept {
  if (frame.dlc != 8) return;
  switch (frame.data[0] >> 5) {
    case 1:
      return sdo_download(frame);
    case 2:
      return sdo_upload(frame);
    case 4:
      return;  // the client gives up
    default:
      return answer(0x80, frame, static_cast<std::uint32_t>(SdoAbort::kUnknownCommand));
  }
}

void HeadDrive::sdo_download(const hal::CanFrame& frame) noexcept {
  const bool expedited = (frame.data[0] & 2) != 0, sized = (frame.data[0] & 1) != 0;
  const Object* object = std::as_const(objects_).find(index_of(frame), frame.data[3]);
  std::size_t bytes = 4U - (frame.data[0] >> 2 & 3U);
  if (!sized) bytes = object == nullptr ? 4 : object->bytes;
  const SdoAbort refused = !expedited
                               ? SdoAbort::kUnsupportedAccess
                               : objects_.write(index_of(frame), frame.data[3], {&frame.data[4], bytes});
  if (refused != SdoAbort::kNone) return answer(0x80, frame, static_cast<std::uint32_t>(refused));
  answer(0x60, frame, 0);
  object_written(index_of(frame));
}

void HeadDrive::sdo_upload(const hal::CanFrame& frame) noexcept {
  const SdoAbort refused = objects_.readable(index_of(frame), frame.data[3]);
  if (refused != SdoAbort::kNone) return answer(0x80, frame, static_cast<std::uint32_t>(refused));
  refresh_objects();
  const Object& object = *std::as_const(objects_).find(index_of(frame), frame.data[3]);
  const std::uint32_t mask = 0xffffffffU >> (32 - 8 * object.bytes);
  answer(static_cast<std::uint8_t>(0x43 | (4 - object.bytes) << 2), frame,
         static_cast<std::uint32_t>(object.value) & mask);
}

void HeadDrive::object_written(std::uint16_t index) noexcept {
  if (index == 0x6040) obey(static_cast<std::uint16_t>(objects_.get(0x6040)));
  if (index == 0x1016) master_heard_.reset();
  if (index == 0x1017) next_heartbeat_ = now_;
}

/// All values first, then the order: controlword and target belong together.
void HeadDrive::take_receive_pdo(const hal::CanFrame& frame) noexcept {
  const auto count = static_cast<std::uint8_t>(objects_.get(0x1600, 0));
  bool ordered = false;
  std::size_t at = 0;
  for (std::uint8_t entry = 1; entry <= count; ++entry) {
    const std::int64_t mapped = objects_.get(0x1600, entry);
    const auto bytes = static_cast<std::size_t>(mapped & 0xff) / 8;
    if (at + bytes > frame.dlc) return;  // too short: what is missing stays as it was
    const auto index = static_cast<std::uint16_t>(mapped >> 16);
    objects_.write(index, static_cast<std::uint8_t>(mapped >> 8), {&frame.data[at], bytes});
    ordered = ordered || index == 0x6040;
    at += bytes;
  }
  if (ordered) object_written(0x6040);
}

hal::CanFrame HeadDrive::transmit_pdo(std::size_t which) noexcept {
  const auto mapping = static_cast<std::uint16_t>(kTransmit[which] + 0x200);
  hal::CanFrame frame{.id = static_cast<std::uint32_t>(objects_.get(kTransmit[which], 1) & 0x7ff)};
  const auto count = static_cast<std::uint8_t>(objects_.get(mapping, 0));
  for (std::uint8_t entry = 1; entry <= count; ++entry) {
    const std::int64_t mapped = objects_.get(mapping, entry);
    const std::int64_t value =
        objects_.get(static_cast<std::uint16_t>(mapped >> 16), static_cast<std::uint8_t>(mapped >> 8));
    for (std::int64_t bit = 0; bit < (mapped & 0xff); bit += 8)
      frame.data[frame.dlc++] = static_cast<std::uint8_t>(value >> bit);
  }
  return frame;
}

void HeadDrive::transmit_on_sync() noexcept {
  refresh_objects();
  for (std::size_t which = 0; which < 2; ++which) {
    const std::int64_t type = objects_.get(kTransmit[which], 2);
    if ((objects_.get(kTransmit[which], 1) & 0x80000000) != 0 || type < 1 || type > 240) continue;
    if (++syncs_[which] < type) continue;
    syncs_[which] = 0;
    send(transmit_pdo(which));
  }
}

void HeadDrive::transmit_on_change() noexcept {
  for (std::size_t which = 0; which < 2; ++which) {
    if ((objects_.get(kTransmit[which], 1) & 0x80000000) != 0 || objects_.get(kTransmit[which], 2) < 254)
      continue;
    refresh_objects();
    const hal::CanFrame frame = transmit_pdo(which);
    if (frame.data == last_sent_[which].data && frame.dlc == last_sent_[which].dlc) continue;
    last_sent_[which] = frame;
    send(frame);
  }
}

void HeadDrive::refresh_objects() noexcept {
  objects_.set(0x6041, 0, status_word());
  objects_.set(0x6061, 0, objects_.get(0x6060));
  objects_.set(0x6064, 0, std::llround(actual_ - datum_));
  objects_.set(0x606C, 0, std::llround(actual_velocity_));
  objects_.set(0x1001, 0, error_register_);
  objects_.set(0x603F, 0, error_code_);
}

void HeadDrive::produce_heartbeat() noexcept {
  const std::int64_t period = objects_.get(0x1017);
  if (period == 0 || now_ < next_heartbeat_) return;
  next_heartbeat_ += std::chrono::milliseconds(period);
  if (next_heartbeat_ <= now_) next_heartbeat_ = now_ + std::chrono::milliseconds(period);
  hal::CanFrame frame{.id = kHeartbeat + config_.node, .dlc = 1};
  frame.data[0] = static_cast<std::uint8_t>(nmt_);
  send(frame);
}

/// Heartbeat consumer: watches from the first heartbeat on.
void HeadDrive::watch_master() noexcept {
  const auto allowed = std::chrono::milliseconds(objects_.get(0x1016, 1) & 0xffff);
  if (!master_heard_ || master_lost_ || allowed.count() == 0 || now_ - *master_heard_ < allowed) return;
  master_lost_ = true;
  error_register_ |= kCommunicationError;
  send_emergency(kConnectionCode);
  abort_connection();
  if (nmt_ == NmtState::kOperational && objects_.get(0x1029, 1) == 0) nmt_ = NmtState::kPreOperational;
  if (objects_.get(0x1029, 1) == 2) nmt_ = NmtState::kStopped;
}

void HeadDrive::send_emergency(std::uint16_t code) noexcept {
  if (nmt_ != NmtState::kPreOperational && nmt_ != NmtState::kOperational) return;
  hal::CanFrame frame{.id = kEmergency + config_.node, .dlc = 8};
  frame.data = {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8), error_register_};
  send(frame);
}

}  // namespace headway::sim
