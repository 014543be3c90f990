#include "drivers/sdo_client.h"

namespace headway::drivers {

namespace cia402 = hal::cia402;
namespace sdo = hal::cia402::sdo;
using hal::bus::SdoAnswer;
using hal::bus::SdoRequest;

namespace {

constexpr std::uint32_t low_bytes(std::uint32_t value, int bytes) noexcept {
  return bytes >= 4 ? value : value & ((std::uint32_t{1} << (8 * bytes)) - 1);
}

/// The size is told by the answer, or (command 0x42) not.
constexpr bool carries(std::uint8_t command, int bytes) noexcept {
  return command == sdo::uploaded(bytes) || command == 0x42;
}

}  // namespace

void SdoClient::write(const cia402::Object& object, std::uint32_t value) noexcept {
  is_read_ = false;
  start(object, {.command = sdo::download(object.bytes), .data = low_bytes(value, object.bytes)});
}

void SdoClient::read(const cia402::Object& object) noexcept {
  is_read_ = true;
  start(object, {.command = sdo::kUpload});
}

void SdoClient::start(const cia402::Object& object, const SdoRequest& request) noexcept {
  object_ = object;
  request_ = request;
  request_.index = object.index;
  request_.subindex = object.subindex;
  tries_left_ = config_.tries;
  sent_.reset();
  abort_code_ = 0;
  status_ = Status::kBusy;
}

bool SdoClient::is_answer(const SdoAnswer& answer) const noexcept {
  return answer.index == object_.index && answer.subindex == object_.subindex;
}

void SdoClient::receive(const hal::CanFrame& frame) noexcept {
  if (status_ != Status::kBusy || !sent_ || frame.id != cia402::kSdoAnswerBase + node_) return;
  const auto answer = SdoAnswer::unpack(frame);
  if (!answer || !is_answer(*answer)) return;
  if (answer->command == sdo::kAbort) {
    abort_code_ = answer->data;
    status_ = Status::kRefused;
  } else if (is_read_ ? carries(answer->command, object_.bytes) : answer->command == sdo::kDownloaded) {
    value_ = low_bytes(answer->data, object_.bytes);
    status_ = Status::kDone;
  }
}

void SdoClient::tick(Time now) noexcept {
  if (status_ != Status::kBusy || (sent_ && now - *sent_ < config_.timeout)) return;
  if (tries_left_ <= 0) {
    status_ = Status::kTimedOut;
  } else if (master_.send(request_.pack(cia402::kSdoRequestBase + node_))) {
    sent_ = now;
    --tries_left_;
  }
}

}  // namespace headway::drivers
