#include "tests/drivers/scripted_camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>

#include "tests/heap_count.h"

namespace headway::drivers::testing {

namespace {

constexpr std::uint8_t kPoison = 0xEE;  // what the driver may write into a buffer that it owns
constexpr std::int64_t kPage = 4096;

/// Adds what is allocated while it lives.
class HeapUse {
 public:
  explicit HeapUse(std::uint64_t& sum) : sum_(sum) {}
  ~HeapUse() { sum_ += heap_allocations() - before_; }

 private:
  std::uint64_t& sum_;
  std::uint64_t before_ = heap_allocations();
};

std::size_t plain_bytes(const ScriptedCamera::Offer& offer, std::size_t stride) {
  const auto rows = static_cast<std::size_t>(offer.height);
  if (offer.code == V4L2_PIX_FMT_NV12) return stride * rows * 3 / 2;
  return stride * rows;
}

std::size_t row_of(const ScriptedCamera::Offer& offer) {
  const std::optional<PixelFormat> format = format_of(offer.code);
  return format ? row_bytes(*format, offer.width) : static_cast<std::size_t>(offer.width);
}

/// The offers without those that came before with the same key.
template <class Key>
std::vector<ScriptedCamera::Offer> distinct(const std::vector<ScriptedCamera::Offer>& offers, Key key) {
  std::vector<ScriptedCamera::Offer> some;
  for (const auto& offer : offers) {
    const bool is_known =
        std::any_of(some.begin(), some.end(), [&](const auto& o) { return key(o) == key(offer); });
    if (!is_known) some.push_back(offer);
  }
  return some;
}

int enumerate_formats(const ScriptedCamera& camera, v4l2_fmtdesc& format) {
  const auto codes = distinct(camera.offers, [](const auto& o) { return o.code; });
  if (format.index >= codes.size()) return -EINVAL;
  format.pixelformat = codes[format.index].code;
  return 0;
}

int enumerate_sizes(const ScriptedCamera& camera, v4l2_frmsizeenum& size) {
  std::vector<ScriptedCamera::Offer> some;
  for (const auto& offer : camera.offers) {
    if (offer.code == size.pixel_format) some.push_back(offer);
  }
  if (size.index >= some.size()) return -EINVAL;
  size.type = V4L2_FRMSIZE_TYPE_DISCRETE;
  size.discrete = {static_cast<std::uint32_t>(some[size.index].width),
                   static_cast<std::uint32_t>(some[size.index].height)};
  return 0;
}

int enumerate_intervals(const ScriptedCamera& camera, v4l2_frmivalenum& interval) {
  if (interval.index > 1) return -EINVAL;
  for (const auto& offer : camera.offers) {
    if (offer.code != interval.pixel_format || static_cast<std::uint32_t>(offer.width) != interval.width)
      continue;
    interval.type = V4L2_FRMIVAL_TYPE_DISCRETE;
    interval.discrete = {interval.index + 1, static_cast<std::uint32_t>(offer.most_rate)};
    return 0;
  }
  return -EINVAL;
}

std::optional<Call> call_of(unsigned long request) {
  switch (request) {
    case VIDIOC_QUERYCAP:
      return Call::kCapability;
    case VIDIOC_S_FMT:
      return Call::kFormat;
    case VIDIOC_S_PARM:
      return Call::kRate;
    case VIDIOC_S_EXT_CTRLS:
      return Call::kControls;
    case VIDIOC_REQBUFS:
      return Call::kRequest;
    case VIDIOC_QUERYBUF:
      return Call::kQueryBuffer;
    case VIDIOC_QBUF:
      return Call::kQueue;
    case VIDIOC_DQBUF:
      return Call::kDequeue;
    case VIDIOC_STREAMON:
      return Call::kStart;
    case VIDIOC_STREAMOFF:
      return Call::kStop;
    default:
      return std::nullopt;
  }
}

}  // namespace

ScriptedCamera::ScriptedCamera(PixelFormat format, int width, int height)
    : offers{{code_of(format), width, height, 30}},
      capabilities(V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING),
      controls{{V4L2_CID_EXPOSURE_AUTO, {0, 3, 1, V4L2_EXPOSURE_APERTURE_PRIORITY}},
               {V4L2_CID_EXPOSURE_ABSOLUTE, {3, 2047, 1, 250}},
               {V4L2_CID_AUTOGAIN, {0, 1, 1, 1}},
               {V4L2_CID_GAIN, {0, 255, 1, 64}},
               {V4L2_CID_AUTO_WHITE_BALANCE, {0, 1, 1, 1}},
               {V4L2_CID_WHITE_BALANCE_TEMPERATURE, {2000, 6500, 10, 4000}}} {}

void ScriptedCamera::unplug() {
  if (plugged) ++generation;
  plugged = false;
  is_streaming = false;
}

void ScriptedCamera::mend() {
  plugged = true;
  silent = frozen = foreign_clock = marked = half = interlaced = count_anew = false;
  stamp_shift = {};
  extra_bytes = 0;
  lose = 0;
  unplug_in = 0;
  deaf_to.clear();
  fails.clear();
  fails_once.clear();
}

ScriptedCalls::~ScriptedCalls() {
  for (const auto& [memory, length] : mapped_) ::munmap(memory, length);
}

ScriptedCamera& ScriptedCalls::add(const std::string& path, ScriptedCamera camera) {
  return *(cameras_[path] = std::make_unique<ScriptedCamera>(std::move(camera)));
}

ScriptedCalls::Handle* ScriptedCalls::find(int descriptor, const char* call) {
  ++calls;
  const auto found = handles_.find(descriptor);
  if (found != handles_.end()) {
    ScriptedCamera& camera = *found->second.camera;
    if (camera.unplug_in > 0 && --camera.unplug_in == 0) camera.unplug();
    return &found->second;
  }
  violations.push_back(std::string(call) + " on a descriptor that is not open");
  return nullptr;
}

std::optional<int> ScriptedCalls::failure(ScriptedCamera& camera, Call call) {
  if (const auto once = camera.fails_once.find(call); once != camera.fails_once.end()) {
    const int error = once->second;
    camera.fails_once.erase(once);
    return error;
  }
  if (const auto always = camera.fails.find(call); always != camera.fails.end()) return always->second;
  return std::nullopt;
}

int ScriptedCalls::open(const char* path) noexcept {
  const HeapUse use(allocations);
  ++calls;
  const auto found = cameras_.find(path);
  if (found == cameras_.end() || !found->second->plugged) return -ENOENT;
  ScriptedCamera& camera = *found->second;
  if (const auto error = failure(camera, Call::kOpen)) return -*error;
  Handle handle;
  handle.camera = &camera;
  handle.generation = camera.generation;
  handles_.emplace(next_descriptor_, std::move(handle));
  return next_descriptor_++;
}

int ScriptedCalls::close(int descriptor) noexcept {
  const HeapUse use(allocations);
  Handle* handle = find(descriptor, "close");
  if (!handle) return -EBADF;
  if (handle->streaming && !handle->is_dead()) handle->camera->is_streaming = false;
  handles_.erase(descriptor);
  return 0;
}

ScriptedCalls::Mapped ScriptedCalls::mmap(int descriptor, std::size_t length, std::int64_t offset) noexcept {
  const HeapUse use(allocations);
  Handle* handle = find(descriptor, "mmap");
  if (!handle) return {nullptr, EBADF};
  if (handle->is_dead()) return {nullptr, ENODEV};
  if (const auto error = failure(*handle->camera, Call::kMap)) return {nullptr, *error};
  const auto index = static_cast<std::size_t>(offset / kPage);
  if (index >= handle->buffers.size() || length != handle->size) return {nullptr, EINVAL};
  // Memory of its own pages: who reads a buffer after it was unmapped dies of it.
  void* memory = ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return {nullptr, ENOMEM};
  handle->buffers[index].memory = {static_cast<std::uint8_t*>(memory), length};
  mapped_[memory] = length;
  return {memory, 0};
}

int ScriptedCalls::munmap(void* memory, std::size_t length) noexcept {
  const HeapUse use(allocations);
  ++calls;
  const auto found = mapped_.find(memory);
  if (found == mapped_.end() || found->second != length) {
    violations.emplace_back("munmap of what is not mapped");
    return -EINVAL;
  }
  for (auto& [descriptor, handle] : handles_) {
    for (Buffer& buffer : handle.buffers) {
      if (buffer.memory.data() == memory) buffer.memory = {};
    }
  }
  ::munmap(memory, length);
  mapped_.erase(found);
  return 0;
}

int ScriptedCalls::poll(int descriptor) noexcept {
  const HeapUse use(allocations);
  Handle* handle = find(descriptor, "poll");
  if (!handle) return POLLNVAL;
  if (handle->is_dead()) return POLLERR | POLLHUP;
  if (const auto events = failure(*handle->camera, Call::kPoll)) return *events;
  if (!handle->streaming) return POLLERR;
  produce(*handle);
  return handle->done.empty() ? 0 : POLLIN;
}

int ScriptedCalls::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  const HeapUse use(allocations);
  Handle* handle = find(descriptor, "ioctl");
  if (!handle) return -EBADF;
  if (handle->is_dead()) return -ENODEV;
  if (const auto call = call_of(request)) {
    if (const auto error = failure(*handle->camera, *call)) return -*error;
  }
  produce(*handle);
  return answer(*handle, request, argument);
}

