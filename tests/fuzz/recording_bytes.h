// Any bytes as a recording: what fuzzers throw at its reader and at the readers of its messages, and small
// whole files to begin with.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/error.h"
#include "runtime/preface.h"
#include "runtime/recorded_values.h"
#include "runtime/recording/mcap_reader.h"
#include "tests/runtime/memory_sink.h"

namespace headway::fuzz {

/// Reads whatever it is as a message of each kind.
inline void read_messages(std::span<const std::byte> bytes) {
  const auto read = [&]<class Message>(Message) {
    try {
      recording::to_cdr(recording::from_cdr<Message>(bytes));
    } catch (const recording::CdrError&) {
    }
  };
  namespace ros = recording::ros;
  namespace recorded = runtime::recorded;
  read(recorded::Work{});
  read(recorded::BusReport{});
  read(recorded::Goal{});
  read(ros::Image{});
  read(ros::OccupancyGrid{});
  read(ros::CanFrame{});
}

/// True when it is taken for a recording, however damaged, false when it was refused with InputError; lets
/// every other exception out.
inline bool is_recording(std::span<const std::byte> bytes) {
  try {
    recording::McapReader reader(std::make_unique<recording::MemorySource>(bytes), "fuzz.mcap");
    reader.for_each({}, [](const recording::McapMessage& message) { read_messages(message.bytes); });
    for (const recording::McapAttachmentIndex& index : std::vector(reader.attachments()))
      reader.attachment(index);
    reader.metadata(runtime::kFactsName);
    static_cast<void>(reader.sum_is_right());
    return true;
  } catch (const InputError&) {
    read_messages(bytes);
    return false;
  }
}

/// A whole file, one that was cut, and one of its messages.
inline std::vector<std::string> whole_recordings() {
  recording::MemorySink sink;
  runtime::Preface preface;
  preface.files.push_back({"robot.yaml", "application/yaml", std::vector<std::byte>(20, std::byte{'a'})});
  const auto writer = runtime::begin_file(sink, preface, {}, {}, {.chunk_bytes = 300});
  runtime::recorded::Work work;
  work.chest.resize(1);
  work.report.push_back(runtime::to_recorded(runtime::BusReport{}));
  work.order.resize(1);
  work.order[0].plan.steps.resize(2);
  const auto cdr = recording::to_cdr(work);
  for (std::uint32_t i = 0; i < 3; ++i)
    runtime::write(*writer, {runtime::Topic::kWork, i, Time(Duration(i)), cdr});
  writer->finish();
  const auto text = [](std::span<const std::byte> bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  return {text(sink.bytes), text(std::span(sink.bytes).first(sink.bytes.size() * 2 / 3)), text(cdr)};
}

}  // namespace headway::fuzz
