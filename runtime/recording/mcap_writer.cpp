#include "runtime/recording/mcap_writer.h"

#include <algorithm>
#include <utility>

#include <zlib.h>
#include <zstd.h>

#include "hal/error.h"
#include "runtime/recording/record_bytes.h"

namespace headway::recording {

namespace {

std::uint32_t crc(std::uint32_t before, std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::span<const std::byte> magic() { return std::as_bytes(std::span(kMcapMagic)); }

}  // namespace

class McapWriter::Compressor {
 public:
  explicit Compressor(int level) : context_(ZSTD_createCCtx()) {
    if (context_ == nullptr) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context_, ZSTD_c_compressionLevel, level);
  }
  ~Compressor() { ZSTD_freeCCtx(context_); }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  std::span<const std::byte> compress(std::span<const std::byte> from) {
    into_.resize(ZSTD_compressBound(from.size()));
    const std::size_t size = ZSTD_compress2(context_, into_.data(), into_.size(), from.data(), from.size());
    if (ZSTD_isError(size)) throw Error(std::string("zstd: ") + ZSTD_getErrorName(size));
    return std::span(into_).first(size);
  }

 private:
  ZSTD_CCtx* context_;
  std::vector<std::byte> into_;
};

struct McapWriter::Chunk {
  std::vector<std::byte> records;
  Time first = Time::max(), last = Time::min();
  /// Of each channel: when, and where in `records`.
  std::map<std::uint16_t, std::vector<std::pair<Time, std::uint64_t>>> index;
};

McapWriter::McapWriter(ByteSink& sink, McapWriterConfig config)
    : sink_(sink),
      config_(std::move(config)),
      compressor_(std::make_unique<Compressor>(config_.level)),
      chunk_(std::make_unique<Chunk>()) {
  chunk_->records.reserve(2 * config_.chunk_bytes);
  emit(magic());
  RecordWriter record(bytes_);
  const std::size_t begin = record.begin_record(Op::kHeader);
  record.put(std::string_view("ros2")).put(config_.library);
  emit_record(begin);
}

McapWriter::~McapWriter() = default;

void McapWriter::emit(std::span<const std::byte> bytes) {
  sink_.write(bytes);
  size_ += bytes.size();
  sum_ = crc(sum_, bytes);
}

/// The record that lies in `bytes_`; what is emitted with it is whole.
void McapWriter::emit_record(std::size_t begin) {
  RecordWriter(bytes_).end_record(begin);
  emit(bytes_);
  bytes_.clear();
  whole_ = size_;
  whole_sum_ = sum_;
}

namespace {

void put_schema(RecordWriter& record, const McapSchema& schema) {
  const std::size_t begin = record.begin_record(Op::kSchema);
  record.put(schema.id).put(schema.name).put(schema.encoding).put(schema.text).end_record(begin);
}

void put_channel(RecordWriter& record, const McapChannel& channel) {
  const std::size_t begin = record.begin_record(Op::kChannel);
  record.put(channel.id).put(channel.schema).put(channel.topic).put(channel.encoding).put(channel.metadata);
  record.end_record(begin);
}

}  // namespace

std::uint16_t McapWriter::add_channel(std::string_view topic, std::string_view schema_name,
                                      std::string_view schema) {
  RecordWriter record(bytes_);
  auto known = std::ranges::find(schemas_, schema_name, &McapSchema::name);
  if (known == schemas_.end()) {
    const auto id = static_cast<std::uint16_t>(schemas_.size() + 1);
    known = schemas_.insert(schemas_.end(), {id, std::string(schema_name), "ros2msg", std::string(schema)});
    put_schema(record, *known);
  }
  const auto id = static_cast<std::uint16_t>(channels_.size());
  // The profile asks for the key; the empty list is the default quality of service.
  channels_.push_back({id, known->id, std::string(topic), "cdr", {{"offered_qos_profiles", ""}}});
  statistics_.channel_messages[id] = 0;
  put_channel(record, channels_.back());
  emit(std::exchange(bytes_, {}));
  whole_ = size_;
  whole_sum_ = sum_;
  return id;
}

void McapWriter::write(std::uint16_t channel, std::uint32_t sequence, Time log_time, Time publish_time,
                       std::span<const std::byte> cdr) {
  Chunk& chunk = *chunk_;
  const Time first = std::min(chunk.first, log_time), last = std::max(chunk.last, log_time);
  if (!chunk.records.empty() && last - first > config_.chunk_time) {
    end_chunk();
    chunk.first = chunk.last = log_time;
  } else {
    chunk.first = first;
    chunk.last = last;
  }
  chunk.index[channel].emplace_back(log_time, chunk.records.size());
  RecordWriter record(chunk.records);
  const std::size_t begin = record.begin_record(Op::kMessage);
  record.put(channel).put(sequence).put(log_time).put(publish_time).raw(cdr).end_record(begin);
  if (chunk.records.size() >= config_.chunk_bytes) end_chunk();
}

void McapWriter::end_chunk() {
  Chunk& chunk = *chunk_;
  if (chunk.records.empty()) return;
  McapChunkIndex index{chunk.first, chunk.last, size_, 0, {}, 0, "zstd", 0, chunk.records.size()};
  const auto compressed = compressor_->compress(chunk.records);
  index.compressed = compressed.size();
  RecordWriter record(bytes_);
  std::size_t begin = record.begin_record(Op::kChunk);
  record.put(chunk.first).put(chunk.last).put(index.uncompressed).put(crc(0, chunk.records));
  record.put(index.compression).put(index.compressed).raw(compressed).end_record(begin);
  index.bytes = bytes_.size();
  for (auto& [channel, entries] : chunk.index) {
    if (entries.empty()) continue;
    index.message_indexes[channel] = size_ + bytes_.size();
    begin = record.begin_record(Op::kMessageIndex);
    record.put(channel);
    const std::size_t list = record.begin_length();
    for (const auto& [time, at] : entries) record.put(time).put(at);
    record.end_length(list).end_record(begin);
  }
  index.index_bytes = bytes_.size() - index.bytes;
  emit(bytes_);
  bytes_.clear();
  whole_ = size_;
  whole_sum_ = sum_;
  statistics_.first = statistics_.messages == 0 ? chunk.first : std::min(statistics_.first, chunk.first);
  statistics_.last = statistics_.messages == 0 ? chunk.last : std::max(statistics_.last, chunk.last);
  for (auto& [channel, entries] : chunk.index) {
    statistics_.messages += entries.size();
    statistics_.channel_messages[channel] += entries.size();
    entries.clear();
  }
  chunks_.push_back(std::move(index));
  chunk.records.clear();
  chunk.first = Time::max();
  chunk.last = Time::min();
}

void McapWriter::attach(std::string_view name, std::string_view media_type, Time log_time,
                        std::span<const std::byte> data) {
  McapAttachmentIndex index{size_, 0, log_time, 0, data.size(), std::string(name), std::string(media_type)};
  RecordWriter record(bytes_);
  const std::size_t begin = record.begin_record(Op::kAttachment);
  record.put(log_time).put(index.create_time).put(name).put(media_type).put(index.data_bytes).raw(data);
  record.put(crc(0, std::span(bytes_).subspan(begin)));
  index.bytes = bytes_.size();
  emit_record(begin);
  attachments_.push_back(std::move(index));
}

void McapWriter::add_metadata(std::string_view name, const std::map<std::string, std::string>& values) {
  McapMetadataIndex index{size_, 0, std::string(name)};
  RecordWriter record(bytes_);
  const std::size_t begin = record.begin_record(Op::kMetadata);
  record.put(name).put(values);
  index.bytes = bytes_.size();
  emit_record(begin);
  metadata_.push_back(std::move(index));
}

namespace {

void put_chunk_index(RecordWriter& record, const McapChunkIndex& chunk) {
  const std::size_t begin = record.begin_record(Op::kChunkIndex);
  record.put(chunk.first).put(chunk.last).put(chunk.at).put(chunk.bytes).put(chunk.message_indexes);
  record.put(chunk.index_bytes).put(chunk.compression).put(chunk.compressed).put(chunk.uncompressed);
  record.end_record(begin);
}

void put_attachment_index(RecordWriter& record, const McapAttachmentIndex& file) {
  const std::size_t begin = record.begin_record(Op::kAttachmentIndex);
  record.put(file.at).put(file.bytes).put(file.log_time).put(file.create_time).put(file.data_bytes);
  record.put(file.name).put(file.media_type).end_record(begin);
}

void put_metadata_index(RecordWriter& record, const McapMetadataIndex& metadata) {
  const std::size_t begin = record.begin_record(Op::kMetadataIndex);
  record.put(metadata.at).put(metadata.bytes).put(metadata.name).end_record(begin);
}

void put_statistics(RecordWriter& record, const McapStatistics& all) {
  const std::size_t begin = record.begin_record(Op::kStatistics);
  record.put(all.messages).put(all.schemas).put(all.channels).put(all.attachments).put(all.metadata);
  record.put(all.chunks).put(all.first).put(all.last).put(all.channel_messages).end_record(begin);
}

}  // namespace

void McapWriter::finish() {
  end_chunk();
  write_end();
}

void McapWriter::write_end() {
  RecordWriter record(bytes_);
  const std::size_t begin = record.begin_record(Op::kDataEnd);
  record.put(sum_).end_record(begin);
  emit(bytes_);
  bytes_.clear();
  write_summary();
  sink_.sync();
}

/// The groups of the summary, where each lies, and the footer; in one piece, for its sum.
void McapWriter::write_summary() {
  const std::uint64_t start = size_;
  std::vector<std::byte> offsets;
  RecordWriter record(bytes_), offset(offsets);
  const auto group = [&](Op op, const auto& items, auto put) {
    const std::size_t at = bytes_.size();
    for (const auto& item : items) put(record, item);
    if (bytes_.size() == at) return;
    const std::size_t begin = offset.begin_record(Op::kSummaryOffset);
    offset.put(static_cast<std::uint8_t>(op)).put(start + at).put(std::uint64_t{bytes_.size() - at});
    offset.end_record(begin);
  };
  statistics_.schemas = static_cast<std::uint16_t>(schemas_.size());
  statistics_.channels = static_cast<std::uint32_t>(channels_.size());
  statistics_.attachments = static_cast<std::uint32_t>(attachments_.size());
  statistics_.metadata = static_cast<std::uint32_t>(metadata_.size());
  statistics_.chunks = static_cast<std::uint32_t>(chunks_.size());
  group(Op::kSchema, schemas_, put_schema);
  group(Op::kChannel, channels_, put_channel);
  group(Op::kStatistics, std::span(&statistics_, 1), put_statistics);
  group(Op::kChunkIndex, chunks_, put_chunk_index);
  group(Op::kAttachmentIndex, attachments_, put_attachment_index);
  group(Op::kMetadataIndex, metadata_, put_metadata_index);
  const std::uint64_t offsets_start = start + bytes_.size();
  record.raw(offsets);
  const std::size_t begin = record.begin_record(Op::kFooter);
  record.put(start).put(offsets_start);
  // The sum takes in the footer's head, so its length must stand there before.
  record.put(std::uint32_t{0}).end_record(begin);
  bytes_.resize(bytes_.size() - sizeof(std::uint32_t));
  record.put(crc(0, bytes_)).raw(magic());
  emit(bytes_);
  bytes_.clear();
}

bool McapWriter::cut_short() noexcept {
  try {
    sink_.cut(whole_);
    size_ = whole_;
    sum_ = whole_sum_;
    bytes_.clear();
    write_end();
    return true;
  } catch (...) {
    return false;
  }
}

std::size_t McapWriter::waiting() const { return chunk_->records.size(); }

}  // namespace headway::recording
