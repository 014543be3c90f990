// The other end of an emulated device's socket in tests: asks as the kernel would, one transfer at a time.
#pragma once

#include <array>
#include <cerrno>
#include <cstdint>
#include <optional>
#include <set>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "tests/hil/usbip_port.h"

namespace headway::hil {

struct Answer {
  std::uint32_t command = 0, sequence = 0;
  std::int32_t status = 0;
  std::uint32_t length = 0;  ///< bytes transferred
  Bytes data;                ///< of a transfer to the host
};

class UsbHost {
 public:
  static constexpr std::uint32_t kSubmitted = 3, kUnlinked = 4;

  explicit UsbHost(UsbDevice& device)
      : port_(device, [this](int socket, UsbSpeed) {
          socket_ = FileDescriptor(::fcntl(socket, F_DUPFD_CLOEXEC, 0));
        }) {
    port_.plug();
  }
  UsbHost(const UsbHost&) = delete;
  UsbHost& operator=(const UsbHost&) = delete;

  UsbipPort& port() { return port_; }

  /// Each hands the port one message and returns its number.
  std::uint32_t ask_bulk_in(std::uint8_t endpoint, std::uint32_t length) {
    return submit(endpoint, true, length, {}, {});
  }
  std::uint32_t send_bulk(std::uint8_t endpoint, ByteSpan bytes) {
    return submit(endpoint, false, static_cast<std::uint32_t>(bytes.size()), {}, bytes);
  }
  std::uint32_t control(const SetupPacket& setup, ByteSpan sent = {}) {
    return submit(0, setup.to_host(), setup.length, setup, sent);
  }
  std::uint32_t unlink(std::uint32_t unwanted) {
    Bytes message = header(2, ++sequence_, 0, 0);
    append_be32(message, unwanted);
    message.resize(48);
    hand_over(message);
    return sequence_;
  }

  /// The next answer; nullopt: there is none yet.
  std::optional<Answer> answer() {
    port_.send_waiting();
    pollfd file{.fd = socket_.number(), .events = POLLIN, .revents = 0};
    if (::poll(&file, 1, 0) != 1) return std::nullopt;
    const Bytes head = read(48);
    if (head.empty()) return std::nullopt;
    Answer answer{.command = read_be32(head, 0),
                  .sequence = read_be32(head, 4),
                  .status = static_cast<std::int32_t>(read_be32(head, 20)),
                  .length = read_be32(head, 24),
                  .data = {}};
    if (answer.command == kSubmitted && to_host_.contains(answer.sequence)) answer.data = read(answer.length);
    return answer;
  }
  /// Waits for the device's end to close; only for one that was unplugged.
  bool hung_up() {
    std::uint8_t byte = 0;
    return ::read(socket_.number(), &byte, 1) == 0;
  }

 private:
  static Bytes header(std::uint32_t command, std::uint32_t sequence, std::uint32_t direction,
                      std::uint32_t endpoint) {
    Bytes bytes;
    for (std::uint32_t field : {command, sequence, 1U, direction, endpoint}) append_be32(bytes, field);
    return bytes;
  }
  std::uint32_t submit(std::uint8_t endpoint, bool to_host, std::uint32_t length, const SetupPacket& setup,
                       ByteSpan sent) {
    Bytes message = header(1, ++sequence_, to_host ? 1 : 0, endpoint & 0x7FU);
    if (to_host) to_host_.insert(sequence_);
    append_be32(message, 0);
    append_be32(message, length);
    message.resize(40);
    append_le(message, setup.request_type, 1);
    append_le(message, setup.request, 1);
    for (std::uint16_t word : {setup.value, setup.index, setup.length}) append_le(message, word, 2);
    message.insert(message.end(), sent.begin(), sent.end());
    hand_over(message);
    return sequence_;
  }
  void hand_over(const Bytes& message) {
    if (::write(socket_.number(), message.data(), message.size()) == static_cast<ssize_t>(message.size())) {
      port_.answer_message();
    }
  }
  Bytes read(std::size_t size) {
    Bytes bytes(size);
    std::size_t done = 0;
    while (done < size) {
      const ssize_t count = ::read(socket_.number(), bytes.data() + done, size - done);
      if (count <= 0) return {};
      done += static_cast<std::size_t>(count);
    }
    return bytes;
  }

  FileDescriptor socket_;
  std::uint32_t sequence_ = 0;
  std::set<std::uint32_t> to_host_;  ///< the transfers whose answers bring data
  UsbipPort port_;
};

}  // namespace headway::hil
