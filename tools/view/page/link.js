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
    this.socket.onopen = () => { this.wait = 250; this.requested = null; this.emit("open"); };
    this.socket.onclose = () => {
      this.emit("closed");
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(4000, this.wait * 1.6);
    };
    this.socket.onmessage = (event) => {
      if (typeof event.data === "string") { const m = JSON.parse(event.data); this.emit(m.op, m); return; }
      this.requested = null;
      this.emit("frame", event.data);
    };
  }

  emit(name, detail) { this.dispatchEvent(new CustomEvent(name, { detail })); }
  get open() { return this.socket.readyState === WebSocket.OPEN; }
  get busy() { return this.requested !== null || !this.open; }
  // have: frame whose images are here already and need not be sent again; -1: none.
  request(n, parts, have) {
    if (this.busy) return false;
    this.requested = n;
    this.socket.send(JSON.stringify({ op: "frame", n, parts, have }));
    return true;
  }
  command(op) { if (this.open) this.socket.send(JSON.stringify({ op })); }
}
