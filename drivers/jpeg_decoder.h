// JPEG images to grey values, with libjpeg-turbo.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "hal/frame.h"

namespace headway::drivers {

/// One per camera: it keeps libjpeg-turbo's tables from frame to frame. The library itself allocates per
/// image.
class JpegDecoder {
 public:
  /// Throws Error when there is no memory for it.
  JpegDecoder();

  /// The luma of an image of `width` x `height` [px]; frames without Huffman tables, as cameras send them,
  /// are read with the standard's. False when the data is no such image, or is not whole; then what `into`
  /// holds means nothing.
  bool decode(std::span<const std::uint8_t> data, int width, int height, hal::GrayImage& into);

 private:
  bool decompress(std::span<const std::uint8_t> data, int width, int height, hal::GrayImage& into);

  struct Destroy {
    void operator()(void* handle) const noexcept;
  };
  std::unique_ptr<void, Destroy> handle_;
};

}  // namespace headway::drivers
