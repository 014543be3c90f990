// What an MCAP file is made of (mcap.dev/spec, version 0): records, their numbers, and how values lie in
// them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "hal/time.h"

namespace headway::recording {

enum class Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Both ends of a file.
inline constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', 0x30, '\r', '\n'};
/// Number and length, before each record's content.
inline constexpr std::size_t kRecordHead = 9;
/// The footer record, head included.
inline constexpr std::size_t kFooterSize = kRecordHead + 20;

struct McapSchema {
  std::uint16_t id = 0;
  std::string name, encoding, text;
};

struct McapChannel {
  std::uint16_t id = 0, schema = 0;
  std::string topic, encoding;
  std::map<std::string, std::string> metadata;
};

struct McapChunkIndex {
  Time first{}, last{};             ///< log times of its messages
  std::uint64_t at = 0, bytes = 0;  ///< of the chunk record, head included
  std::map<std::uint16_t, std::uint64_t>
      message_indexes;            ///< where each channel's index lies; empty: not known
  std::uint64_t index_bytes = 0;  ///< of all of those, which follow the chunk
  std::string compression;
  std::uint64_t compressed = 0, uncompressed = 0;  ///< size of its records [bytes]
};

/// A file within the file; or, in an index, where it lies.
struct McapAttachmentIndex {
  std::uint64_t at = 0, bytes = 0;  ///< of the record, head included
  Time log_time{};
  std::uint64_t create_time = 0;
  std::uint64_t data_bytes = 0;
  std::string name, media_type;
};

struct McapMetadataIndex {
  std::uint64_t at = 0, bytes = 0;  ///< of the record, head included
  std::string name;
};

struct McapStatistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  Time first{}, last{};  ///< log times of all messages
  std::map<std::uint16_t, std::uint64_t> channel_messages;
};

}  // namespace headway::recording