int ScriptedCalls::answer(Handle& handle, unsigned long request, void* argument) {
  ScriptedCamera& camera = *handle.camera;
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& capability = *static_cast<v4l2_capability*>(argument);
      std::strcpy(reinterpret_cast<char*>(capability.card), "Scripted camera");
      std::strcpy(reinterpret_cast<char*>(capability.bus_info), "usb-script-1");
      capability.capabilities = V4L2_CAP_DEVICE_CAPS | V4L2_CAP_VIDEO_OUTPUT | camera.capabilities;
      capability.device_caps = camera.capabilities;
      return 0;
    }
    case VIDIOC_ENUM_FMT:
      return enumerate_formats(camera, *static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return enumerate_sizes(camera, *static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return enumerate_intervals(camera, *static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_S_FMT:
      return set_format(handle, argument);
    case VIDIOC_G_PARM:
      return set_rate(handle, argument, false);
    case VIDIOC_S_PARM:
      return set_rate(handle, argument, true);
    case VIDIOC_QUERY_EXT_CTRL:
      return query_control(handle, argument);
    case VIDIOC_S_EXT_CTRLS:
      return set_controls(handle, argument, true);
    case VIDIOC_G_EXT_CTRLS:
      return set_controls(handle, argument, false);
    case VIDIOC_REQBUFS:
      return request_buffers(handle, argument);
    case VIDIOC_QUERYBUF:
      return query_buffer(handle, argument);
    case VIDIOC_QBUF:
      return queue(handle, argument);
    case VIDIOC_DQBUF:
      return dequeue(handle, argument);
    case VIDIOC_STREAMON:
      return start(handle);
    case VIDIOC_STREAMOFF:
      return stop(handle);
    default:
      return -ENOTTY;
  }
}

int ScriptedCalls::set_format(Handle& handle, void* argument) {
  auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
  ScriptedCamera& camera = *handle.camera;
  if (!handle.buffers.empty()) return -EBUSY;
  // What is not offered is silently replaced, as drivers do.
  camera.set = camera.offers.front();
  for (const auto& offer : camera.offers) {
    if (offer.code == pix.pixelformat && static_cast<std::uint32_t>(offer.width) == pix.width &&
        static_cast<std::uint32_t>(offer.height) == pix.height)
      camera.set = offer;
  }
  camera.rate = std::min(camera.rate, camera.set->most_rate);
  const std::size_t row = row_of(*camera.set);
  const bool is_jpeg = row == 0;
  handle.stride = is_jpeg ? 0 : row + camera.padding;
  handle.size = is_jpeg ? 1 << 16 : plain_bytes(*camera.set, handle.stride);
  pix.pixelformat = camera.set->code;
  pix.width = static_cast<std::uint32_t>(camera.set->width);
  pix.height = static_cast<std::uint32_t>(camera.set->height);
  pix.field = camera.interlaced ? V4L2_FIELD_INTERLACED : V4L2_FIELD_NONE;
  pix.bytesperline = static_cast<std::uint32_t>(handle.stride);
  pix.sizeimage = static_cast<std::uint32_t>(handle.size);
  return 0;
}

int ScriptedCalls::set_rate(Handle& handle, void* argument, bool set) {
  auto& capture = static_cast<v4l2_streamparm*>(argument)->parm.capture;
  ScriptedCamera& camera = *handle.camera;
  if (!camera.can_set_rate) return -ENOTTY;
  if (set && capture.timeperframe.numerator > 0) {
    const double asked =
        static_cast<double>(capture.timeperframe.denominator) / capture.timeperframe.numerator;
    camera.rate = std::min(asked, camera.set ? camera.set->most_rate : asked);
  }
  capture.capability = V4L2_CAP_TIMEPERFRAME;
  capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(camera.rate * 1000))};
  return 0;
}

