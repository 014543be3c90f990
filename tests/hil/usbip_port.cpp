#include "tests/hil/usbip_port.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include "hal/error.h"

namespace headway::hil {
namespace {

constexpr const char* kAttachFile = "/sys/devices/platform/vhci_hcd.0/attach";

// USB/IP commands, and where their fields lie in the 48-byte header.
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr std::size_t kHeaderSize = 48;
constexpr std::size_t kCommandAt = 0, kSequenceAt = 4, kDirectionAt = 12, kEndpointAt = 16;
constexpr std::size_t kUnlinkSequenceAt = 20, kLengthAt = 24, kSetupAt = 40;

constexpr std::uint8_t kClearFeature = 1, kEndpointRecipient = 0x02;

SetupPacket setup_packet(ByteSpan bytes) {
  const auto word = [&](std::size_t offset) { return static_cast<std::uint16_t>(read_le(bytes, offset, 2)); };
  return {
      .request_type = bytes[0], .request = bytes[1], .value = word(2), .index = word(4), .length = word(6)};
}

Bytes answer_header(std::uint32_t command, std::uint32_t sequence, std::int32_t status, std::size_t length) {
  Bytes header;
  for (std::uint32_t field : {command, sequence, 0U, 0U, 0U, static_cast<std::uint32_t>(status),
                              static_cast<std::uint32_t>(length)}) {
    append_be32(header, field);
  }
  header.resize(kHeaderSize);
  return header;
}

// 0, or the error's number.
int write_line(const FileDescriptor& file, const std::string& text) {
  const ssize_t written = ::write(file.number(), text.data(), text.size());
  return written == static_cast<ssize_t>(text.size()) ? 0 : errno;
}

void attach_at(unsigned number, int socket, UsbSpeed speed) {
  const FileDescriptor file(::open(kAttachFile, O_WRONLY | O_CLOEXEC));
  if (!file) {
    throw Error(fmt::format("{}: {}; expected a virtual USB host: modprobe vhci-hcd, and be root",
                            kAttachFile, std::strerror(errno)));
  }
  const std::string line = fmt::format("{} {} {} {}", number, socket, number + 1, static_cast<int>(speed));
  int error = EBUSY;
  for (int tries = 0; tries < 100 && error == EBUSY; ++tries) {
    error = write_line(file, line);
    if (error == EBUSY) ::poll(nullptr, 0, 50);
  }
  if (error != 0) {
    throw Error(fmt::format("{}: port {}: {}; expected a free port, 0 to 7", kAttachFile, number,
                            std::strerror(error)));
  }
}

}  // namespace

Attach attach_to_kernel(unsigned number) {
  return [number](int socket, UsbSpeed speed) { attach_at(number, socket, speed); };
}

void UsbipPort::plug() {
  if (socket_) return;
  std::array<int, 2> pair{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair.data()) != 0) {
    throw Error(fmt::format("socketpair: {}", std::strerror(errno)));
  }
  FileDescriptor ours(pair[0]);
  const FileDescriptor theirs(pair[1]);
  attach_(theirs.number(), device_.description().speed);
  device_.power_on();
  socket_ = std::move(ours);
}

void UsbipPort::unplug() {
  // The kernel holds the pair's other end: shut down, it reads an end of file.
  if (socket_) ::shutdown(socket_.number(), SHUT_RDWR);
  socket_.reset();
  waiting_.clear();
  stalled_.clear();
}

void UsbipPort::stall(std::uint8_t endpoint) {
  stalled_.insert(endpoint);
  const auto is_stalled = [&](const Transfer& t) { return t.endpoint == endpoint; };
  for (const Transfer& transfer : waiting_) {
    if (is_stalled(transfer)) finish(transfer, -EPIPE);
  }
  std::erase_if(waiting_, is_stalled);
}

