// Cameras that behave as V4L2 drivers do (kernel documentation: userspace-api/media/v4l), with faults on
// demand, and an account of every descriptor, buffer and mapping that was handed out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/device_calls.h"
#include "drivers/pixel_format.h"
#include "hal/clock.h"

namespace headway::drivers::testing {

enum class Call : std::uint8_t {
  kOpen,
  kCapability,
  kFormat,
  kRate,
  kControls,
  kRequest,
  kQueryBuffer,
  kMap,
  kQueue,
  kDequeue,
  kStart,
  kStop,
  kPoll,  ///< fails with POLLERR or POLLHUP in place of an error
};
inline constexpr int kCalls = 13;

/// One device, as it lies on the desk: what it offers, what it does wrong, what was set.
struct ScriptedCamera {
  struct Offer {
    std::uint32_t code = 0;
    int width = 0, height = 0;
    double most_rate = 30;
  };
  struct Control {
    std::int32_t least = 0, most = 100, step = 1, value = 0;
  };
  /// What one frame looks like, for the whole buffer; returns the bytes used.
  using Paint = std::function<std::size_t(std::span<std::uint8_t>, std::uint32_t number)>;

  // What a test may turn before it is opened.
  std::vector<Offer> offers;
  std::size_t padding = 0;  ///< bytes at the end of every row
  std::uint32_t capabilities;
  bool can_set_rate = true;
  bool stamps_at_start = false;  ///< of the exposure
  Duration readout{}, start_up = std::chrono::milliseconds(300);
  std::uint32_t fewest_buffers = 0;  ///< given in place of what was asked; 0: as asked
  Paint paint;

  // Faults, while they are set.
  bool plugged = true, silent = false, frozen = false, foreign_clock = false, marked = false, half = false,
       interlaced = false;
  Duration stamp_shift{};
  std::size_t extra_bytes = 0;         ///< told to be used beyond the buffer's end
  std::vector<std::uint32_t> deaf_to;  ///< controls that keep their value
  std::map<Call, int> fails;           ///< with this error, every time

  // Faults, once.
  std::map<Call, int> fails_once;
  std::uint32_t lose = 0;       ///< frames that are counted and never delivered
  bool count_anew = false;      ///< the sequence
  std::uint64_t unplug_in = 0;  ///< so many calls, this one among them; 0: not at all

  // What a test may look at.
  std::map<std::uint32_t, Control> controls;
  std::optional<Offer> set;
  double rate = 30;
  Duration exposure{};        ///< as set; zero: automatic
  std::uint32_t made = 0;     ///< frames since it was made
  std::vector<Time> middles;  ///< true middles of their exposures
  int control_calls = 0, starts = 0;
  bool is_streaming = false;
  Duration last_stamp{};

  /// One that offers this format only, and has all the usual controls.
  explicit ScriptedCamera(PixelFormat format, int width = 32, int height = 24);

  Duration period() const { return seconds(1 / rate); }
  void unplug();
  void plug() { plugged = true; }
  void mend();  ///< ends all faults, and plugs it in

  std::uint32_t generation = 0;  ///< times it was unplugged: what was opened before stays dead
};

/// The system calls on a desk of such cameras, by their paths.
class ScriptedCalls final : public DeviceCalls {
 public:
  explicit ScriptedCalls(const hal::Clock& clock) : clock_(clock) {}
  ~ScriptedCalls() override;

  ScriptedCamera& add(const std::string& path, ScriptedCamera camera);

  int open(const char* path) noexcept override;
  int close(int descriptor) noexcept override;
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  Mapped mmap(int descriptor, std::size_t length, std::int64_t offset) noexcept override;
  int munmap(void* memory, std::size_t length) noexcept override;
  int poll(int descriptor) noexcept override;

  // What a test may look at.
  std::size_t open_descriptors() const { return handles_.size(); }
  std::size_t mappings() const { return mapped_.size(); }
  std::uint64_t calls = 0;
  std::uint64_t allocations = 0;        ///< of the scripted cameras themselves
  std::vector<std::string> violations;  ///< calls that no right program makes

 private:
  struct Buffer {
    enum class Owner : std::uint8_t { kProgram, kQueued, kDone };
    Owner owner = Owner::kProgram;
    std::span<std::uint8_t> memory;
    std::size_t bytes = 0;
    std::uint32_t sequence = 0, flags = 0;
    Duration stamp{};
  };
  struct Handle {
    ScriptedCamera* camera = nullptr;
    std::uint32_t generation = 0;
    std::size_t stride = 0, size = 0;
    std::vector<Buffer> buffers;
    std::deque<std::uint32_t> queued, done;
    bool streaming = false;
    std::uint32_t sequence = 0;
    Time next{};

    bool is_dead() const { return !camera->plugged || generation != camera->generation; }
  };

  Handle* find(int descriptor, const char* call);
  std::optional<int> failure(ScriptedCamera& camera, Call call);
  int answer(Handle& handle, unsigned long request, void* argument);
  int set_format(Handle& handle, void* argument);
  int set_rate(Handle& handle, void* argument, bool set);
  int query_control(Handle& handle, void* argument);
  int set_controls(Handle& handle, void* argument, bool set);
  int request_buffers(Handle& handle, void* argument);
  int query_buffer(Handle& handle, void* argument);
  int queue(Handle& handle, void* argument);
  int dequeue(Handle& handle, void* argument);
  int start(Handle& handle);
  int stop(Handle& handle);
  void produce(Handle& handle);
  void make_frame(Handle& handle);

  const hal::Clock& clock_;
  std::map<std::string, std::unique_ptr<ScriptedCamera>> cameras_;
  std::map<int, Handle> handles_;
  std::map<void*, std::size_t> mapped_;
  int next_descriptor_ = 1000;
};

}  // namespace headway::drivers::testing
