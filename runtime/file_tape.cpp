#include "runtime/file_tape.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "config/write_fault.h"

namespace headway::runtime {

namespace {

namespace fs = std::filesystem;

/// "NAME_0001" with the lowest number after all those in the folder.
std::string free_stem(const fs::path& folder, const std::string& name) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) config::fail_to_write(folder, "cannot be made", error.value());
  int highest = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string file = entry.path().filename().string();
    if (!file.starts_with(name + "_")) continue;
    highest = std::max(highest, std::atoi(file.c_str() + name.size() + 1));
  }
  if (error) config::fail_to_write(folder, "cannot be listed", error.value());
  return fmt::format("{}_{:04}", name, highest + 1);
}

}  // namespace

FileTape::FileTape(FileTapeConfig config, Preface preface, Time begins)
    : config_(std::move(config)),
      preface_(std::move(preface)),
      stem_(free_stem(config_.folder, config_.name)) {
  begin(begins);
}

void FileTape::begin(Time t) {
  file_ = config_.folder / fmt::format("{}_{:02}.mcap", stem_, part_);
  sink_ = config_.make(file_);
  writer_ = begin_file(*sink_, preface_, {{"part", std::to_string(part_)}}, t);
  sink_->sync();
  ++part_;
}

template <class Work>
void FileTape::guarded(Work&& work) {
  if (broken_) return;
  try {
    work();
  } catch (...) {
    broken_ = true;
    writer_->cut_short();
    throw;
  }
}

bool FileTape::put(const Row& row) {
  bool another = false;
  guarded([&] {
    if (writer_->size() >= config_.rotate) {
      writer_->finish();
      bytes_before_ += writer_->size();
      begin(row.time);
      another = true;
    }
    write(*writer_, row);
    empty_ = false;
  });
  return another;
}

void FileTape::tend(Time now) {
  guarded([&] {
    if (now - last_sync_ < config_.sync_every || writer_->size() == synced_size_) return;
    sink_->sync();
    last_sync_ = now;
    synced_size_ = writer_->size();
  });
}

void FileTape::finish() {
  guarded([&] { writer_->finish(); });
  broken_ = true;
  std::error_code ignored;
  if (empty_) fs::remove(file_, ignored);
}

}  // namespace headway::runtime