int ScriptedCalls::query_control(Handle& handle, void* argument) {
  auto& query = *static_cast<v4l2_query_ext_ctrl*>(argument);
  const auto found = handle.camera->controls.find(query.id);
  if (found == handle.camera->controls.end()) return -EINVAL;
  query.minimum = found->second.least;
  query.maximum = found->second.most;
  query.step = static_cast<std::uint64_t>(found->second.step);
  return 0;
}

int ScriptedCalls::set_controls(Handle& handle, void* argument, bool set) {
  auto& all = *static_cast<v4l2_ext_controls*>(argument);
  ScriptedCamera& camera = *handle.camera;
  if (set) ++camera.control_calls;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    v4l2_ext_control& one = all.controls[i];
    const auto found = camera.controls.find(one.id);
    all.error_idx = i;
    if (found == camera.controls.end()) return -EINVAL;
    ScriptedCamera::Control& control = found->second;
    const bool is_deaf =
        std::find(camera.deaf_to.begin(), camera.deaf_to.end(), one.id) != camera.deaf_to.end();
    if (set && !is_deaf) {
      if (one.id == V4L2_CID_EXPOSURE_ABSOLUTE &&
          camera.controls.at(V4L2_CID_EXPOSURE_AUTO).value != V4L2_EXPOSURE_MANUAL)
        return -EACCES;
      const std::int32_t steps = (one.value - control.least + control.step / 2) / control.step;
      control.value = std::clamp(control.least + steps * control.step, control.least, control.most);
      if (one.id == V4L2_CID_EXPOSURE_ABSOLUTE)
        camera.exposure = control.value * std::chrono::microseconds(100);
    }
    one.value = control.value;
  }
  return 0;
}

