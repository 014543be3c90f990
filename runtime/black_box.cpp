#include "runtime/black_box.h"

#include <algorithm>
#include <utility>

#include "runtime/file_tape.h"

namespace headway::runtime {

Row RowRing::at(std::size_t i) const { return entries_[(first_ + i) % entries_.size()].row; }

void RowRing::forget_oldest() {
  first_ = (first_ + 1) % entries_.size();
  --count_;
}

/// Rows lie one behind another, and go on at the front where the end is too near.
bool RowRing::put(const Row& row) {
  const std::size_t size = row.cdr.size();
  if (size > bytes_.size()) return false;
  if (size > bytes_.size() - end_) {
    while (count_ > 0 && oldest().begin >= end_) forget_oldest();
    end_ = 0;
  }
  const auto in_the_way = [&] {
    if (count_ == entries_.size()) return true;
    return count_ > 0 && oldest().begin >= end_ && oldest().begin < end_ + std::max<std::size_t>(size, 1);
  };
  while (in_the_way()) forget_oldest();
  std::ranges::copy(row.cdr, bytes_.begin() + static_cast<std::ptrdiff_t>(end_));
  Entry& entry = entries_[(first_ + count_) % entries_.size()];
  entry = {row, end_};
  entry.row.cdr = std::span(bytes_).subspan(end_, size);
  ++count_;
  end_ += size;
  return true;
}

namespace {

constexpr std::size_t kRowsKept = 1 << 17, kPicturesKept = 1 << 12;

}  // namespace

BlackBox::BlackBox(BlackBoxConfig config, Preface preface)
    : config_(std::move(config)),
      preface_(std::move(preface)),
      rows_(config_.bytes, kRowsKept),
      pictures_(config_.picture_bytes, kPicturesKept) {}

void BlackBox::put(const Row& row) {
  if (!is_picture(row.topic))
    rows_.put(row);
  else if (keep_picture(row))
    pictures_.put(row);
}

/// Pictures of one time are kept or left out together. They are so far apart that the time asked for fits.
bool BlackBox::keep_picture(const Row& row) {
  if (picture_time_ != row.time) {
    const double share = static_cast<double>(picture_size_) / static_cast<double>(config_.picture_bytes);
    if (picture_time_ && to_seconds(row.time - *picture_time_) < share * to_seconds(config_.span))
      return false;
    picture_time_ = row.time;
    picture_size_ = 0;
  }
  picture_size_ += row.cdr.size();
  return true;
}

std::optional<std::filesystem::path> BlackBox::write(const std::string& fault, Time now) {
  if (written_ && now - *written_ < config_.apart) return std::nullopt;
  written_ = now;
  Preface preface = preface_;
  preface.facts["fault"] = fault;
  FileTape tape({.folder = config_.folder, .name = "black_box", .rotate = UINT64_MAX}, std::move(preface),
                std::max(Time{}, now - config_.span));
  const auto is_old = [&](const Row& row) { return row.time < now - config_.span; };
  // Both rings in one order, by time: what stands side by side in a file happened at one time.
  for (std::size_t i = 0, k = 0; i < rows_.size() || k < pictures_.size();) {
    const bool picture =
        i == rows_.size() || (k < pictures_.size() && pictures_.at(k).time <= rows_.at(i).time);
    const Row row = picture ? pictures_.at(k++) : rows_.at(i++);
    if (!is_old(row)) tape.put(row);
  }
  tape.finish();
  return tape.file();
}

}  // namespace headway::runtime
