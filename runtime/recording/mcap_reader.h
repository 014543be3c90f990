// Reads an MCAP file (mcap.dev/spec): by its index where it is whole, and up to its last whole chunk where it
// was cut short or damaged. Nothing that a length promises is allocated before it is known to be there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "hal/time.h"
#include "runtime/recording/byte_source.h"
#include "runtime/recording/mcap_format.h"

namespace headway::recording {

/// A message; its bytes hold during the call that it is handed to.
struct McapMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  Time log_time{}, publish_time{};
  std::span<const std::byte> bytes;
};

/// What could not be read.
struct McapLoss {
  std::uint64_t at = 0, bytes = 0;  ///< where in the file, and how much of it
  std::string what;
};

struct McapAttachment {
  McapAttachmentIndex index;
  std::vector<std::byte> data;
};

class McapReader {
 public:
  /// Larger chunks, or attachments, are taken for damage: recordings have chunks of about 1 MiB.
  static constexpr std::uint64_t kLargest = std::uint64_t{256} << 20;

  /// `name` stands in messages. Throws InputError where it is no MCAP file at all.
  McapReader(std::unique_ptr<ByteSource> source, std::string name);
  /// Throws InputError too where the file cannot be opened.
  explicit McapReader(const std::filesystem::path& file)
      : McapReader(std::make_unique<FileSource>(file), file.string()) {}
  ~McapReader();

  const std::string& name() const { return name_; }
  const std::string& profile() const { return profile_; }
  const std::string& library() const { return library_; }
  /// Whether it has been ended as it should; else it was read from its start as far as that goes.
  bool has_end() const { return statistics_.has_value(); }
  /// Of what has an end.
  const std::optional<McapStatistics>& statistics() const { return statistics_; }
  const std::map<std::uint16_t, McapSchema>& schemas() const { return schemas_; }
  const std::map<std::uint16_t, McapChannel>& channels() const { return channels_; }
  const std::vector<McapChunkIndex>& chunks() const { return chunks_; }
  const std::vector<McapAttachmentIndex>& attachments() const { return attachments_; }
  /// Grows as chunks are found to be damaged.
  const std::vector<McapLoss>& losses() const { return losses_; }

  /// The channel of a topic, if there is one.
  std::optional<std::uint16_t> channel(std::string_view topic) const;

  /// Calls visit(message) for each message of these channels (empty: of all), in the order of the file. A
  /// chunk that is damaged is left out, and becomes a loss; what visit throws gets out.
  void for_each(const std::set<std::uint16_t>& channels,
                const std::function<void(const McapMessage&)>& visit);
  /// Of the first attachment of that name. Nothing where there is none, or it is damaged: then a loss.
  std::optional<McapAttachment> attachment(std::string_view name);
  std::optional<McapAttachment> attachment(const McapAttachmentIndex& index);
  /// The first metadata of that name.
  std::optional<std::map<std::string, std::string>> metadata(std::string_view name);
  /// Whether all bytes are those that were written, by the sum at the file's end; nothing without one.
  std::optional<bool> sum_is_right() const;

 private:
  struct Record {
    Op op{};
    std::uint64_t at = 0, bytes = 0;  ///< head included
    std::uint64_t content() const { return at + kRecordHead; }
    std::uint64_t content_bytes() const { return bytes - kRecordHead; }
  };
  class Decompressor;

  std::optional<Record> record_at(std::uint64_t at, std::uint64_t end) const;
  std::optional<std::vector<std::byte>> content_of(const Record& record) const;
  bool read_header();
  bool read_summary();
  void scan();
  bool take(const Record& record);
  bool take_chunk_head(const Record& record);
  bool take_indexed(Op op, std::span<const std::byte> content);
  void lose(std::uint64_t at, std::uint64_t bytes, std::string what);
  std::optional<std::vector<std::byte>> records_of(const McapChunkIndex& chunk);

  std::unique_ptr<ByteSource> source_;
  std::string name_, profile_, library_;
  std::uint64_t data_begin_ = 0, data_end_ = 0;
  std::uint32_t data_sum_ = 0;
  std::unique_ptr<Decompressor> decompressor_;
  std::optional<McapStatistics> statistics_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::vector<McapChunkIndex> chunks_;
  std::vector<McapAttachmentIndex> attachments_;
  std::vector<McapMetadataIndex> metadata_;
  std::vector<McapLoss> losses_;
};

}  // namespace headway::recording
