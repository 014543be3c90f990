#include "runtime/recording/mcap_reader.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include "hal/error.h"
#include "runtime/recording/record_bytes.h"

namespace headway::recording {

namespace {

std::uint32_t crc(std::span<const std::byte> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// The fixed fields of a chunk, its compression's name included, are no longer.
constexpr std::uint64_t kChunkHead = 64;

McapSchema schema_from(RecordReader r) {
  McapSchema schema{r.number<std::uint16_t>(), r.text(), r.text(), {}};
  schema.text = r.text();
  return schema;
}

McapChannel channel_from(RecordReader r) {
  McapChannel channel{r.number<std::uint16_t>(), r.number<std::uint16_t>(), r.text(), r.text(), {}};
  for (RecordReader list = r.list(); !list.empty();) {
    std::string key = list.text();
    channel.metadata[std::move(key)] = list.text();
  }
  return channel;
}

std::map<std::uint16_t, std::uint64_t> numbers_from(RecordReader list) {
  std::map<std::uint16_t, std::uint64_t> numbers;
  while (!list.empty()) {
    const auto key = list.number<std::uint16_t>();
    numbers[key] = list.number<std::uint64_t>();
  }
  return numbers;
}

McapChunkIndex chunk_index_from(RecordReader r) {
  McapChunkIndex chunk;
  chunk.first = r.time();
  chunk.last = r.time();
  chunk.at = r.number<std::uint64_t>();
  chunk.bytes = r.number<std::uint64_t>();
  chunk.message_indexes = numbers_from(r.list());
  chunk.index_bytes = r.number<std::uint64_t>();
  chunk.compression = r.text();
  chunk.compressed = r.number<std::uint64_t>();
  chunk.uncompressed = r.number<std::uint64_t>();
  return chunk;
}

McapAttachmentIndex attachment_index_from(RecordReader r) {
  McapAttachmentIndex index;
  index.at = r.number<std::uint64_t>();
  index.bytes = r.number<std::uint64_t>();
  index.log_time = r.time();
  index.create_time = r.number<std::uint64_t>();
  index.data_bytes = r.number<std::uint64_t>();
  index.name = r.text();
  index.media_type = r.text();
  return index;
}

McapMetadataIndex metadata_index_from(RecordReader r) {
  McapMetadataIndex index;
  index.at = r.number<std::uint64_t>();
  index.bytes = r.number<std::uint64_t>();
  index.name = r.text();
  return index;
}

McapStatistics statistics_from(RecordReader r) {
  McapStatistics all;
  all.messages = r.number<std::uint64_t>();
  all.schemas = r.number<std::uint16_t>();
  all.channels = r.number<std::uint32_t>();
  all.attachments = r.number<std::uint32_t>();
  all.metadata = r.number<std::uint32_t>();
  all.chunks = r.number<std::uint32_t>();
  all.first = r.time();
  all.last = r.time();
  all.channel_messages = numbers_from(r.list());
  return all;
}

}  // namespace

class McapReader::Decompressor {
 public:
  Decompressor() : context_(ZSTD_createDCtx()) {
    if (context_ == nullptr) throw std::bad_alloc();
  }
  ~Decompressor() { ZSTD_freeDCtx(context_); }
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  bool decompress(std::span<const std::byte> from, std::span<std::byte> into) {
    return ZSTD_decompressDCtx(context_, into.data(), into.size(), from.data(), from.size()) == into.size();
  }

