// SPDX-License-Identifier: BSD-3-Clause
// The WebSocket: connects again when it is lost; one request for pictures is on its way at a time.
export class Link extends EventTarget {
  constructor(address) {
    super();
    this.address = address;
    this.wait = 250;
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(this.address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.wait = 250; this.asked = null; this.tell("open"); };
    this.socket.onclose = () => {
      this.tell("closed");
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(4000, this.wait * 1.6);
    };
    this.socket.onmessage = (event) => {
      if (typeof event.data === "string") { const m = JSON.parse(event.data); this.tell(m.op, m); return; }
      this.asked = null;
      this.tell("frame", event.data);
    };
  }

  tell(name, detail) { this.dispatchEvent(new CustomEvent(name, { detail })); }
  get open() { return this.socket.readyState === WebSocket.OPEN; }
  get busy() { return this.asked !== null || !this.open; }
  ask(n, parts) {
    if (this.busy) return false;
    this.asked = n;
    this.socket.send(JSON.stringify({ op: "frame", n, parts }));
    return true;
  }
  command(op) { if (this.open) this.socket.send(JSON.stringify({ op })); }
}
