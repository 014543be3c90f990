// One connection to a USB-CAN adapter, from its opening to the fault that ends it: the transfers under way,
// the frames whose echo is awaited, and the adapter's clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>

#include "drivers/adapter_clock.h"
#include "drivers/can_mailbox.h"
#include "drivers/gs_usb_adapter.h"
#include "drivers/gs_usb_protocol.h"
#include "drivers/usb_transfer.h"
#include "hal/clock.h"

namespace headway::drivers {

/// All calls by one thread, not the bus loop's. What the adapter can recover from (a stalled endpoint, frames
/// that nobody acknowledges, bus off) is answered by starting its controller anew, which also drops the
/// frames that it holds: they would be late. So would be what has waited in the mailbox while the adapter was
/// not to be had: that is dropped, too. While nobody acknowledges the bus counts as off. Anything else ends
/// the link.
class GsUsbLink final : private UsbTransfer::Owner {
 public:
  /// Opens the adapter and starts its controller. Throws as GsUsbAdapter.
  GsUsbLink(UsbCalls& usb, const GsUsbConfig& config, const hal::Clock& clock, CanMailbox& mailbox);
  ~GsUsbLink() { close(); }

  /// Hands over what waits in the mailbox, and waits for `longest` at most for what comes; a readable `bell`
  /// (descriptor) ends the waiting. An adapter that does not answer may hold it for
  /// GsUsbAdapter::kAnswerTimeout more.
  void serve(int bell, Duration longest) noexcept;
  const GsUsbAdapter& adapter() const noexcept { return *adapter_; }
  bool has_ended() const noexcept { return ended_; }

  static constexpr std::size_t kReads = 32;  ///< under way: 7 ms of a full bus at 500 kbit/s
  static constexpr Duration kLookEvery = std::chrono::seconds(1);  ///< at the adapter's clock and state

 private:
  /// For a frame that was handed to the adapter: its number is the frame's echo_id.
  struct Slot {
    Slot(UsbCalls& usb, libusb_device_handle* handle, std::uint8_t endpoint, UsbTransfer::Owner& owner)
        : transfer(usb, handle, endpoint, owner) {}
    UsbTransfer transfer;
    bool occupied = false, awaits_echo = false, was_sent = false;
    Duration since{};  ///< on the scale of served_
  };
  struct Transfers {
    std::deque<UsbTransfer> reads;
    std::deque<Slot> slots;
  };

  void done(UsbTransfer& transfer) noexcept override;
  void take_in(std::span<const std::uint8_t> bytes) noexcept;
  void take_echo(std::uint32_t id) noexcept;
  void take_state(const gs_usb::ControllerState& state) noexcept;
  void tell_state() noexcept;
  Time stamp_of(const gs_usb::HostFrame& frame) noexcept;

  void keep_reading() noexcept;
  void write_waiting() noexcept;
  void write(std::uint32_t number, const hal::CanFrame& frame) noexcept;
  void settle_if_done(Slot& slot) noexcept;

  void look() noexcept;
  bool read_clock() noexcept;
  bool read_state() noexcept;
  void count_time() noexcept;
  bool is_over(Duration since) const noexcept { return served_ - since >= config_.echo_timeout; }
  bool nobody_acknowledges() const noexcept;
  bool needs_restart() const noexcept;
  void restart() noexcept;
  /// Calls all transfers back and gives up the frames in them. False when some did not come back in time.
  bool recall() noexcept;
  bool any_under_way() const noexcept;
  void close() noexcept;

  UsbCalls& usb_;
  GsUsbConfig config_;
  const hal::Clock& clock_;
  CanMailbox& mailbox_;
  std::unique_ptr<GsUsbAdapter> adapter_;
  std::unique_ptr<Transfers> transfers_;

  bool is_open_ = false, ended_ = false, stalled_ = false;
  bool is_unheard_ = false;  ///< no frame was on the bus in time, nor any since
  gs_usb::ControllerState controller_;
  Duration served_{};  ///< how long this has been served: the scale on which the adapter can be late
  Time served_last_{};
  Duration restarted_{}, off_since_{};  ///< on that scale
  AdapterClock adapter_clock_;
  bool asks_clock_ = false, asks_state_ = false;
  int unanswered_ = 0;
  Time next_look_{}, last_stamp_{};
  Time emptied_{};  ///< when nothing was left in the mailbox
};

}  // namespace headway::drivers
