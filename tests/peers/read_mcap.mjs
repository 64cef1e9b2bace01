// SPDX-License-Identifier: BSD-3-Clause
// Decodes every message of an MCAP by its own schema, with others' readers: read_mcap.mjs FILE > messages.jsonl.
// A line a message: {topic, type, logTime, message}; bytes as base64. The summary's index must name as many.
import fs from "node:fs";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const bytes = fs.readFileSync(process.argv[2]);
const decompressHandlers = await loadDecompressHandlers();
const plain = (key, value) => {
  if (typeof value === "bigint") return value.toString();
  if (value instanceof Uint8Array) return Buffer.from(value).toString("base64");
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return value;
};
const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
stream.append(bytes);
const schemas = new Map(), channels = new Map(), readers = new Map();
let messages = 0;
for (let record; (record = stream.nextRecord()) !== undefined; ) {
  if (record.type === "Schema") schemas.set(record.id, record);
  if (record.type === "Channel") channels.set(record.id, record);
  if (record.type !== "Message") continue;
  const channel = channels.get(record.channelId), schema = schemas.get(channel.schemaId);
  if (!readers.has(schema.id)) {
    readers.set(schema.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  const message = readers.get(schema.id).readMessage(record.data);
  console.log(JSON.stringify({ topic: channel.topic, type: schema.name, logTime: record.logTime, message }, plain));
  messages++;
}
const indexed = await McapIndexedReader.Initialize({
  readable: { size: async () => BigInt(bytes.length), read: async (at, n) => bytes.subarray(Number(at), Number(at + n)) },
  decompressHandlers,
});
let found = 0;
for await (const _ of indexed.readMessages({ validateCrcs: true })) found++;
if (!stream.done() || found !== messages || indexed.header.profile !== "ros2") {
  console.error(`stream ${messages}, indexed ${found}, profile ${indexed.header.profile}`);
  process.exit(1);
}
