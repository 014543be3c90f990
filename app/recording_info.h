// What a recording holds, topic by topic, and what of it was dropped or lost.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/report.h"
#include "runtime/recorded_messages.h"
#include "runtime/recording/mcap_reader.h"

namespace headway::app {

struct TopicInfo {
  std::string topic, schema;
  std::uint64_t messages = 0, bytes = 0;
  std::uint64_t missing = 0;  ///< numbers that are not there: dropped by the recorder, or in a damaged chunk
  Time first{}, last{};
  Duration longest_gap{};  ///< between two messages

  double rate() const;  ///< [Hz]; 0 for fewer than two messages
};

struct RecordingInfo {
  std::string profile, library;
  bool has_end = false;
  std::optional<bool> sum_is_right;
  std::size_t chunks = 0;
  Time first{}, last{};                           ///< of all messages
  std::vector<TopicInfo> topics;                  ///< that hold messages, by name
  std::optional<runtime::recorded::Drops> drops;  ///< as told last
  std::vector<recording::McapAttachmentIndex> attachments;
  std::map<std::string, std::string> facts;
  std::vector<recording::McapLoss> losses;

  bool whole() const { return has_end && sum_is_right.value_or(true) && losses.empty(); }
};

/// Reads all of it.
RecordingInfo inspect(recording::McapReader& file);

Json to_json(const RecordingInfo& info);
std::string to_text(const RecordingInfo& info);

}  // namespace headway::app
