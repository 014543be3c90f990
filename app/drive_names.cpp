#include "app/drive_names.h"

#include <algorithm>

#include <fmt/format.h>

namespace headway::app {

namespace {

using Status = drivers::SdoText::Status;

struct Object {
  std::uint16_t index;
  const char* label;
};
constexpr std::array<Object, 3> kObjects{{{0x1008, ""}, {0x1009, "hardware "}, {0x100A, "software "}}};

}  // namespace

void DriveNames::start() noexcept {
  if (is_started_) return;
  is_started_ = true;
  sdo_.read(kObjects[0].index);
}

void DriveNames::tick(Time now) noexcept {
  if (!is_started_ || next_ == kObjects.size()) return;
  sdo_.tick(now);
  if (sdo_.status() == Status::kBusy) return;
  if (sdo_.status() == Status::kDone) std::ranges::copy(sdo_.text(), texts_[next_].begin());
  if (++next_ < kObjects.size()) sdo_.read(kObjects[next_].index);
}

std::string DriveNames::text() const {
  std::string all;
  for (std::size_t i = 0; i < kObjects.size(); ++i)
    if (texts_[i][0] != '\0')
      all += fmt::format("{}{}{}", all.empty() ? "" : ", ", kObjects[i].label, texts_[i].data());
  return all;
}

}  // namespace headway::app
