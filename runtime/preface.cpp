#include "runtime/preface.h"

namespace headway::runtime {

std::unique_ptr<recording::McapWriter> begin_file(recording::ByteSink& sink, const Preface& preface,
                                                  const std::map<std::string, std::string>& more_facts,
                                                  Time begin, const recording::McapWriterConfig& config) {
  auto writer = std::make_unique<recording::McapWriter>(sink, config);
  for (const TopicKind& topic : kTopics) writer->add_channel(topic.name, topic.schema, topic.text());
  auto facts = preface.facts;
  facts.insert(more_facts.begin(), more_facts.end());
  writer->add_metadata(kFactsName, facts);
  for (const Preface::File& file : preface.files)
    writer->attach(file.name, file.media_type, begin, file.bytes);
  for (const Preface::Message& message : preface.messages)
    write(*writer, {message.topic, 0, begin, message.cdr});
  return writer;
}

}  // namespace headway::runtime