int ScriptedCalls::request_buffers(Handle& handle, void* argument) {
  auto& request = *static_cast<v4l2_requestbuffers*>(argument);
  if (handle.size == 0) return -EINVAL;
  for (const auto& [descriptor, other] : handles_) {
    if (&other != &handle && other.camera == handle.camera && !other.buffers.empty() && !other.is_dead())
      return -EBUSY;
  }
  if (handle.camera->fewest_buffers != 0) request.count = handle.camera->fewest_buffers;
  handle.buffers.assign(request.count, {});
  return 0;
}

int ScriptedCalls::query_buffer(Handle& handle, void* argument) {
  auto& buffer = *static_cast<v4l2_buffer*>(argument);
  if (buffer.index >= handle.buffers.size()) return -EINVAL;
  buffer.length = static_cast<std::uint32_t>(handle.size);
  buffer.m.offset = static_cast<std::uint32_t>(buffer.index * kPage);
  buffer.flags =
      handle.camera->foreign_clock ? V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN : V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  return 0;
}

int ScriptedCalls::queue(Handle& handle, void* argument) {
  const auto& buffer = *static_cast<v4l2_buffer*>(argument);
  if (buffer.index >= handle.buffers.size()) return -EINVAL;
  Buffer& own = handle.buffers[buffer.index];
  if (own.owner != Buffer::Owner::kProgram || own.memory.empty()) {
    violations.emplace_back("queued a buffer that is not the program's, or not mapped");
    return -EINVAL;
  }
  std::memset(own.memory.data(), kPoison, own.memory.size());
  own.owner = Buffer::Owner::kQueued;
  handle.queued.push_back(buffer.index);
  return 0;
}

