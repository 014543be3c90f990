// A USB Video Class 1.0 camera with one format, uncompressed or JPEG, that sends its frames by bulk
// transfers. The frames come from whoever runs it; it has faults on demand. (USB Device Class Definition for
// Video Devices, revision 1.0a.)
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "hal/clock.h"
#include "tests/hil/usb_device.h"

namespace headway::hil {

/// The next frame to film, of the camera's size, or a JPEG image of at most that; copied before the next
/// call.
using FrameSource = std::function<ByteSpan()>;

/// A control of the camera, as the class's requests GET_MIN to SET_CUR see it. Exposure times are in 100 us,
/// white balance in K, the rest has no unit.
struct UvcControl {
  std::uint8_t entity = 0, selector = 0, size = 1;
  std::uint32_t lowest = 0, highest = 0, resolution = 1, initial = 0, value = initial;
};

class EmulatedUvc final : public UsbDevice {
 public:
  static constexpr std::uint8_t kIn = 0x81;  ///< bulk endpoint

  struct Config {
    std::string serial = "CAMERA1";
    std::uint16_t width = 640, height = 480;
    enum class Format : std::uint8_t { kGrey, kYuyv, kZ16, kMjpeg } format = Format::kGrey;

    std::uint32_t frame_size() const;  ///< bytes; of JPEG images at most
    /// Throws InputError.
    void validate() const;
  };

  /// The clock paces the frames and must outlive this.
  EmulatedUvc(const Config& config, FrameSource source, const hal::Clock& clock);

  /// The next frame ends after its first half.
  void cut_next_frame() { cut_ = true; }
  /// While paused, the stream is on and no frame comes.
  void pause(bool paused) { paused_ = paused; }
  /// When the next frame is due while streaming; until then send() has nothing.
  std::optional<Time> due() const;

  const UsbDescription& description() const override { return description_; }
  std::optional<Bytes> request(const SetupPacket& setup, ByteSpan sent) override;
  void receive(std::uint8_t endpoint, ByteSpan bytes) override;
  std::optional<Bytes> send(std::uint8_t endpoint, std::size_t room) override;
  void halt_cleared(std::uint8_t endpoint) override;
  void power_on() override;

 private:
  std::optional<Bytes> request_streaming(const SetupPacket& setup, ByteSpan sent);
  std::optional<Bytes> request_control(const SetupPacket& setup, ByteSpan sent);
  Bytes negotiated() const;
  void start();
  void begin_frame();
  void end_frame();

  Config config_;
  FrameSource source_;
  const hal::Clock& clock_;
  UsbDescription description_;
  std::array<UvcControl, 6> controls_;
  std::uint32_t interval_ = 0;  ///< between frames, 100 ns
  bool streaming_ = false, paused_ = false, cut_ = false;
  Time due_{};
  Bytes frame_;  ///< under way; empty between frames
  std::size_t sent_ = 0;
  std::uint8_t frame_parity_ = 0;
};

}  // namespace headway::hil
