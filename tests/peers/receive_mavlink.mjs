// SPDX-License-Identifier: BSD-3-Clause
// Decodes MAVLink with others' code: receive_mavlink.mjs PORT COUNT > messages.jsonl
// Prints READY, then a line a message {name, system, component, ...fields} until COUNT of ODOMETRY or
// VISION_POSITION_ESTIMATE came; sends one TIMESYNC request and prints its answer too.
import dgram from "node:dgram";
import { PassThrough } from "node:stream";
import { MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2, common, minimal } from "node-mavlink";

const [port, count] = process.argv.slice(2);
const registry = { ...minimal.REGISTRY, ...common.REGISTRY };
const input = new PassThrough();
const reader = input.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser());
let left = Number(count), asked = false, answered = false, reply = () => {};
const plain = (key, value) => (typeof value === "bigint" ? value.toString() : value);
function ask() {
  asked = true;
  const question = new common.TimeSync();
  question.tc1 = 0n;
  question.ts1 = 123456789n;
  reply(new MavLinkProtocolV2().serialize(question, 0));
}
function finish() {
  process.exit(0);
}
reader.on("data", (packet) => {
  const kind = registry[packet.header.msgid];
  const fields = packet.protocol.data(packet.payload, kind);
  console.log(JSON.stringify({ name: kind.MSG_NAME, version: packet.protocol instanceof MavLinkProtocolV2 ? 2 : 1,
    sequence: packet.header.seq, system: packet.header.sysid, component: packet.header.compid, ...fields }, plain));
  if (!asked) ask();
  answered ||= kind.MSG_NAME === "TIMESYNC";
  if (kind.MSG_NAME === "ODOMETRY" || kind.MSG_NAME === "VISION_POSITION_ESTIMATE") left--;
  if (left <= 0 && answered) finish();
});
const socket = dgram.createSocket("udp4");
socket.on("message", (data, from) => {
  reply = (bytes) => socket.send(bytes, from.port, from.address);
  input.write(data);
});
socket.bind(Number(port), "127.0.0.1", () => console.log("READY"));
setTimeout(() => process.exit(3), 60000);
