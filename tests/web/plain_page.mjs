// SPDX-License-Identifier: BSD-3-Clause
// What a page is to the server, without a browser: it requests the newest frame again and again, at most so many a second,
// and reads what comes. Stands for a tab on another machine.
import net from "node:net";

export class PlainPage {
  constructor(port, { perSecond = 30, parts = 15 } = {}) {
    Object.assign(this, { drawn: 0, bytes: 0, records: 0, state: {}, greeted: false, ended: false, pictured: -1, parts });
    this.pending = Buffer.alloc(0);
    this.waiting = false;
    this.socket = net.connect(port, "127.0.0.1");
    this.socket.setNoDelay(true);
    this.socket.on("error", () => {});
    this.socket.on("close", () => { this.ended = true; clearInterval(this.timer); });
    this.socket.write(`GET /live HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nOrigin: http://127.0.0.1:${port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n`);
    this.socket.on("data", (data) => this.take(data));
    this.timer = setInterval(() => this.request(), 1000 / perSecond);
  }

  send(opcode, body) {
    this.socket.write(Buffer.concat([Buffer.from([0x80 | opcode, 0x80 | body.length, 0, 0, 0, 0]), body]));
  }

  request() {
    if (!this.greeted || this.waiting || this.ended) return;
    this.waiting = true;
    this.send(1, Buffer.from(JSON.stringify({ op: "frame", n: -1, parts: this.parts, have: this.pictured })));
  }

  take(data) {
    this.bytes += data.length;
    this.pending = this.pending.length ? Buffer.concat([this.pending, data]) : data;
    if (!this.upgraded) {
      const end = this.pending.indexOf("\r\n\r\n");
      if (end < 0) return;
      this.upgraded = true;
      this.pending = this.pending.subarray(end + 4);
    }
    for (;;) {
      const p = this.pending;
      if (p.length < 2) return;
      const short = p[1] & 127, head = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (p.length < head) return;
      const size = short === 126 ? p.readUInt16BE(2) : short === 127 ? Number(p.readBigUInt64BE(2)) : short;
      if (p.length < head + size) return;
      this.message(p[0] & 15, p.subarray(head, head + size));
      this.pending = p.subarray(head + size);
    }
  }

  message(opcode, body) {
    if (opcode === 9) return this.send(10, Buffer.from(body));
    if (opcode === 2) {
      this.waiting = false;
      if (this.records > 0) ++this.drawn;
      if (body.readUInt32LE(12) > 0) this.pictured = body.readUInt32LE(28);
      return;
    }
    if (opcode !== 1) return;
    const m = JSON.parse(body);
    this.greeted = true;
    if (m.op === "state") this.state = m;
    if (m.op === "records") this.records += m.records.length;
  }

  close() { clearInterval(this.timer); this.socket.destroy(); }
}
