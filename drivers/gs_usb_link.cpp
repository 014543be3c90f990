#include "drivers/gs_usb_link.h"

#include <algorithm>
#include <utility>

#include "hal/error.h"

namespace headway::drivers {

using gs_usb::ControllerState;
using gs_usb::HostFrame;
using hal::CanBusState;

namespace {

constexpr Duration kLongestWait = std::chrono::milliseconds(10);  ///< so that what is overdue is seen
constexpr int kRecallRounds = 200;  ///< of kLongestWait where nothing comes back: two seconds
constexpr Duration kOldestFrame = std::chrono::seconds(1);  ///< a stamp before that is no time of a frame
constexpr int kMostUnanswered = 3;
constexpr int kNoBell = -1;

}  // namespace

GsUsbLink::GsUsbLink(UsbCalls& usb, const GsUsbConfig& config, const hal::Clock& clock, CanMailbox& mailbox)
    : usb_(usb),
      config_(config),
      clock_(clock),
      mailbox_(mailbox),
      adapter_(std::make_unique<GsUsbAdapter>(usb, config)),
      transfers_(std::make_unique<Transfers>()) {
  UsbTransfer::Owner& owner = *this;
  for (std::size_t i = 0; i < kReads; ++i) {
    transfers_->reads.emplace_back(usb, adapter_->handle(), adapter_->endpoint_in(), owner);
  }
  for (std::size_t i = 0; i < CanMailbox::kInFlight; ++i) {
    transfers_->slots.emplace_back(usb, adapter_->handle(), adapter_->endpoint_out(), owner);
  }
  keep_reading();
  if (ended_ || !adapter_->start()) {
    close();
    throw Error("USB-CAN adapter '" + config.serial +
                "': does not start, expected its controller to; unplug it and plug it in anew");
  }
  is_open_ = true;
  mailbox_.discard_outgoing();  // meant for the bus as it was before
  take_state({});
  // What it does not answer now it need not know, whatever it said: firmware differs. It is not asked again.
  asks_clock_ = adapter_->has_clock() && read_clock();
  asks_state_ = adapter_->tells_state() && read_state();
  served_last_ = emptied_ = clock_.now();
  next_look_ = served_last_ + kLookEvery;
}

void GsUsbLink::serve(int bell, Duration longest) noexcept {
  count_time();
  if (needs_restart()) restart();
  if (clock_.now() >= next_look_) look();
  keep_reading();
  write_waiting();
  if (ended_) return;
  const int result = usb_.handle_events(adapter_->context(), bell, std::min(longest, kLongestWait));
  if (result < 0 && result != LIBUSB_ERROR_INTERRUPTED) ended_ = true;
}

// --- what comes back ---

void GsUsbLink::done(UsbTransfer& transfer) noexcept {
  switch (transfer.status()) {
    case LIBUSB_TRANSFER_COMPLETED:
      if (transfer.is_read()) take_in(transfer.bytes());
      break;
    case LIBUSB_TRANSFER_CANCELLED:
      break;
    case LIBUSB_TRANSFER_OVERFLOW:
      mailbox_.count_unusable();
      break;
    case LIBUSB_TRANSFER_STALL:
      stalled_ = true;
      break;
    default:
      ended_ = true;
  }
  if (transfer.is_read()) return;
  for (Slot& slot : transfers_->slots) {
    if (&slot.transfer == &transfer) settle_if_done(slot);
  }
}

void GsUsbLink::take_in(std::span<const std::uint8_t> bytes) noexcept {
  if (!is_open_) return;  // left over in an adapter that nobody had closed: nobody knows how old it is
  const auto frame = HostFrame::unpack(bytes);
  if (!frame || frame->channel != config_.channel) return mailbox_.count_unusable();
  if (frame->tells_of_losses()) mailbox_.count_lost();
  if (frame->echo_id != HostFrame::kReceived) return take_echo(frame->echo_id);
  if (frame->is_error()) return take_state(frame->controller_state(controller_));
  auto received = frame->can_frame();
  if (!received) return mailbox_.count_unusable();
  received->stamp = stamp_of(*frame);
  mailbox_.deliver(*received);
}

void GsUsbLink::take_echo(std::uint32_t id) noexcept {
  if (id >= transfers_->slots.size() || !transfers_->slots[id].awaits_echo) return mailbox_.count_unusable();
  Slot& slot = transfers_->slots[id];
  slot.awaits_echo = false;
  slot.was_sent = true;
  settle_if_done(slot);
  if (std::exchange(is_unheard_, false)) tell_state();
}

void GsUsbLink::take_state(const ControllerState& state) noexcept {
  if (state.state == CanBusState::kBusOff && controller_.state != CanBusState::kBusOff) off_since_ = served_;
  controller_ = state;
  tell_state();
}

/// A controller that nobody acknowledges never goes off the bus by itself.
void GsUsbLink::tell_state() noexcept {
  mailbox_.set_state(is_unheard_ ? CanBusState::kBusOff : controller_.state, controller_.transmit_errors,
                     controller_.receive_errors);
}

Time GsUsbLink::stamp_of(const HostFrame& frame) noexcept {
  const Time arrival = clock_.now();
  Time stamp = arrival;
  if (frame.timestamp_us) stamp = adapter_clock_.time(*frame.timestamp_us).value_or(arrival);
  if (stamp > arrival || stamp < arrival - kOldestFrame) stamp = arrival;
  // Setting the clock moves it a little; frames keep their order.
  last_stamp_ = std::max(last_stamp_, stamp);
  return last_stamp_;
}

// --- what goes out ---

void GsUsbLink::keep_reading() noexcept {
  if (stalled_) return;
  for (UsbTransfer& read : transfers_->reads) {
    if (!read.is_under_way() && read.submit(UsbTransfer::kBufferSize) < 0) ended_ = true;
  }
}

/// What has waited while an answer was late, the controller was started anew or this thread was held up is
/// late now.
void GsUsbLink::write_waiting() noexcept {
  if (stalled_ || ended_) return;
  const Time now = clock_.now();
  if (now - emptied_ > config_.echo_timeout) mailbox_.discard_outgoing();
  emptied_ = now;
  hal::CanFrame frame;
  for (std::uint32_t number = 0; number < transfers_->slots.size(); ++number) {
    if (transfers_->slots[number].occupied) continue;
    if (!mailbox_.take(frame)) return;
    write(number, frame);
  }
}

void GsUsbLink::write(std::uint32_t number, const hal::CanFrame& frame) noexcept {
  HostFrame out;
  out.echo_id = number;
  out.can_id = frame.id;
  out.dlc = frame.dlc;
  out.channel = static_cast<std::uint8_t>(config_.channel);
  out.data = frame.data;
  const auto bytes = out.pack();
  Slot& slot = transfers_->slots[number];
  std::copy(bytes.begin(), bytes.end(), slot.transfer.buffer().begin());
  slot.occupied = slot.awaits_echo = true;
  slot.was_sent = false;
  slot.since = served_;
  if (slot.transfer.submit(bytes.size()) < 0) ended_ = true;
}

void GsUsbLink::settle_if_done(Slot& slot) noexcept {
  if (!slot.occupied || slot.awaits_echo || slot.transfer.is_under_way()) return;
  slot.occupied = false;
  mailbox_.settle(slot.was_sent);
}

// --- looking after the adapter ---

void GsUsbLink::look() noexcept {
  next_look_ = clock_.now() + kLookEvery;
  const bool clock_is_known = !asks_clock_ || read_clock();
  const bool state_is_known = !asks_state_ || read_state();
  unanswered_ = clock_is_known && state_is_known ? 0 : unanswered_ + 1;
  if (unanswered_ >= kMostUnanswered) ended_ = true;
}

bool GsUsbLink::read_clock() noexcept {
  const Time asked = clock_.now();
  const auto us = adapter_->timestamp();
  if (us) adapter_clock_.set(*us, asked, clock_.now());
  return us.has_value();
}

bool GsUsbLink::read_state() noexcept {
  const auto state = adapter_->controller_state();
  if (state) take_state(*state);
  return state.has_value();
}

/// When this thread was held up, that is not the adapter's fault: its answers may lie about, not yet looked
/// at.
void GsUsbLink::count_time() noexcept {
  const Time now = clock_.now();
  served_ += std::min<Duration>(now - served_last_, 2 * kLongestWait);
  served_last_ = now;
}

bool GsUsbLink::nobody_acknowledges() const noexcept {
  return std::any_of(transfers_->slots.begin(), transfers_->slots.end(),
                     [&](const Slot& s) { return s.occupied && is_over(s.since); });
}

bool GsUsbLink::needs_restart() const noexcept {
  if (!is_over(restarted_)) return false;
  return stalled_ || (controller_.state == CanBusState::kBusOff && is_over(off_since_)) ||
         nobody_acknowledges();
}

void GsUsbLink::restart() noexcept {
  if (!stalled_ && nobody_acknowledges()) is_unheard_ = true;
  restarted_ = served_;
  const bool is_reset = adapter_->reset();
  // Halts are cleared while nothing is under way, as the kernel asks.
  const bool is_clear = recall() && (!stalled_ || adapter_->clear_halts());
  if (!is_reset || !is_clear) {
    ended_ = true;
    return;
  }
  stalled_ = false;
  keep_reading();
  if (!adapter_->start()) ended_ = true;
  take_state({});
}

bool GsUsbLink::recall() noexcept {
  for (UsbTransfer& read : transfers_->reads) read.cancel();
  for (Slot& slot : transfers_->slots) slot.transfer.cancel();
  for (int round = 0; round < kRecallRounds && any_under_way(); ++round) {
    usb_.handle_events(adapter_->context(), kNoBell, kLongestWait);
  }
  for (Slot& slot : transfers_->slots) {
    slot.awaits_echo = false;
    settle_if_done(slot);
  }
  return !any_under_way();
}

bool GsUsbLink::any_under_way() const noexcept {
  return std::any_of(transfers_->reads.begin(), transfers_->reads.end(),
                     [](const UsbTransfer& read) { return read.is_under_way(); }) ||
         std::any_of(transfers_->slots.begin(), transfers_->slots.end(),
                     [](const Slot& slot) { return slot.transfer.is_under_way(); });
}

void GsUsbLink::close() noexcept {
  if (recall()) return;
  adapter_->reset();
  // The kernel still owns memory of transfers that did not come back, so it stays, and with it what they
  // belong to. Their context is never asked again, so nobody is called back.
  for (Slot& slot : transfers_->slots) {
    if (slot.occupied) mailbox_.settle(false);
  }
  static_cast<void>(transfers_.release());
  static_cast<void>(adapter_.release());
}

}  // namespace headway::drivers
