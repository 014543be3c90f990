#include "sim_hal/sim_bus.h"

#include <algorithm>
#include <string>

#include "hal/error.h"

namespace headway::sim {

void SimBusConfig::validate() const {
  if (!(bit_rate >= 1e4 && bit_rate <= 1e6)) {
    throw InputError("bus.bit_rate: " + std::to_string(bit_rate) +
                     ", expected 10000 to 1000000 bit/s (classic CAN)");
  }
  if (send_queue == 0 || receive_queue == 0)
    throw InputError("bus.send_queue, bus.receive_queue: expected at least 1");
}

Duration frame_time(std::uint8_t dlc, double bit_rate) {
  // 44 bits of frame and 3 between frames; of the 34 bits from start to CRC and the data every fifth may be
  // followed by a stuffed one.
  const int data = 8 * std::min<int>(dlc, 8);
  const int bits = 47 + data + (34 + data - 1) / 4;
  return seconds(bits / bit_rate);
}

SimBus::Endpoint::Endpoint(SimBus& bus, std::string name)
    : bus_(bus), name_(std::move(name)), out_(bus.config_.send_queue), in_(bus.config_.receive_queue) {}

bool SimBus::Endpoint::send(const hal::CanFrame& frame) noexcept {
  if (off() || out_size_ == out_.size()) {
    ++bus_.counters_.send_refused;
    return false;
  }
  out_[(out_first_ + out_size_) % out_.size()] = {frame, bus_.now_};
  ++out_size_;
  return true;
}

std::size_t SimBus::Endpoint::receive(std::span<hal::CanFrame> into) noexcept {
  const std::size_t count = std::min(into.size(), in_size_);
  for (std::size_t i = 0; i < count; ++i) into[i] = in_[(in_first_ + i) % in_.size()];
  in_first_ = (in_first_ + count) % in_.size();
  in_size_ -= count;
  return count;
}

void SimBus::Endpoint::set_state(hal::CanBusState state) {
  state_ = state;
  if (off()) out_size_ = 0;
}

void SimBus::Endpoint::deliver(const hal::CanFrame& frame) noexcept {
  if (off()) return;
  if (listener_ != nullptr) {
    listener_->receive(frame);
  } else if (in_size_ == in_.size()) {
    ++bus_.counters_.receive_lost;
  } else {
    in_[(in_first_ + in_size_) % in_.size()] = frame;
    ++in_size_;
  }
}

SimBus::SimBus(const SimBusConfig& config, Time start) : config_(config), now_(start), free_at_(start) {
  config_.validate();
}

SimBus::Endpoint& SimBus::attach(std::string name) {
  endpoints_.push_back(std::unique_ptr<Endpoint>(new Endpoint(*this, std::move(name))));
  return *endpoints_.back();
}

/// Who wins the wire next, and when: of the frames that wait when it falls free (or, if none does, of those
/// that come first) the one with the lowest identifier.
SimBus::Endpoint* SimBus::next_sender(Time& start) {
  Endpoint* winner = nullptr;
  Time first{Duration::max()};
  for (const auto& e : endpoints_)
    if (e->out_size_ > 0) first = std::min(first, e->out_[e->out_first_].queued);
  start = std::max(free_at_, first);
  for (const auto& e : endpoints_) {
    if (e->out_size_ == 0 || e->out_[e->out_first_].queued > start) continue;
    if (winner == nullptr || e->out_[e->out_first_].frame.id < winner->out_[winner->out_first_].frame.id)
      winner = e.get();
  }
  return winner;
}

void SimBus::transmit(Endpoint& from, Time end) {
  hal::CanFrame frame = from.out_[from.out_first_].frame;
  from.out_first_ = (from.out_first_ + 1) % from.out_.size();
  --from.out_size_;
  now_ = free_at_ = end;
  ++counters_.sent;
  if (drop_ && drop_(frame)) {
    ++counters_.fault_dropped;
    return;
  }
  const std::optional<unsigned> bit = corrupt_ ? corrupt_(frame) : std::nullopt;
  if (bit && *bit < 8U * frame.dlc) {
    ++counters_.fault_corrupted;
    frame.data[*bit / 8] = static_cast<std::uint8_t>(frame.data[*bit / 8] ^ 1U << *bit % 8);
  }
  if (const Duration late = delay_ ? delay_(frame) : Duration{}; late > Duration{}) {
    ++counters_.fault_delayed;
    delayed_.push_back({frame, &from, end + late});
    return;
  }
  broadcast(frame, &from);
}

void SimBus::broadcast(hal::CanFrame frame, const Endpoint* from) {
  frame.stamp = now_;
  for (const auto& e : endpoints_)
    if (e.get() != from) e->deliver(frame);
}

void SimBus::advance(Time now) {
  while (true) {
    Time start{};
    Endpoint* sender = next_sender(start);
    const Time end = sender == nullptr
                         ? Time(Duration::max())
                         : start + frame_time(sender->out_[sender->out_first_].frame.dlc, config_.bit_rate);
    const auto late = std::min_element(delayed_.begin(), delayed_.end(),
                                       [](const Delayed& a, const Delayed& b) { return a.due < b.due; });
    if (late != delayed_.end() && late->due <= std::min(end, now)) {
      const Delayed due = *late;
      delayed_.erase(late);
      now_ = std::max(now_, due.due);
      broadcast(due.frame, due.from);
    } else if (end <= now) {
      transmit(*sender, end);
    } else {
      break;
    }
  }
  now_ = std::max(now_, now);
}

}  // namespace headway::sim