int ScriptedCalls::dequeue(Handle& handle, void* argument) {
  if (!handle.streaming) return -EINVAL;
  if (handle.done.empty()) return -EAGAIN;
  auto& buffer = *static_cast<v4l2_buffer*>(argument);
  buffer.index = handle.done.front();
  handle.done.pop_front();
  Buffer& own = handle.buffers[buffer.index];
  own.owner = Buffer::Owner::kProgram;
  buffer.bytesused = static_cast<std::uint32_t>(own.bytes);
  buffer.flags = own.flags;
  buffer.sequence = own.sequence;
  buffer.timestamp.tv_sec = own.stamp / std::chrono::seconds(1);
  buffer.timestamp.tv_usec = own.stamp % std::chrono::seconds(1) / std::chrono::microseconds(1);
  return 0;
}

int ScriptedCalls::start(Handle& handle) {
  if (handle.buffers.empty()) return -EINVAL;
  handle.streaming = true;
  handle.camera->is_streaming = true;
  ++handle.camera->starts;
  handle.sequence = 0;
  handle.next = clock_.now() + handle.camera->start_up;
  return 0;
}

int ScriptedCalls::stop(Handle& handle) {
  handle.streaming = false;
  handle.camera->is_streaming = false;
  handle.queued.clear();
  handle.done.clear();
  for (Buffer& buffer : handle.buffers) buffer.owner = Buffer::Owner::kProgram;
  return 0;
}

void ScriptedCalls::produce(Handle& handle) {
  if (!handle.streaming) return;
  for (; handle.next <= clock_.now(); handle.next += handle.camera->period()) make_frame(handle);
}

void ScriptedCalls::make_frame(Handle& handle) {
  ScriptedCamera& camera = *handle.camera;
  if (camera.silent) return;
  if (std::exchange(camera.count_anew, false)) handle.sequence = 0;
  const std::uint32_t sequence = handle.sequence++;
  ++camera.made;
  camera.middles.push_back(handle.next - camera.readout - camera.exposure / 2);
  if (camera.lose > 0) {
    --camera.lose;
    return;
  }
  if (handle.queued.empty()) return;
  const std::uint32_t index = handle.queued.front();
  handle.queued.pop_front();
  handle.done.push_back(index);
  Buffer& buffer = handle.buffers[index];
  buffer.owner = Buffer::Owner::kDone;
  buffer.sequence = sequence;
  buffer.bytes = camera.paint ? camera.paint(buffer.memory, camera.made) : buffer.memory.size();
  if (!camera.paint)
    std::memset(buffer.memory.data(), static_cast<int>(camera.made % 200), buffer.memory.size());
  if (camera.half) buffer.bytes /= 2;
  buffer.bytes += camera.extra_bytes;
  buffer.flags = camera.foreign_clock ? V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN : V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  buffer.flags |= camera.stamps_at_start ? V4L2_BUF_FLAG_TSTAMP_SRC_SOE : V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  if (camera.marked) buffer.flags |= V4L2_BUF_FLAG_ERROR;
  const Time at = camera.stamps_at_start ? handle.next - camera.readout - camera.exposure : handle.next;
  if (!camera.frozen) camera.last_stamp = at.time_since_epoch() + camera.stamp_shift;
  buffer.stamp = camera.last_stamp;
}

}  // namespace headway::drivers::testing