void UsbipPort::answer_message() {
  std::array<std::uint8_t, kHeaderSize> header{};
  if (!read_all(header)) return unplug();
  const std::uint32_t sequence = read_be32(header, kSequenceAt);
  if (read_be32(header, kCommandAt) == kUnlink) return unlink(sequence, read_be32(header, kUnlinkSequenceAt));
  if (read_be32(header, kCommandAt) != kSubmit) return unplug();

  const bool to_host = read_be32(header, kDirectionAt) == 1;
  const auto endpoint = static_cast<std::uint8_t>(read_be32(header, kEndpointAt) | (to_host ? 0x80U : 0U));
  Transfer transfer{.sequence = sequence,
                    .endpoint = endpoint,
                    .length = read_be32(header, kLengthAt),
                    .setup = setup_packet(ByteSpan(header).subspan(kSetupAt)),
                    .sent = {}};
  if (!to_host) {
    transfer.sent.resize(transfer.length);
    if (!read_all(transfer.sent)) return unplug();
  }
  submit(std::move(transfer));
}

void UsbipPort::submit(Transfer transfer) {
  if ((transfer.endpoint & 0x7F) == 0) return control(transfer);
  if (stalled_.contains(transfer.endpoint)) return finish(transfer, -EPIPE);
  if (transfer.to_host()) {
    waiting_.push_back(std::move(transfer));
  } else {
    device_.receive(transfer.endpoint, transfer.sent);
    finish(transfer, 0);
  }
}

// The kernel takes a transfer back, perhaps one that is done already.
void UsbipPort::unlink(std::uint32_t sequence, std::uint32_t unwanted) {
  const auto taken = std::erase_if(waiting_, [&](const Transfer& t) { return t.sequence == unwanted; });
  write_all(answer_header(kUnlinked, sequence, taken > 0 ? -ECONNRESET : 0, 0));
}

void UsbipPort::control(const Transfer& transfer) {
  const auto answer = control_answer(transfer.setup, transfer.sent);
  if (!answer) return finish(transfer, -EPIPE);
  const std::size_t room = std::min<std::size_t>(transfer.length, transfer.setup.length);
  finish(transfer, 0, ByteSpan(*answer).first(std::min(answer->size(), room)));
}

std::optional<Bytes> UsbipPort::control_answer(const SetupPacket& setup, ByteSpan sent) {
  if (stalled_.erase(0) > 0) return std::nullopt;
  if (!setup.is_standard()) return device_.request(setup, sent);
  if (setup.request == kClearFeature && setup.request_type == kEndpointRecipient) {
    clear_halt(static_cast<std::uint8_t>(setup.index));
  }
  return answer_standard_request(device_.description(), setup);
}

void UsbipPort::clear_halt(std::uint8_t endpoint) {
  stalled_.erase(endpoint);
  device_.halt_cleared(endpoint);
}

void UsbipPort::send_waiting() {
  for (auto transfer = waiting_.begin(); transfer != waiting_.end();) {
    const auto data = device_.send(transfer->endpoint, transfer->length);
    if (data) finish(*transfer, 0, *data);
    transfer = data ? waiting_.erase(transfer) : std::next(transfer);
  }
}

// A transfer from the host is told how much arrived: all of it.
void UsbipPort::finish(const Transfer& transfer, std::int32_t status, ByteSpan data) {
  std::size_t length = transfer.to_host() ? data.size() : transfer.sent.size();
  if (status != 0) length = 0;
  Bytes message = answer_header(kSubmitted, transfer.sequence, status, length);
  if (transfer.to_host()) message.insert(message.end(), data.begin(), data.end());
  write_all(message);
}

bool UsbipPort::read_all(std::span<std::uint8_t> into) {
  while (!into.empty()) {
    const ssize_t count = ::recv(socket_.number(), into.data(), into.size(), MSG_WAITALL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    into = into.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

// A kernel that has hung up shows at the next read.
void UsbipPort::write_all(ByteSpan bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
}

}  // namespace headway::hil
