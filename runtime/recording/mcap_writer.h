// Writes an MCAP file (mcap.dev/spec) of profile ros2: messages in compressed chunks with all indexes and
// sums. What was handed to the sink up to a chunk's end can be read whatever happens later.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time.h"
#include "runtime/recording/byte_sink.h"
#include "runtime/recording/cdr.h"
#include "runtime/recording/mcap_format.h"

namespace headway::recording {

struct McapWriterConfig {
  std::size_t chunk_bytes = 1 << 20;   ///< a chunk ends when its records have so many, uncompressed
  Duration chunk_time = seconds(0.5);  ///< or when its messages span so long
  int level = 1;                       ///< of zstd
  std::string library = "headway";
};

/// One thread. After a call has thrown (the sink's exception), only cut_short() may follow.
class McapWriter {
 public:
  /// Writes the header. The sink must outlive it.
  explicit McapWriter(ByteSink& sink, McapWriterConfig config = {});
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// A new topic, outside of chunks: its description is not lost with one of them. Returns its number.
  /// `schema`: the message's full name and its ros2msg text.
  std::uint16_t add_channel(std::string_view topic, std::string_view schema_name, std::string_view schema);
  template <CdrMessage T>
  std::uint16_t add_channel(std::string_view topic) {
    return add_channel(topic, T::kName, ros2msg<T>());
  }

  /// A message in CDR on a channel that add_channel returned.
  void write(std::uint16_t channel, std::uint32_t sequence, Time log_time, Time publish_time,
             std::span<const std::byte> cdr);
  void attach(std::string_view name, std::string_view media_type, Time log_time,
              std::span<const std::byte> data);
  void add_metadata(std::string_view name, const std::map<std::string, std::string>& values);

  /// Ends the chunk, if it holds anything.
  void end_chunk();
  /// Ends the file: indexes, statistics and sums.
  void finish();
  /// After the sink has thrown: takes back what is not whole, and tries to end the file there. False where
  /// the sink does not let it: then the file has no end, and is read up to its last whole chunk.
  bool cut_short() noexcept;

  /// Bytes handed to the sink.
  std::uint64_t size() const { return size_; }
  /// Bytes of the chunk that has not ended.
  std::size_t waiting() const;

 private:
  class Compressor;
  struct Chunk;

  void emit(std::span<const std::byte> bytes);
  void emit_record(std::size_t begin);
  void write_summary();
  void write_end();

  ByteSink& sink_;
  McapWriterConfig config_;
  std::unique_ptr<Compressor> compressor_;
  std::unique_ptr<Chunk> chunk_;
  std::vector<std::byte> bytes_;  ///< the record in the making
  std::uint64_t size_ = 0;
  std::uint32_t sum_ = 0;  ///< CRC-32 of all bytes so far
  std::vector<McapSchema> schemas_;
  std::vector<McapChannel> channels_;
  std::vector<McapChunkIndex> chunks_;
  std::vector<McapAttachmentIndex> attachments_;
  std::vector<McapMetadataIndex> metadata_;
  McapStatistics statistics_;
  /// The file up to here is whole, and its sum.
  std::uint64_t whole_ = 0;
  std::uint32_t whole_sum_ = 0;
};

}  // namespace headway::recording
