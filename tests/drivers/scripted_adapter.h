// A USB-CAN adapter as candleLight firmware behaves, or as a test wants instead. Its wire is written out by
// hand, so that a mistake in drivers/gs_usb_protocol does not hide itself.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/can_bus.h"
#include "hal/clock.h"

namespace headway::drivers::testing {

class ScriptedAdapter {
 public:
  using Bytes = std::vector<std::uint8_t>;
  explicit ScriptedAdapter(const hal::Clock& clock, std::string its_serial = "0031")
      : serial(std::move(its_serial)), clock_(clock) {
    seen.sent.reserve(1 << 17);  // so that recording uses no heap while a test counts
  }

  // What it is.
  std::uint16_t vendor = 0x1D50, product = 0x606F;
  std::string serial;
  std::uint8_t interface = 0, endpoint_in = 0x81, endpoint_out = 0x02;
  std::uint32_t features = 1u << 4 | 1u << 13;  // time stamps, tells its state
  std::uint32_t clock_hz = 48'000'000;
  std::array<std::uint32_t, 8> limits{1, 16, 1, 8, 4, 1, 1024, 1};
  unsigned channels = 1;
  std::uint32_t us_at_start = 0;  ///< of its clock
  double clock_rate = 1;          ///< of its microseconds to true ones

  // What a test may turn.
  bool is_denied = false, is_claimed = false, has_bulk = true;
  bool is_mute = false;  ///< answers no control request
  std::optional<std::uint8_t> refuses,
      cuts_short;  ///< control requests that it stalls, answers a byte too short
  Duration answer_takes = std::chrono::microseconds(100);
  bool echoes = true;
  bool replies = false;  ///< answers each frame with one whose identifier is one higher
  int stalls_reads = 0, stalls_writes = 0, breaks_reads = 0;  ///< how many more
  bool keeps_writes = false, keeps_reads = false;  ///< transfers that never come back, even cancelled
  std::array<std::uint32_t, 3> state{};            ///< state, receive and transmit errors

  // What a test may look at.
  struct Request {
    bool is_in = false;
    std::uint8_t number = 0;
    std::uint16_t value = 0;
    Bytes data;
  };
  struct Seen {
    std::vector<Request> requests;
    std::vector<hal::CanFrame> sent;
    std::vector<std::uint32_t> echo_ids;
    int starts = 0, resets = 0, halts_cleared = 0;
    bool is_started = false;
    std::uint32_t mode_flags = 0;
    std::array<std::uint32_t, 5> timing{};
  } seen;

  std::uint32_t us_at(Time t) const {
    const double us = to_seconds(t) * 1e6 * clock_rate;
    return us_at_start + static_cast<std::uint32_t>(static_cast<std::uint64_t>(us));
  }

  // What it hands to the host.
  std::deque<Bytes> outbox;

  void hand_over(std::uint32_t echo_id, std::uint32_t can_id, const std::array<std::uint8_t, 8>& data,
                 std::uint8_t dlc = 8, std::uint8_t channel = 0, std::uint8_t flags = 0) {
    Bytes b(20);
    put(b, 0, echo_id);
    put(b, 4, can_id);
    b[8] = dlc;
    b[9] = channel;
    b[10] = flags;
    std::memcpy(&b[12], data.data(), 8);
    if ((seen.mode_flags & 1u << 4) != 0) {
      b.resize(24);
      put(b, 20, us_at(clock_.now()));
    }
    outbox.push_back(b);
  }
  void receive(std::uint32_t can_id, const std::array<std::uint8_t, 8>& data = {}, std::uint8_t dlc = 8) {
    hand_over(0xFFFFFFFF, can_id, data, dlc);
  }
  void echo(std::uint32_t id) { hand_over(id, 0x100, {}); }
  /// An error frame of the controller's class: data[1], and the error counters.
  void report(std::uint8_t controller, std::uint8_t transmit_errors, std::uint8_t receive_errors) {
    receive(0x20000004, {0, controller, 0, 0, 0, 0, transmit_errors, receive_errors});
  }
  void report_bus_off() {
    state[0] = 3;
    receive(0x20000040);
  }

  // What the host does to it.
  void take(std::span<const std::uint8_t> b) {
    if (b.size() != 20 || !seen.is_started) return;
    hal::CanFrame f;
    f.id = get(b, 4);
    f.dlc = b[8];
    std::memcpy(f.data.data(), &b[12], 8);
    f.stamp = clock_.now();
    seen.sent.push_back(f);
    seen.echo_ids.push_back(get(b, 0));
    if (echoes) hand_over(get(b, 0), f.id, f.data, f.dlc, b[9]);
    if (replies) hand_over(0xFFFFFFFF, f.id + 1, f.data, f.dlc, b[9]);
  }

  /// Nothing when it stalls the request.
  std::optional<Bytes> ask(std::uint8_t request, std::uint16_t value) {
    seen.requests.push_back({true, request, value, {}});
    Bytes b;
    if (request == refuses || value != (request == 5 ? 1 : value % channels)) return std::nullopt;
    if (request == 4) {
      for (const std::uint32_t n : {features, clock_hz}) append(b, n);
      for (const std::uint32_t n : limits) append(b, n);
    } else if (request == 5) {
      b = {0, 0, 0, static_cast<std::uint8_t>(channels - 1)};
      for (const std::uint32_t n : {2u, 1u}) append(b, n);
    } else if (request == 6) {
      append(b, us_at(clock_.now()));
    } else if (request == 14 && (features & 1u << 13) != 0) {
      for (const std::uint32_t n : state) append(b, n);
    } else {
      return std::nullopt;
    }
    if (request == cuts_short) b.pop_back();
    return b;
  }
  bool tell(std::uint8_t request, std::uint16_t value, std::span<const std::uint8_t> b) {
    seen.requests.push_back({false, request, value, Bytes(b.begin(), b.end())});
    if (request == refuses || value != (request == 0 ? 1 : value % channels)) return false;
    if (request == 0) return b.size() == 4 && get(b, 0) == 0xBEEF;
    if (request == 1) {
      if (b.size() != 20 || seen.is_started) return false;
      for (std::size_t i = 0; i < 5; ++i) seen.timing[i] = get(b, 4 * i);
      return true;
    }
    if (request == 2 && b.size() == 8 && get(b, 0) <= 1) {
      seen.is_started = get(b, 0) == 1;
      seen.mode_flags = get(b, 4);
      state = {};
      ++(seen.is_started ? seen.starts : seen.resets);
      return true;
    }
    return false;
  }

 private:
  static void put(Bytes& b, std::size_t at, std::uint32_t n) {
    for (std::size_t i = 0; i < 4; ++i) b[at + i] = static_cast<std::uint8_t>(n >> (8 * i));
  }
  static void append(Bytes& b, std::uint32_t n) {
    b.resize(b.size() + 4);
    put(b, b.size() - 4, n);
  }
  static std::uint32_t get(std::span<const std::uint8_t> b, std::size_t at) {
    return b[at] | static_cast<std::uint32_t>(b[at + 1]) << 8 | static_cast<std::uint32_t>(b[at + 2]) << 16 |
           static_cast<std::uint32_t>(b[at + 3]) << 24;
  }

  const hal::Clock& clock_;
};

}  // namespace headway::drivers::testing