 private:
  ZSTD_DCtx* context_;
};

McapReader::McapReader(std::unique_ptr<ByteSource> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)), decompressor_(std::make_unique<Decompressor>()) {
  if (!read_header())
    throw InputError(name_ + ": is no recording, expected an MCAP file of version 0 (.mcap)");
  if (read_summary()) return;
  schemas_.clear();
  channels_.clear();
  chunks_.clear();
  attachments_.clear();
  metadata_.clear();
  statistics_.reset();
  scan();
}

McapReader::~McapReader() = default;

/// Nothing where no record lies whole between `at` and `end`.
std::optional<McapReader::Record> McapReader::record_at(std::uint64_t at, std::uint64_t end) const {
  std::array<std::byte, kRecordHead> head;
  if (at > end || end - at < kRecordHead || !source_->read(at, head)) return std::nullopt;
  RecordReader r(head);
  const auto op = static_cast<Op>(r.number<std::uint8_t>());
  const auto size = r.number<std::uint64_t>();
  if (op == Op{} || size > end - at - kRecordHead) return std::nullopt;
  return Record{op, at, size + kRecordHead};
}

std::optional<std::vector<std::byte>> McapReader::content_of(const Record& record) const {
  if (record.content_bytes() > kLargest) return std::nullopt;
  std::vector<std::byte> content(static_cast<std::size_t>(record.content_bytes()));
  if (!source_->read(record.content(), content)) return std::nullopt;
  return content;
}

bool McapReader::read_header() {
  std::array<std::byte, kMcapMagic.size()> magic;
  if (!source_->read(0, magic) || !std::ranges::equal(magic, std::as_bytes(std::span(kMcapMagic))))
    return false;
  const auto header = record_at(magic.size(), source_->size());
  if (!header || header->op != Op::kHeader) return false;
  const auto content = content_of(*header);
  if (!content) return false;
  try {
    RecordReader r(*content);
    profile_ = r.text();
    library_ = r.text();
  } catch (const RecordError&) {
    return false;
  }
  data_begin_ = header->at + header->bytes;
  return true;
}

/// False where the file has no end, or none that can be trusted.
bool McapReader::read_summary() {
  const std::uint64_t size = source_->size();
  if (size < data_begin_ + kFooterSize + kMcapMagic.size()) return false;
  std::array<std::byte, kFooterSize + kMcapMagic.size()> end;
  if (!source_->read(size - end.size(), end)) return false;
  if (!std::ranges::equal(std::span(end).last(kMcapMagic.size()), std::as_bytes(std::span(kMcapMagic))))
    return false;
  RecordReader r(end);
  if (static_cast<Op>(r.number<std::uint8_t>()) != Op::kFooter || r.number<std::uint64_t>() != 20)
    return false;
  const auto start = r.number<std::uint64_t>();
  r.number<std::uint64_t>();
  const auto sum = r.number<std::uint32_t>();
  const std::uint64_t footer = size - end.size();
  if (start < data_begin_ || start > footer || footer - start > kLargest) return false;
  std::vector<std::byte> summary(static_cast<std::size_t>(footer - start + kFooterSize - sizeof sum));
  if (!source_->read(start, summary) || (sum != 0 && crc(summary) != sum)) return false;
  for (std::uint64_t at = start; at < footer;) {
    const auto record = record_at(at, footer);
    if (!record) return false;
    const auto content = std::span(summary).subspan(static_cast<std::size_t>(record->content() - start),
                                                    static_cast<std::size_t>(record->content_bytes()));
    if (!take_indexed(record->op, content)) return false;
    at += record->bytes;
  }
  const auto data_end = record_at(start - std::min(start, kRecordHead + sizeof sum), start);
  if (!statistics_ || !data_end || data_end->op != Op::kDataEnd) return false;
  const auto content = content_of(*data_end);
  if (!content || content->size() < sizeof sum) return false;
  data_end_ = data_end->at;
  data_sum_ = RecordReader(*content).number<std::uint32_t>();
  std::ranges::sort(chunks_, {}, &McapChunkIndex::at);
  for (std::size_t i = 1; i < chunks_.size(); ++i)
    if (chunks_[i].at - chunks_[i - 1].at < chunks_[i - 1].bytes) return false;  // one chunk named twice
  return true;
}

/// A record of the summary.
bool McapReader::take_indexed(Op op, std::span<const std::byte> content) {
  try {
    const RecordReader r(content);
    if (op == Op::kSchema) {
      McapSchema schema = schema_from(r);
      schemas_.try_emplace(schema.id, std::move(schema));
    } else if (op == Op::kChannel) {
      McapChannel channel = channel_from(r);
      channels_.try_emplace(channel.id, std::move(channel));
    } else if (op == Op::kChunkIndex) {
      chunks_.push_back(chunk_index_from(r));
    } else if (op == Op::kAttachmentIndex) {
      attachments_.push_back(attachment_index_from(r));
    } else if (op == Op::kMetadataIndex) {
      metadata_.push_back(metadata_index_from(r));
    } else if (op == Op::kStatistics) {
      statistics_ = statistics_from(r);
    }
    return true;
  } catch (const RecordError&) {
    return false;
  }
}

/// From the header on, up to the first thing that is no record.
void McapReader::scan() {
  const std::uint64_t size = source_->size();
  std::uint64_t at = data_begin_;
  for (; at < size;) {
    const auto record = record_at(at, size);
    if (!record || !take(*record)) break;
    if (record->op == Op::kDataEnd) {
      lose(at + record->bytes, size - at - record->bytes,
           "the index at the file's end is missing or damaged");
      return;
    }
    at += record->bytes;
  }
  lose(at, size - at,
       at == size ? "the file has no end: it was not closed"
                  : "no whole record: it was cut short or is damaged");
}

/// A record of the data section; false where it is none.
bool McapReader::take(const Record& record) {
  if (record.op == Op::kChunk) return take_chunk_head(record);
  if (record.op > Op::kDataEnd) return true;  // somebody's extension
  if (record.op == Op::kMessageIndex || record.op == Op::kDataEnd) return true;
  if (record.op == Op::kMessage) {
    lose(record.at, record.bytes, "a message outside of chunks, which is not read");
    return true;
  }
  const auto content = content_of(record);
  if (!content) return false;
  try {
    RecordReader r(*content);
    switch (record.op) {
      case Op::kSchema:
      case Op::kChannel:
        return take_indexed(record.op, *content);
      case Op::kAttachment: {
        McapAttachmentIndex index{record.at, record.bytes, r.time(), 0, 0, {}, {}};
        index.create_time = r.number<std::uint64_t>();
        index.name = r.text();
        index.media_type = r.text();
        index.data_bytes = r.number<std::uint64_t>();
        attachments_.push_back(std::move(index));
        return true;
      }
      case Op::kMetadata:
        metadata_.push_back({record.at, record.bytes, r.text()});
        return true;
      default:
        return false;
    }
  } catch (const RecordError&) {
    return false;
  }
}

bool McapReader::take_chunk_head(const Record& record) {
  std::vector<std::byte> head(static_cast<std::size_t>(std::min(kChunkHead, record.content_bytes())));
  if (!source_->read(record.content(), head)) return false;
  try {
    RecordReader r(head);
    McapChunkIndex chunk;
    chunk.at = record.at;
    chunk.bytes = record.bytes;
    chunk.first = r.time();
    chunk.last = r.time();
    chunk.uncompressed = r.number<std::uint64_t>();
    r.number<std::uint32_t>();
    chunk.compression = r.text();
    chunk.compressed = r.number<std::uint64_t>();
    chunks_.push_back(std::move(chunk));
    return true;
  } catch (const RecordError&) {
    return false;
  }
}

void McapReader::lose(std::uint64_t at, std::uint64_t bytes, std::string what) {
  for (const McapLoss& known : losses_)
    if (known.at == at && known.what == what) return;
  losses_.push_back({at, bytes, std::move(what)});
}

std::optional<std::uint16_t> McapReader::channel(std::string_view topic) const {
  for (const auto& [id, channel] : channels_)
    if (channel.topic == topic) return id;
  return std::nullopt;
}

/// Decompressed and checked; a loss where that cannot be.
std::optional<std::vector<std::byte>> McapReader::records_of(const McapChunkIndex& chunk) {
  const auto lost = [&](std::string what) {
    lose(chunk.at, chunk.bytes, std::move(what));
    return std::nullopt;
  };
  const auto record = record_at(chunk.at, source_->size());
  if (!record || record->op != Op::kChunk || record->bytes != chunk.bytes)
    return lost("no chunk lies where the index says");
  const auto content = content_of(*record);
  if (!content) return lost("a chunk too large to be one");
  try {
    RecordReader r(*content);
    r.time();
    r.time();
    const auto size = r.number<std::uint64_t>();
    const auto sum = r.number<std::uint32_t>();
    const std::string compression = r.text();
    const auto compressed = r.take(r.number<std::uint64_t>());
    if (size > kLargest) return lost("a chunk too large to be one");
    std::vector<std::byte> records;
    if (compression == "zstd") {
      // What zstd itself promises is trusted no more than the record: the sizes must agree.
      if (ZSTD_getFrameContentSize(compressed.data(), compressed.size()) != size)
        return lost("a damaged chunk: its size is wrong");
      records.resize(static_cast<std::size_t>(size));
      if (!decompressor_->decompress(compressed, records))
        return lost("a damaged chunk: it is no zstd frame");
    } else if (compression.empty() && compressed.size() == size) {
      records.assign(compressed.begin(), compressed.end());
    } else {
      return lost(fmt::format("a chunk compressed as '{:.20}', expected zstd", compression));
    }
    if (sum != 0 && crc(records) != sum) return lost("a damaged chunk: its sum is wrong");
    return records;
  } catch (const RecordError&) {
    return lost("a damaged chunk: it ends too soon");
  }
}

void McapReader::for_each(const std::set<std::uint16_t>& channels,
                          const std::function<void(const McapMessage&)>& visit) {
  const auto wanted = [&](std::uint16_t id) { return channels.empty() || channels.contains(id); };
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    const McapChunkIndex chunk = chunks_[i];
    const auto& indexed = chunk.message_indexes;
    if (!indexed.empty() && std::ranges::none_of(indexed, [&](const auto& p) { return wanted(p.first); }))
      continue;
    const auto records = records_of(chunk);
    if (!records) continue;
    for (RecordReader r(*records); !r.empty();) {
      McapMessage message;
      try {
        const auto op = static_cast<Op>(r.number<std::uint8_t>());
        const auto content = r.take(r.number<std::uint64_t>());
        if (op == Op::kSchema || op == Op::kChannel) take_indexed(op, content);
        if (op != Op::kMessage) continue;
        RecordReader m(content);
        message.channel = m.number<std::uint16_t>();
        message.sequence = m.number<std::uint32_t>();
        message.log_time = m.time();
        message.publish_time = m.time();
        message.bytes = m.rest();
      } catch (const RecordError&) {
        lose(chunk.at, chunk.bytes, "a damaged chunk: its records do not fit");
        break;
      }
      if (wanted(message.channel)) visit(message);
    }
  }
}

