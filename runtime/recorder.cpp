#include "runtime/recorder.h"

#include <algorithm>
#include <exception>

namespace headway::runtime {

namespace {

template <class Text>
Text text_of(const std::string& text) {
  Text out{};
  std::copy_n(text.begin(), std::min(text.size(), out.size() - 1), out.begin());
  return out;
}

recorded::Drops since(const recorded::Drops& before, const recorded::Drops& now) {
  return {now.can_frames - before.can_frames, now.bus_reports - before.bus_reports, now.steps - before.steps,
          now.pictures - before.pictures, now.rows - before.rows};
}

std::uint64_t sum(const recorded::Drops& drops) {
  return drops.can_frames + drops.bus_reports + drops.steps + drops.pictures + drops.rows;
}

}  // namespace

std::optional<std::string> new_fault(const BusReport& before, const BusReport& now) {
  const auto became = [](auto was, auto is, auto what) { return is == what && was != what; };
  if (stopped(now.safety.state) && !stopped(before.safety.state) &&
      now.safety.event != SafetyEvent::kStopAsked)
    return "stopped for safety: " + describe(now.safety);
  if (became(before.walk.state, now.walk.state, hal::WalkState::kFault))
    return "the control computer reports a fault";
  if (became(before.walker, now.walker, hal::WalkerHealth::kLost)) return "the control computer fell silent";
  if (became(before.head.health, now.head.health, hal::HeadHealth::kFault))
    return "a drive of the head is at fault";
  if (before.last_stop == now.last_stop) return std::nullopt;
  switch (now.last_stop) {
    case nav::StackStop::kRejected:
      return "a walk ended: the control computer refused a step";
    case nav::StackStop::kLost:
      return "a walk ended: the control computer was not heard, or made no sense";
    case nav::StackStop::kNoStart:
      return "a walk ended: it did not begin";
    case nav::StackStop::kEnded:
      return "a walk ended before its last step";
    case nav::StackStop::kRestarted:
      return "a walk ended: the control computer began anew";
    default:
      return std::nullopt;
  }
}

Recorder::Recorder(RecorderConfig config, const Preface& preface, hal::Clock& clock, Time begin)
    : config_(std::move(config)),
      preface_(preface),
      clock_(clock),
      bus_(std::make_unique<BusTap>()),
      frames_(std::make_unique<FrameTap>(config_.picture_bytes)),
      newest_(begin) {
  if (config_.files && config_.record_at_once) tape_.emplace(*config_.files, preface, begin);
  if (config_.black_box) black_box_.emplace(*config_.black_box, preface);
}

void Recorder::start() {
  thread_ = std::make_unique<Thread>(ThreadId::kRecord, [this](const std::atomic<bool>& stop) {
    while (!stop) {
      pump();
      clock_.sleep_until(clock_.now() + config_.round);
    }
  });
}

void Recorder::stop() noexcept {
  if (ended_) return;
  if (thread_) thread_->stop();
  pump();
  ended_ = true;
  told([this] { write_black_box(true); });
  taped([this] {
    if (tape_) tape_->finish();
  });
  told([this] { say_state(); });
}

/// What is thrown becomes news.
template <class Work>
void Recorder::told(Work&& work) noexcept {
  try {
    work();
  } catch (const std::exception& fault) {
    tell(fault.what());
  }
}

template <class Work>
void Recorder::taped(Work&& work) noexcept {
  told([&] {
    try {
      work();
    } catch (const std::exception& fault) {
      tape_fault_ = fault.what();
      throw;
    }
  });
}

void Recorder::pump() noexcept {
  if (ended_) return;
  taped([this] { obey(); });
  told([this] {
    bus_->drain([this](const Row& row) { put(row); }, [this](const BusReport& report) { watch(report); });
    frames_->drain([this](const Row& row) { put(row); });
    note_drops();
    Text text;
    while (faults_.pop(text)) {
      if (!fault_time_) fault_ = text.data();
      if (!fault_time_) fault_time_ = clock_.now();
    }
  });
  told([this] { write_black_box(false); });
  taped([this] {
    if (tape_) tape_->tend(clock_.now());
  });
  told([this] { say_state(); });
}

/// Ahead of what has come since: a recording begins with it, or ends before it.
void Recorder::obey() {
  for (bool on = false; orders_.pop(on);) {
    if (on == records() || !config_.files) continue;
    tape_fault_.clear();
    if (on)
      begin_recording();
    else
      tape_->finish();
  }
}

void Recorder::begin_recording() {
  tape_.emplace(*config_.files, preface_, newest_);
  drops_before_ = drops_;
  tape_drops_number_ = 0;
  frames_->want_map();
}

void Recorder::say_state() {
  RecordingState state;
  state.on = records() && !ended_;
  if (tape_) {
    state.file = tape_->file().string();
    state.bytes = tape_->bytes();
  }
  state.dropped = sum(since(drops_before_, drops_));
  state.fault = tape_fault_;
  state_.publish(state);
}

bool Recorder::look(RecordingState& state) {
  if (!state_.update()) return false;
  state = state_.value();
  return true;
}

void Recorder::put(const Row& row) {
  newest_ = std::max(newest_, row.time);
  any_ = true;
  if (black_box_) black_box_->put(row);
  put_on_tape(row);
}

void Recorder::put_on_tape(const Row& row) {
  if (!records()) return;
  try {
    if (tape_->put(row)) frames_->want_map();
  } catch (const std::exception& fault) {
    tape_fault_ = std::string("the recording ends here: ") + fault.what();
    tell(tape_fault_);
  }
}

void Recorder::watch(const BusReport& report) {
  if (reported_)
    if (auto fault = new_fault(last_report_, report); fault && !fault_time_) {
      fault_ = *std::move(fault);
      fault_time_ = report.stamp;
    }
  last_report_ = report;
  reported_ = true;
}

void Recorder::note_drops() {
  recorded::Drops now;
  bus_->count(now);
  frames_->count(now);
  if (!any_) return;
  const bool news = now != drops_;
  drops_ = now;
  const auto row = [this](std::uint32_t number, const std::vector<std::byte>& cdr) {
    return Row{Topic::kDrops, number, newest_, cdr};
  };
  if (black_box_ && (news || drops_number_ == 0))
    black_box_->put(row(drops_number_++, recording::to_cdr(now)));
  if (records() && (news || tape_drops_number_ == 0))
    put_on_tape(row(tape_drops_number_++, recording::to_cdr(since(drops_before_, now))));
}

void Recorder::write_black_box(bool ending) {
  if (!black_box_ || !fault_time_) return;
  if (!ending && clock_.now() - *fault_time_ < config_.after_fault) return;
  fault_time_.reset();
  if (const auto file = black_box_->write(fault_, clock_.now()))
    tell("black box: " + fault_ + ": " + file->string());
}

void Recorder::fault(const std::string& what) { faults_.push(text_of<Text>(what)); }

void Recorder::tell(const std::string& text) { news_.push(text_of<Text>(text)); }

bool Recorder::news(std::string& text) {
  Text line;
  if (!news_.pop(line)) return false;
  text = line.data();
  return true;
}

}  // namespace headway::runtime
