#include "drivers/v4l2_stream.h"

#include <algorithm>
#include <cerrno>

#include <linux/videodev2.h>
#include <poll.h>

namespace headway::drivers {

namespace {

using Step = V4l2Fault::Step;

v4l2_buffer buffer_of(std::uint32_t index) noexcept {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

bool is_monotonic(const v4l2_buffer& buffer) noexcept {
  return (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
}

FilledBuffer filled(const v4l2_buffer& buffer) noexcept {
  using StampAt = FilledBuffer::StampAt;
  const bool at_start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return {.index = buffer.index,
          .sequence = buffer.sequence,
          .stamp = std::chrono::seconds(buffer.timestamp.tv_sec) +
                   std::chrono::microseconds(buffer.timestamp.tv_usec),
          .stamp_at = at_start ? StampAt::kStartOfExposure : StampAt::kEndOfFrame,
          .is_monotonic = is_monotonic(buffer),
          .is_marked = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0,
          .bytes = buffer.bytesused};
}

}  // namespace

std::optional<V4l2Stream> V4l2Stream::open(DeviceCalls& calls, const V4l2CameraConfig& config,
                                           V4l2Fault& fault) noexcept {
  const int descriptor = calls.open(config.path.c_str());
  if (descriptor < 0) {
    fault = {.step = Step::kOpen, .error = -descriptor};
    return std::nullopt;
  }
  V4l2Stream stream(OpenedDevice(calls, descriptor));
  fault = set_up(stream.device_, config, stream.settings_);
  if (!fault) fault = stream.map_buffers();
  if (!fault) fault = stream.start();
  if (fault) return std::nullopt;
  return stream;
}

V4l2Fault V4l2Stream::map_buffers() noexcept {
  v4l2_requestbuffers request{};
  request.count = kBuffers;
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int result = device_.ioctl(VIDIOC_REQBUFS, &request); result < 0)
    return {.step = Step::kBuffers, .error = -result};
  if (request.count < kBuffers) return {.step = Step::kBuffers};
  for (std::uint32_t i = 0; i < kBuffers; ++i) {
    v4l2_buffer buffer = buffer_of(i);
    if (const int result = device_.ioctl(VIDIOC_QUERYBUF, &buffer); result < 0)
      return {.step = Step::kBuffers, .error = -result};
    if (!is_monotonic(buffer)) return {.step = Step::kBuffers};
    const auto mapped = device_.mmap(buffer.length, buffer.m.offset);
    if (mapped.error != 0) return {.step = Step::kBuffers, .error = mapped.error};
    buffers_[i] = MappedMemory(device_.calls(), mapped.memory, buffer.length);
  }
  return {};
}

V4l2Fault V4l2Stream::start() noexcept {
  for (std::uint32_t i = 0; i < kBuffers; ++i) {
    if (const int result = queue(i); result < 0) return {.step = Step::kStart, .error = -result};
  }
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int result = device_.ioctl(VIDIOC_STREAMON, &type); result < 0)
    return {.step = Step::kStart, .error = -result};
  return {};
}

int V4l2Stream::queue(std::uint32_t index) noexcept {
  v4l2_buffer buffer = buffer_of(index);
  return device_.ioctl(VIDIOC_QBUF, &buffer);
}

bool V4l2Stream::fail(int error) noexcept {
  fault_ = {.step = Step::kFrames, .error = error};
  return false;
}

V4l2Stream::Taken V4l2Stream::take(FilledBuffer& into) noexcept {
  // Taking without asking first could hang after an unplug with some drivers, non-blocking or not.
  const int ready = device_.poll();
  if (ready < 0 || (ready & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
    fail(ready < 0 ? -ready : (ready & POLLHUP) != 0 ? ENODEV : EIO);
    return Taken::kFailed;
  }
  if ((ready & POLLIN) == 0) return Taken::kNothing;
  v4l2_buffer buffer = buffer_of(0);
  const int result = device_.ioctl(VIDIOC_DQBUF, &buffer);
  if (result == -EAGAIN) return Taken::kNothing;
  if (result < 0 || buffer.index >= kBuffers) {
    fail(result < 0 ? -result : EIO);
    return Taken::kFailed;
  }
  into = filled(buffer);
  return Taken::kFrame;
}

std::span<const std::uint8_t> V4l2Stream::data(const FilledBuffer& buffer) const noexcept {
  const std::span<const std::uint8_t> all = buffers_[buffer.index].bytes();
  return all.first(std::min(buffer.bytes, all.size()));
}

bool V4l2Stream::give_back(const FilledBuffer& buffer) noexcept {
  const int result = queue(buffer.index);
  return result >= 0 || fail(-result);
}

bool V4l2Stream::restart() noexcept {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int result = device_.ioctl(VIDIOC_STREAMOFF, &type); result < 0) return fail(-result);
  fault_ = start();
  return !fault_;
}

}  // namespace headway::drivers
