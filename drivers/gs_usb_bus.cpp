#include "drivers/gs_usb_bus.h"

#include <algorithm>
#include <exception>

namespace headway::drivers {

namespace {

const GsUsbConfig& validated(const GsUsbConfig& config) {
  config.validate();
  return config;
}

}  // namespace

GsUsbBus::GsUsbBus(const GsUsbConfig& config, hal::Clock& clock, UsbCalls& usb)
    : config_(validated(config)),
      clock_(clock),
      usb_(usb),
      link_(std::make_unique<GsUsbLink>(usb, config, clock, mailbox_)),
      device_(link_->adapter().device()),
      opened_(clock.now()),
      retry_(config.retry) {}

GsUsbBus::~GsUsbBus() = default;

bool GsUsbBus::send(const hal::CanFrame& frame) noexcept {
  if (!mailbox_.send(frame)) return false;
  bell_.ring();
  return true;
}

void GsUsbBus::serve(Duration longest) noexcept {
  const Time end = clock_.now() + longest;
  for (Time now = clock_.now(); now < end; now = clock_.now()) {
    if (link_) {
      serve_link(end - now);
    } else if (retry_.is_due(now)) {
      open_again();
    } else {
      clock_.sleep_until(std::min(end, retry_.next()));
    }
  }
}

void GsUsbBus::serve_link(Duration longest) noexcept {
  bell_.hear();  // before the frames are looked at, so that none is overheard
  link_->serve(bell_.descriptor(), longest);
  if (!link_->has_ended()) return;
  link_.reset();
  mailbox_.set_state(hal::CanBusState::kGone);
  const Time now = clock_.now();
  if (now - opened_ >= config_.retry.longest)
    retry_.begin_at_once(now);
  else
    retry_.failed(now);  // it never worked for long: no use in haste
}

void GsUsbBus::open_again() noexcept {
  try {
    link_ = std::make_unique<GsUsbLink>(usb_, config_, clock_, mailbox_);
    opened_ = clock_.now();
  } catch (const std::exception&) {
    retry_.failed(clock_.now());
  }
}

}  // namespace headway::drivers
