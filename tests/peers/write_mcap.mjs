// SPDX-License-Identifier: BSD-3-Clause
// Messages as an MCAP by its own library: write_mcap.mjs IN.jsonl OUT.mcap [none|zstd|lz4|unchunked].
// IN is written by write_bag.py: a line a message, {topic, type, stamp, data in base64}.
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import { McapWriter } from "@mcap/core";

const [source, out, compression = "none"] = process.argv.slice(2);
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
const tools = { zstd: ["zstd", ["-q", "-c"]], lz4: ["lz4", ["-q", "-c"]] };
const tool = tools[compression];
const compressChunk = tool && ((chunk) => {
  const done = spawnSync(tool[0], tool[1], { input: chunk, maxBuffer: 1 << 30 });
  if (done.status !== 0) throw new Error(`${tool[0]}: ${done.stderr ?? done.error}`);
  return { compression, compressedData: new Uint8Array(done.stdout) };
});
const writer = new McapWriter({ writable, useChunks: compression !== "unchunked", chunkSize: 256 * 1024, compressChunk });
await writer.start({ profile: "ros2", library: "test" });
const channels = new Map();
for (const line of fs.readFileSync(source, "utf8").split("\n")) {
  if (line === "") continue;
  const m = JSON.parse(line);
  if (!channels.has(m.topic)) {
    const schemaId = await writer.registerSchema({ name: m.type, encoding: "ros2msg", data: new Uint8Array() });
    channels.set(m.topic, await writer.registerChannel({ schemaId, topic: m.topic, messageEncoding: "cdr", metadata: new Map() }));
  }
  const stamp = BigInt(m.stamp);
  await writer.addMessage({ channelId: channels.get(m.topic), sequence: 0, logTime: stamp, publishTime: stamp,
    data: Buffer.from(m.data, "base64") });
}
await writer.end();
