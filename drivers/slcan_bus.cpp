#include "drivers/slcan_bus.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <termios.h>
#include <unistd.h>

#include "hal/error.h"

namespace headway::drivers {

namespace {

/// What Sn sets, by n [bit/s].
constexpr std::array kBitRates{10'000,  20'000,  50'000,  100'000,  125'000,
                               250'000, 500'000, 800'000, 1'000'000};

struct BaudRate {
  int rate;
  speed_t code;
};
constexpr std::array kBaudRates{BaudRate{57'600, B57600},   BaudRate{115'200, B115200},
                                BaudRate{230'400, B230400}, BaudRate{460'800, B460800},
                                BaudRate{921'600, B921600}, BaudRate{1'000'000, B1000000}};

constexpr int kMostReads = 16;     ///< in one cycle, whatever comes in
constexpr int kMostRefusals = 16;  ///< one after the other: the adapter is not on the bus

/// Neither echoes nor changes a byte, waits for no modem.
bool make_raw(int fd, int baud_rate) noexcept {
  const auto speed = std::find_if(kBaudRates.begin(), kBaudRates.end(),
                                  [&](const BaudRate& b) { return b.rate == baud_rate; });
  termios line{};
  if (speed == kBaudRates.end() || tcgetattr(fd, &line) < 0) return false;
  cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
  // With a least count of 1, reading 0 bytes means that the line is hung up.
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  return cfsetspeed(&line, speed->code) == 0 && tcsetattr(fd, TCSANOW, &line) == 0 &&
         tcflush(fd, TCIOFLUSH) == 0;
}

}  // namespace

void SlcanConfig::validate() const {
  if (path.empty())
    throw InputError(
        "slcan: no tty is named, expected one such as slcan:/dev/ttyACM0; see /dev/serial/by-id");
  if (std::find(kBitRates.begin(), kBitRates.end(), bit_rate) == kBitRates.end())
    throw InputError(fmt::format("slcan:{}: a bus of {} bit/s, expected one of {}", path, bit_rate,
                                 fmt::join(kBitRates, ", ")));
  std::string known;
  for (const BaudRate& b : kBaudRates) {
    if (b.rate == baud_rate) return;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", b.rate);
  }
  throw InputError(fmt::format("slcan:{}: a line of {} baud, expected one of {}", path, baud_rate, known));
}

SlcanBus::SlcanBus(const SlcanConfig& config, hal::Clock& clock)
    : config_(config), clock_(clock), retry_(config.retry), rest_of_(hal::CanFrame{}) {
  config_.validate();
  if (!open()) explain(errno);
  is_open_ = true;
}

SlcanBus::~SlcanBus() {
  if (is_open_) write("\rC\r");
  if (is_open_)
    ::close(fd_);
  else
    close();
}

// --- opening ---

bool SlcanBus::open() noexcept {
  fd_ = ::open(config_.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) return false;
  // Two programs on one line would take each other's frames, and either closes the channel when it ends.
  if (::flock(fd_, LOCK_EX | LOCK_NB) == 0 && make_raw(fd_, config_.baud_rate) && greet()) return true;
  const int error = errno;
  close();
  errno = error;
  return false;
}

/// Ends a line that somebody else began; off the bus, for only there the bit rate can be set; on the bus.
bool SlcanBus::greet() noexcept {
  const auto rate = std::find(kBitRates.begin(), kBitRates.end(), config_.bit_rate) - kBitRates.begin();
  const std::array<char, 8> text{'\r', 'C', '\r', 'S', static_cast<char>('0' + rate), '\r', 'O', '\r'};
  const std::string_view line(text.data(), text.size());
  errno = EAGAIN;  // for a tty that takes a part
  return write(line) == line.size();
}

void SlcanBus::close() noexcept {
  if (fd_ < 0) return;
  // Else closing waits until a line that nobody reads has taken all.
  tcflush(fd_, TCIOFLUSH);
  ::close(fd_);
  fd_ = -1;
}

void SlcanBus::explain(int error) const {
  const char* mend = "'ls /dev/serial/by-id' lists the adapters that are there";
  if (error == EWOULDBLOCK) mend = "another program uses it: end that first ('fuser -v' names it)";
  if (error == EACCES) mend = "members of the group dialout may open it";
  if (error == ENOTTY || error == ENODEV) mend = "expected the tty of a serial CAN adapter";
  throw InputError(
      fmt::format("slcan:{}: cannot be opened as a tty ({}); {}", config_.path, std::strerror(error), mend));
}

void SlcanBus::serve(Duration at_most) noexcept {
  const Time end = clock_.now() + at_most;
  if (is_open_.load(std::memory_order_acquire)) return clock_.sleep_until(end);
  if (fd_ >= 0) {
    close();
    retry_.begin(clock_.now());
  }
  clock_.sleep_until(std::min(end, retry_.next()));
  if (!retry_.is_due(clock_.now())) return;
  if (open())
    is_open_.store(true, std::memory_order_release);
  else
    retry_.failed(clock_.now());
}

// --- receiving ---

std::size_t SlcanBus::receive(std::span<hal::CanFrame> into) noexcept {
  using Event = SlcanReader::Event;
  std::size_t count = 0;
  if (!is_open_.load(std::memory_order_acquire)) return count;
  send_rest();
  for (int reads = 0; count < into.size();) {
    if (in_next_ == in_end_ && (reads++ == kMostReads || !fill())) break;
    const Event event = reader_.feed(in_[in_next_++]);
    if (event == Event::kFrame) {
      into[count] = reader_.frame();
      into[count++].stamp = read_at_;
      ++stats_.received;
    } else if (event == Event::kUnusable) {
      ++stats_.unusable;
    }
    if (event == Event::kRefused)
      note_refusal();
    else if (event != Event::kNone)
      refusals_ = 0;
  }
  return count;
}

/// False when there is nothing to read.
bool SlcanBus::fill() noexcept {
  if (!is_open_.load(std::memory_order_relaxed)) return false;
  const ssize_t got = ::read(fd_, in_.data(), in_.size());
  read_at_ = clock_.now();
  in_next_ = 0;
  in_end_ = got > 0 ? static_cast<std::size_t>(got) : 0;
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) lose();
  return got > 0;
}

void SlcanBus::note_refusal() noexcept {
  ++stats_.refused;
  if (++refusals_ == kMostRefusals) lose();
}

// --- sending ---

bool SlcanBus::send(const hal::CanFrame& frame) noexcept {
  if (frame.id > 0x7FF || frame.dlc > 8 || !is_open_.load(std::memory_order_acquire)) return refuse();
  if (!send_rest()) return refuse();
  rest_of_ = SlcanLine(frame);
  const std::size_t taken = write(rest_of_.text());
  if (taken == 0) return refuse();
  rest_ = rest_of_.text().substr(taken);
  ++stats_.sent;
  return true;
}

/// A line that was begun must be ended before the next. False while the tty does not take all of it, and when
/// it is gone.
bool SlcanBus::send_rest() noexcept {
  const std::size_t taken = rest_.empty() ? 0 : write(rest_);
  if (!is_open_.load(std::memory_order_relaxed)) return false;
  rest_.remove_prefix(taken);
  return rest_.empty();
}

/// How much of it the tty took.
std::size_t SlcanBus::write(std::string_view text) noexcept {
  const ssize_t taken = ::write(fd_, text.data(), text.size());
  if (taken >= 0) return static_cast<std::size_t>(taken);
  if (errno != EAGAIN && errno != EINTR && is_open_.load(std::memory_order_relaxed)) lose();
  return 0;
}

bool SlcanBus::refuse() noexcept {
  ++stats_.refused;
  return false;
}

/// Hands the descriptor over to serve().
void SlcanBus::lose() noexcept {
  ++stats_.gone;
  reader_ = {};
  in_next_ = in_end_ = 0;
  rest_ = {};
  refusals_ = 0;
  is_open_.store(false, std::memory_order_release);
}

// --- what is known of it ---

hal::CanBusState SlcanBus::state() const noexcept {
  return is_open_.load(std::memory_order_relaxed) ? hal::CanBusState::kErrorActive : hal::CanBusState::kGone;
}

hal::CanBusStats SlcanBus::stats() const noexcept {
  hal::CanBusStats told = stats_;
  told.state = state();
  return told;
}

}  // namespace headway::drivers
