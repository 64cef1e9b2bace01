// SPDX-License-Identifier: BSD-3-Clause
// A viewer by others' code: subscribes to every channel of foxglove.websocket.v1 and decodes by the schemas it receives.
//   node foxglove_client.mjs ws://127.0.0.1:8470/ MESSAGES > messages.jsonl
// READY once subscribed; a line a message, {topic, type, stamp, message}, bytes as base64; ends when so many of /odom came.
import protocol from "@foxglove/ws-protocol";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import WebSocket from "ws";

const { FoxgloveClient } = protocol;
const [address, wanted] = [process.argv[2], Number(process.argv[3])];
const client = new FoxgloveClient({ ws: new WebSocket(address, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
const readers = new Map();
let seen = 0;
const plain = (key, value) => {
  if (typeof value === "bigint") return value.toString();
  if (value instanceof Uint8Array) return Buffer.from(value).toString("base64");
  if (ArrayBuffer.isView(value)) return Array.from(value);
  return value;
};
const end = (code, text) => {
  if (text) console.error(text);
  process.exit(code);
};
client.on("serverInfo", (info) => console.log(JSON.stringify({ topic: "serverInfo", message: info })));
client.on("error", (error) => end(1, String(error?.message ?? error)));
client.on("close", () => end(1, "closed"));
client.on("status", (status) => console.log(JSON.stringify({ topic: "status", message: status })));
client.on("advertise", (channels) => {
  for (const c of channels) {
    if (c.encoding !== "cdr" || c.schemaEncoding !== "ros2msg") end(1, `${c.topic}: ${c.encoding}, ${c.schemaEncoding}`);
    readers.set(client.subscribe(c.id), [c, new MessageReader(parse(c.schema, { ros2: true }))]);
  }
  setTimeout(() => console.log("READY"), 300);
});
client.on("message", (m) => {
  const [channel, reader] = readers.get(m.subscriptionId);
  const message = reader.readMessage(m.data);
  console.log(JSON.stringify({ topic: channel.topic, type: channel.schemaName, stamp: m.timestamp, message }, plain));
  if (channel.topic === "/odom" && ++seen >= wanted) setTimeout(() => end(0), 300);
});
setTimeout(() => end(1, `only ${seen} of ${wanted}`), 60_000);
