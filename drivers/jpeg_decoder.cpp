#include "drivers/jpeg_decoder.h"

#include <turbojpeg.h>

#include "hal/error.h"

namespace headway::drivers {

void JpegDecoder::Destroy::operator()(void* handle) const noexcept { tjDestroy(handle); }

JpegDecoder::JpegDecoder() : handle_(tjInitDecompress()) {
  if (!handle_) throw Error("JPEG decoder: there is not enough memory for libjpeg-turbo");
}

bool JpegDecoder::decode(std::span<const std::uint8_t> data, int width, int height, hal::GrayImage& into) {
  if (handle_ && decompress(data, width, height, into)) return true;
  // After a header that broke off, libjpeg-turbo 2.1 reads the next image as if it were the rest of that one.
  handle_.reset(tjInitDecompress());
  return false;
}

bool JpegDecoder::decompress(std::span<const std::uint8_t> data, int width, int height,
                             hal::GrayImage& into) {
  int got_width = 0, got_height = 0, sampling = 0, colours = 0;
  const auto size = static_cast<unsigned long>(data.size());
  if (tjDecompressHeader3(handle_.get(), data.data(), size, &got_width, &got_height, &sampling, &colours) !=
      0)
    return false;
  if (got_width != width || got_height != height) return false;
  into.width = width;
  into.height = height;
  into.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // A warning means that data is missing or spoilt; what would come out is grey where the rest should be.
  return tjDecompress2(handle_.get(), data.data(), size, into.pixels.data(), width, width, height, TJPF_GRAY,
                       TJFLAG_STOPONWARNING) == 0;
}

}  // namespace headway::drivers
