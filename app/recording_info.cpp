#include "app/recording_info.h"

#include <algorithm>

#include <fmt/format.h>

#include "runtime/preface.h"
#include "runtime/topics.h"

namespace headway::app {

namespace {

namespace recorded = runtime::recorded;

struct Count {
  TopicInfo info;
  std::optional<std::uint32_t> next;

  void add(const recording::McapMessage& message) {
    if (info.messages == 0) info.first = info.last = message.log_time;
    if (next && message.sequence > *next) info.missing += message.sequence - *next;
    next = message.sequence + 1;
    ++info.messages;
    info.bytes += message.bytes.size();
    info.longest_gap = std::max(info.longest_gap, message.log_time - info.last);
    info.first = std::min(info.first, message.log_time);
    info.last = std::max(info.last, message.log_time);
  }
};

Json drops_of(const recorded::Drops& drops) {
  Json out = Json::object();
  recorded::Drops::fields(drops, [&](const char* name, std::uint64_t count) { out[name] = count; });
  return out;
}

}  // namespace

double TopicInfo::rate() const {
  const double span = to_seconds(last - first);
  return messages > 1 && span > 0 ? static_cast<double>(messages - 1) / span : 0;
}

RecordingInfo inspect(recording::McapReader& file) {
  RecordingInfo info;
  info.profile = file.profile();
  info.library = file.library();
  info.has_end = file.has_end();
  info.sum_is_right = file.sum_is_right();
  info.chunks = file.chunks().size();
  info.attachments = file.attachments();
  info.facts = file.metadata(runtime::kFactsName).value_or(std::map<std::string, std::string>{});
  const auto drops = file.channel(runtime::kind(runtime::Topic::kDrops).name);
  std::map<std::uint16_t, Count> counts;
  bool any = false;
  file.for_each({}, [&](const recording::McapMessage& message) {
    counts[message.channel].add(message);
    info.first = any ? std::min(info.first, message.log_time) : message.log_time;
    info.last = any ? std::max(info.last, message.log_time) : message.log_time;
    any = true;
    if (message.channel != drops) return;
    try {
      info.drops = recording::from_cdr<recorded::Drops>(message.bytes);
    } catch (const recording::CdrError&) {
      // Somebody else's topic of that name.
    }
  });
  for (auto& [id, count] : counts) {
    if (const auto channel = file.channels().find(id); channel != file.channels().end()) {
      count.info.topic = channel->second.topic;
      const auto schema = file.schemas().find(channel->second.schema);
      if (schema != file.schemas().end()) count.info.schema = schema->second.name;
    }
    info.topics.push_back(count.info);
  }
  std::ranges::sort(info.topics, {}, &TopicInfo::topic);
  info.losses = file.losses();
  return info;
}

Json to_json(const RecordingInfo& info) {
  Json topics = Json::array(), attachments = Json::array(), losses = Json::array();
  for (const TopicInfo& t : info.topics)
    topics.push_back({{"topic", t.topic},
                      {"schema", t.schema},
                      {"messages", t.messages},
                      {"missing", t.missing},
                      {"bytes", t.bytes},
                      {"first_s", to_seconds(t.first)},
                      {"last_s", to_seconds(t.last)},
                      {"rate_hz", rounded(t.rate(), 3)},
                      {"longest_gap_s", to_seconds(t.longest_gap)}});
  for (const recording::McapAttachmentIndex& file : info.attachments)
    attachments.push_back({{"name", file.name}, {"media_type", file.media_type}, {"bytes", file.data_bytes}});
  for (const recording::McapLoss& loss : info.losses)
    losses.push_back({{"at", loss.at}, {"bytes", loss.bytes}, {"what", loss.what}});
  return {{"profile", info.profile},
          {"library", info.library},
          {"whole", info.whole()},
          {"has_end", info.has_end},
          {"sum_is_right", info.sum_is_right ? Json(*info.sum_is_right) : Json(nullptr)},
          {"chunks", info.chunks},
          {"first_s", to_seconds(info.first)},
          {"last_s", to_seconds(info.last)},
          {"topics", topics},
          {"dropped", info.drops ? drops_of(*info.drops) : Json(nullptr)},
          {"attachments", attachments},
          {"facts", info.facts},
          {"lost", losses}};
}

std::string to_text(const RecordingInfo& info) {
  std::string text = fmt::format("{:.3f} s in {} chunks, from {:.3f} s on; profile {}, by {}\n",
                                 to_seconds(info.last - info.first), info.chunks, to_seconds(info.first),
                                 info.profile, info.library);
  text += fmt::format("{:<28} {:<32} {:>8} {:>9} {:>8} {:>10} {:>9}\n", "topic", "type", "messages",
                      "rate [Hz]", "missing", "bytes", "gap [s]");
  for (const TopicInfo& t : info.topics)
    text += fmt::format("{:<28} {:<32} {:>8} {:>9.2f} {:>8} {:>10} {:>9.3f}\n", t.topic, t.schema, t.messages,
                        t.rate(), t.missing, t.bytes, to_seconds(t.longest_gap));
  for (const recording::McapAttachmentIndex& file : info.attachments)
    text += fmt::format("holds {}, {} bytes\n", file.name, file.data_bytes);
  if (const auto fault = info.facts.find("fault"); fault != info.facts.end())
    text += fmt::format("black box, after: {}\n", fault->second);
  if (info.drops && *info.drops != recorded::Drops{})
    text += fmt::format("dropped, the disk was too slow: {}\n", drops_of(*info.drops).dump());
  for (const recording::McapLoss& loss : info.losses)
    text += fmt::format("lost: {} bytes from {} on: {}\n", loss.bytes, loss.at, loss.what);
  if (info.sum_is_right == false) text += "the sum over the file is wrong: something in it is damaged\n";
  if (info.whole()) text += "whole: every sum is right\n";
  return text;
}

}  // namespace headway::app
