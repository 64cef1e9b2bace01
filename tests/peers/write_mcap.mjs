// SPDX-License-Identifier: BSD-3-Clause
// Messages as an MCAP by its own library: write_mcap.mjs IN.jsonl OUT.mcap [none|zstd|lz4|unchunked] [TIMES [SECONDS]].
// TIMES: all of them so often, each time SECONDS later, also in their headers. IN is written by write_bag.py: a line a message, {topic, type, stamp, data in base64}.
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import { McapWriter } from "@mcap/core";

const [source, out, compression = "none", times = "1", seconds = "1"] = process.argv.slice(2);
const file = fs.openSync(out, "w");
let at = 0n;
const writable = {
  position: () => at,
  write: async (bytes) => {
    fs.writeSync(file, bytes);
    at += BigInt(bytes.length);
  },
};
// The library leaves compression to its user: here the command line tools of zstd and lz4.
const tools = { zstd: ["zstd", ["-q", "-c", "-1"]], lz4: ["lz4", ["-q", "-c"]] };
const tool = tools[compression];
const compressChunk = tool && ((chunk) => {
  const done = spawnSync(tool[0], tool[1], { input: chunk, maxBuffer: 1 << 30 });
  if (done.status !== 0) throw new Error(`${tool[0]}: ${done.stderr ?? done.error}`);
  return { compression, compressedData: new Uint8Array(done.stdout) };
});
const writer = new McapWriter({ writable, useChunks: compression !== "unchunked", chunkSize: times === "1" ? 256 * 1024 : 4 << 20, compressChunk });
await writer.start({ profile: "ros2", library: "test" });
const channels = new Map();
const messages = [];
for (const line of fs.readFileSync(source, "utf8").split("\n")) {
  if (line === "") continue;
  const m = JSON.parse(line);
  if (!channels.has(m.topic)) {
    const schemaId = await writer.registerSchema({ name: m.type, encoding: "ros2msg", data: new Uint8Array() });
    channels.set(m.topic, await writer.registerChannel({ schemaId, topic: m.topic, messageEncoding: "cdr", metadata: new Map() }));
  }
  messages.push({ channelId: channels.get(m.topic), stamp: BigInt(m.stamp), data: Buffer.from(m.data, "base64") });
}
const kSeconds = 4;  // where the header's begin, behind the encapsulation
for (let round = 0; round < Number(times); ++round) {
  for (const m of messages) {
    const later = round * Number(seconds);
    const data = round === 0 ? m.data : Buffer.from(m.data);
    if (round > 0) data.writeInt32LE(data.readInt32LE(kSeconds) + later, kSeconds);
    const stamp = m.stamp + BigInt(later) * 1_000_000_000n;
    await writer.addMessage({ channelId: m.channelId, sequence: 0, logTime: stamp, publishTime: stamp, data });
  }
}
await writer.end();
