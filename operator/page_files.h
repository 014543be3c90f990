// The page as it stands in the program.
#pragma once

#include <span>
#include <string_view>

namespace headway::remote {

struct PageFile {
  std::string_view path, mime, etag;  ///< "/page.js"; the etag with its quotes
  std::span<const unsigned char> gzip;
};

/// Empty where the program was configured without the page.
std::span<const PageFile> page_files();

}  // namespace headway::remote
