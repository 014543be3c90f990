// Takes what the loops hand over, and writes the recording and, after a fault, the black box. It never makes
// a loop wait: what it has no time for is dropped, counted, and the counts are recorded.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "hal/clock.h"
#include "hal/exchange.h"
#include "runtime/black_box.h"
#include "runtime/bus_tap.h"
#include "runtime/file_tape.h"
#include "runtime/frame_tap.h"
#include "runtime/threads.h"

namespace headway::runtime {

struct RecorderConfig {
  std::optional<FileTapeConfig> files;  ///< nothing: no recording
  bool record_at_once = true;           ///< else record() begins one
  std::optional<BlackBoxConfig> black_box;
  std::size_t picture_bytes = 640 * 480;  ///< of one image of the cameras
  Duration round = seconds(0.02);         ///< how often its thread looks for what has come
  Duration after_fault = seconds(1);      ///< so much of what follows a fault is in its black box
};

/// A fault that a report shows and the one before did not: a drive, the control computer, or a walk that they
/// ended. Nothing else that ends a walk is one.
std::optional<std::string> new_fault(const BusReport& before, const BusReport& now);

/// Of the recording, for people.
struct RecordingState {
  bool on = false;
  std::string file;           ///< that is written, or was last; empty: none yet
  std::uint64_t bytes = 0;    ///< of this recording, in all its files
  std::uint64_t dropped = 0;  ///< rows that there was no time to write, since it began
  std::string fault;          ///< why it did not begin, or ended; empty: as it was asked to be
};

class Recorder {
 public:
  /// Makes the first file, if it is to record at once; the rows begin at `begin`. The clock, which tells when
  /// to look and to write, must outlive it. Throws as FileTape.
  Recorder(RecorderConfig config, const Preface& preface, hal::Clock& clock, Time begin);
  /// As stop().
  ~Recorder() { stop(); }

  BusTap& bus() { return *bus_; }
  FrameTap& frames() { return *frames_; }

  /// Writes in a thread of its own from now on. Without, pump() does.
  void start();
  /// Takes what is left, writes the black box if it is to be, and ends the file. The loops have stopped.
  void stop() noexcept;
  /// One round, in whatever thread; what cannot be written becomes news.
  void pump() noexcept;

  // In one other thread:
  /// The black box is to be written.
  void fault(const std::string& what);
  /// Something to tell, once; false when there is nothing.
  bool news(std::string& text);
  /// Begins another recording, in another file, or ends it: soon, not at once. What comes of it is in the
  /// state. Nothing happens where it is so already, or there is nowhere to record to.
  void record(bool on) { orders_.push(on); }
  /// False when it is as it was.
  bool look(RecordingState& state);

  // Once stopped, or in the thread that pumps:
  const recorded::Drops& drops() const { return drops_; }
  const FileTape* tape() const { return tape_ ? &*tape_ : nullptr; }

 private:
  using Text = std::array<char, 300>;
  void put(const Row& row);
  void put_on_tape(const Row& row);
  void obey();
  void begin_recording();
  void say_state();
  void watch(const BusReport& report);
  void note_drops();
  void write_black_box(bool ending);
  void tell(const std::string& text);
  template <class Work>
  void told(Work&& work) noexcept;
  /// As told(), and the state says it.
  template <class Work>
  void taped(Work&& work) noexcept;
  bool records() const { return tape_ && !tape_->broken(); }

  RecorderConfig config_;
  Preface preface_;
  hal::Clock& clock_;
  std::unique_ptr<BusTap> bus_;
  std::unique_ptr<FrameTap> frames_;
  std::optional<FileTape> tape_;
  std::optional<BlackBox> black_box_;
  hal::BoundedQueue<Text, 8> faults_, news_;
  hal::BoundedQueue<bool, 8> orders_;
  hal::NewestSlot<RecordingState> state_;
  std::string tape_fault_;
  BusReport last_report_;
  bool reported_ = false;
  std::string fault_;  ///< that is to be written
  std::optional<Time> fault_time_;
  recorded::Drops drops_, drops_before_;  ///< in all, and before the recording began
  std::uint32_t drops_number_ = 0, tape_drops_number_ = 0;
  Time newest_{};     ///< of all rows
  bool any_ = false;  ///< rows have come
  bool ended_ = false;
  std::unique_ptr<Thread> thread_;
};

}  // namespace headway::runtime
