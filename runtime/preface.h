// What stands at the beginning of each file of a recording, so that each can be understood by itself.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/recording/mcap_writer.h"
#include "runtime/topics.h"

namespace headway::runtime {

struct Preface {
  struct File {
    std::string name, media_type;
    std::vector<std::byte> bytes;
  };
  struct Message {
    Topic topic{};
    std::vector<std::byte> cdr;
  };
  std::vector<File> files;                   ///< become attachments
  std::map<std::string, std::string> facts;  ///< become the metadata "headway"
  std::vector<Message> messages;  ///< that hold from the beginning on, like the cameras' calibration
};

/// The metadata's name.
inline constexpr const char* kFactsName = "headway";

/// A writer with all topics, numbered as Topic is, and the preface at `begin`. Throws as the sink does.
std::unique_ptr<recording::McapWriter> begin_file(recording::ByteSink& sink, const Preface& preface,
                                                  const std::map<std::string, std::string>& more_facts,
                                                  Time begin, const recording::McapWriterConfig& config = {});

inline void write(recording::McapWriter& writer, const Row& row) {
  writer.write(static_cast<std::uint16_t>(row.topic), row.sequence, row.time, row.time, row.cdr);
}

}  // namespace headway::runtime
