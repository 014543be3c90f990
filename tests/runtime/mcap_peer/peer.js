// usage: node peer.js FILE
// Reads an MCAP file twice with readers that are not ours, from its start with every sum checked and by its index, and
// decodes every message by the schema that the file holds. Prints one line of JSON: what was found, or {"error": ...}.
// Exit code 77 where its packages are missing (scripts/setup installs them).
'use strict';

const fs = require('fs');

let mcap, fzstd, parse, MessageReader;
try {
  mcap = require('@mcap/core');
  fzstd = require('fzstd');
  ({ parse } = require('@foxglove/rosmsg'));
  ({ MessageReader } = require('@foxglove/rosmsg2-serialization'));
} catch (missing) {
  if (missing.code !== 'MODULE_NOT_FOUND') throw missing;
  console.error(missing.message);
  process.exit(77);
}

const decompressHandlers = { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) };
const text = new TextDecoder();

/// Counts messages by topic, and decodes them; the last of each topic is kept.
class Topics {
  constructor() {
    this.counts = {};
    this.last = {};
    this.readers = new Map();
  }
  add(message, channel, schema) {
    if (!this.readers.has(channel.id)) {
      if (channel.messageEncoding !== 'cdr' || schema.encoding !== 'ros2msg') throw new Error(`${channel.topic}: encoding`);
      this.readers.set(channel.id, new MessageReader(parse(text.decode(schema.data), { ros2: true })));
    }
    this.last[channel.topic] = this.readers.get(channel.id).readMessage(message.data);
    this.counts[channel.topic] = (this.counts[channel.topic] ?? 0) + 1;
  }
}

function fromStart(bytes) {
  const reader = new mcap.McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(bytes);
  const topics = new Topics();
  const channels = new Map(), schemas = new Map();
  const out = { attachments: [], metadata: [], done: false };
  for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
    if (record.type === 'Schema') schemas.set(record.id, record);
    if (record.type === 'Channel') channels.set(record.id, record);
    if (record.type === 'Attachment') out.attachments.push({ name: record.name, bytes: record.data.length });
    if (record.type === 'Metadata') out.metadata.push(record.name);
    if (record.type === 'Message') {
      const channel = channels.get(record.channelId);
      topics.add(record, channel, schemas.get(channel.schemaId));
    }
  }
  out.done = reader.done();
  return { ...out, counts: topics.counts };
}

async function byIndex(bytes) {
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + length))),
  };
  const reader = await mcap.McapIndexedReader.Initialize({ readable, decompressHandlers });
  const topics = new Topics();
  let before = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    if (message.logTime < before) throw new Error('messages out of order');
    before = message.logTime;
    const channel = reader.channelsById.get(message.channelId);
    topics.add(message, channel, reader.schemasById.get(channel.schemaId));
  }
  const attachments = [], metadata = [];
  for await (const file of reader.readAttachments({ validateCrcs: true })) attachments.push(file.name);
  for await (const record of reader.readMetadata()) metadata.push(Object.fromEntries(record.metadata));
  return {
    profile: reader.header.profile,
    messages: reader.statistics.messageCount,
    chunks: reader.chunkIndexes.length,
    counts: topics.counts,
    last: topics.last,
    attachments,
    metadata,
  };
}

const plain = (key, value) => {
  if (typeof value === 'bigint') return Number(value);
  if (ArrayBuffer.isView(value)) return value.length > 64 ? { length: value.length } : Array.from(value, Number);
  return value;
};

(async () => {
  const bytes = fs.readFileSync(process.argv[2]);
  console.log(JSON.stringify({ start: fromStart(bytes), index: await byIndex(bytes) }, plain));
})().catch((error) => console.log(JSON.stringify({ error: error.message })));