std::optional<McapAttachment> McapReader::attachment(std::string_view name) {
  const auto found = std::ranges::find(attachments_, name, &McapAttachmentIndex::name);
  if (found == attachments_.end()) return std::nullopt;
  return attachment(McapAttachmentIndex(*found));
}

std::optional<McapAttachment> McapReader::attachment(const McapAttachmentIndex& index) {
  const auto record = record_at(index.at, source_->size());
  const auto content =
      record && record->op == Op::kAttachment ? content_of(*record) : std::optional<std::vector<std::byte>>();
  try {
    if (!content) throw RecordError("");
    RecordReader r(*content);
    r.time();
    r.number<std::uint64_t>();
    McapAttachment file{index, {}};
    file.index.name = r.text();
    file.index.media_type = r.text();
    const auto data = r.take(r.number<std::uint64_t>());
    const auto sum = r.number<std::uint32_t>();
    if (sum != 0 && crc(std::span(*content).first(content->size() - sizeof sum)) != sum)
      throw RecordError("");
    file.data.assign(data.begin(), data.end());
    return file;
  } catch (const RecordError&) {
    lose(index.at, index.bytes, fmt::format("a damaged attachment '{:.60}'", index.name));
    return std::nullopt;
  }
}

std::optional<std::map<std::string, std::string>> McapReader::metadata(std::string_view name) {
  const auto found = std::ranges::find(metadata_, name, &McapMetadataIndex::name);
  if (found == metadata_.end()) return std::nullopt;
  const auto record = record_at(found->at, source_->size());
  const auto content =
      record && record->op == Op::kMetadata ? content_of(*record) : std::optional<std::vector<std::byte>>();
  try {
    if (!content) throw RecordError("");
    RecordReader r(*content);
    r.text();
    std::map<std::string, std::string> values;
    for (RecordReader list = r.list(); !list.empty();) {
      std::string key = list.text();
      values[std::move(key)] = list.text();
    }
    return values;
  } catch (const RecordError&) {
    lose(found->at, found->bytes, fmt::format("damaged metadata '{:.60}'", name));
    return std::nullopt;
  }
}

std::optional<bool> McapReader::sum_is_right() const {
  if (!has_end() || data_sum_ == 0) return std::nullopt;
  std::uint32_t sum = 0;
  std::vector<std::byte> part;
  for (std::uint64_t at = 0; at < data_end_; at += part.size()) {
    part.resize(static_cast<std::size_t>(std::min<std::uint64_t>(data_end_ - at, 1 << 20)));
    if (!source_->read(at, part)) return false;
    sum = crc(part, sum);
  }
  return sum == data_sum_;
}

}  // namespace headway::recording
