// SPDX-License-Identifier: BSD-3-Clause
// What the view's server lets in: names, origins, token, paths; and what malformed requests and frames do (nothing).
import crypto from "node:crypto";
import net from "node:net";
import { spawnSync } from "node:child_process";
import { check, main, program, run, startView, until, wait } from "./harness.mjs";

// Bytes in, bytes out; the connection is ended after a while.
function talk(port, bytes, { host = "127.0.0.1", ms = 1500 } = {}) {
  return new Promise((resolve) => {
    const socket = net.connect(port, host);
    let out = "";
    const finish = () => { socket.destroy(); resolve(out); };
    const timer = setTimeout(finish, ms);
    socket.on("connect", () => socket.write(bytes));
    socket.on("data", (d) => { out += d.toString("latin1"); });
    socket.on("error", () => {});
    socket.on("close", () => { clearTimeout(timer); resolve(out); });
  });
}
const status = (answer) => Number(answer.match(/^HTTP\/1\.1 (\d+)/)?.[1] ?? 0);
const upgrade = (headers, target = "/live") => `GET ${target} HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n${headers}\r\n\r\n`;
const get = (target, headers) => `GET ${target} HTTP/1.1\r\n${headers}\r\nConnection: close\r\n\r\n`;

await main(async () => {
  const { address, child } = await startView("sim:frames=40");
  const port = Number(new URL(address).port), us = `127.0.0.1:${port}`;
  const alive = async (why) => check(`it still serves after ${why}`, status(await talk(port, get("/", `Host: ${us}`))) === 200);
  await alive("nothing");

  for (const host of ["evil.example", `evil.example:${port}`, "127.0.0.1", `127.0.0.1:${port + 1}`, "", `localhost.evil.example:${port}`, `127.0.0.1.evil.example:${port}`]) {
    check(`Host ${JSON.stringify(host)} is refused`, status(await talk(port, get("/", `Host: ${host}`))) === 421);
  }
  for (const host of [us, `localhost:${port}`, `[::1]:${port}`]) check(`Host ${host} is ours`, status(await talk(port, get("/main.js", `Host: ${host}`))) === 200);
  check("a page of ours may connect", status(await talk(port, upgrade(`Host: ${us}\r\nOrigin: http://${us}`), { ms: 400 })) === 101);
  for (const origin of ["http://evil.example", "null", `https://${us}`, `http://localhost:${port}`, `http://127.0.0.1:${port + 1}`]) {
    check(`Origin ${origin} may not`, status(await talk(port, upgrade(`Host: ${us}\r\nOrigin: ${origin}`), { ms: 400 })) === 403);
  }
  for (const target of ["/../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/vendor/../main.js", "/./main.js", "/%2e%2e/x", "/vendor/", "/main.js%00.html", "/live"]) {
    check(`${target} is not there`, status(await talk(port, get(target, `Host: ${us}`))) === 404);
  }
  check("nothing can be put there", status(await talk(port, `POST / HTTP/1.1\r\nHost: ${us}\r\nContent-Length: 0\r\n\r\n`)) === 405);
  check("the page may not be framed", /frame-ancestors 'none'/.test(await talk(port, get("/", `Host: ${us}`))));

  await talk(port, "\0\0\0\0", { ms: 300 });
  await talk(port, "GET\r\n\r\n", { ms: 300 });
  await talk(port, `GET / HTTP/1.1\r\nX: ${"y".repeat(20000)}\r\n\r\n`, { ms: 300 });
  await talk(port, `GET / HTTP/1.1\r\nHost: ${us}\r\nContent-Length: 99999999\r\n\r\n`, { ms: 300 });
  await talk(port, `GET / HTTP/1.1\r\nHost: ${us}\r\nTransfer-Encoding: chunked\r\n\r\nFFFFFFFF\r\n`, { ms: 300 });
  await alive("malformed requests");
  for (let i = 0; i < 300; ++i) await talk(port, crypto.randomBytes(1 + (i % 200)), { ms: 4 });
  await alive("random bytes");
  const hello = upgrade(`Host: ${us}\r\nOrigin: http://${us}`);
  const frames = [Buffer.from([0x81, 0x05, 1, 2, 3, 4, 5]), Buffer.from([0x81, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]), Buffer.from([0xff, 0x80, 0, 0, 0, 0]), Buffer.from([0x88, 0x80, 0, 0, 0, 0]), Buffer.from([0x01, 0x80, 0, 0, 0, 0])];
  for (const text of ["{", "[]", "{\"op\":1}", "{\"op\":\"frame\"}", "{\"op\":\"frame\",\"n\":1e300,\"parts\":15}", "{\"op\":\"frame\",\"n\":-9223372036854775808,\"parts\":15}", "{\"op\":\"frame\",\"n\":9223372036854775807,\"parts\":4294967295}", "[".repeat(900), "x".repeat(1000)]) {
    const body = Buffer.from(text), mask = Buffer.from([1, 2, 3, 4]);
    const head = body.length < 126 ? Buffer.from([0x81, 0x80 | body.length]) : Buffer.from([0x81, 0xfe, body.length >> 8, body.length & 255]);
    frames.push(Buffer.concat([head, mask, body.map((b, i) => b ^ mask[i % 4])]));
  }
  for (const frame of frames) await talk(port, Buffer.concat([Buffer.from(hello), frame]), { ms: 120 });
  for (let i = 0; i < 150; ++i) await talk(port, Buffer.concat([Buffer.from(hello), crypto.randomBytes(1 + (i % 90))]), { ms: 5 });
  await alive("malformed frames");
  const many = Array.from({ length: 200 }, () => net.connect(port, "127.0.0.1").on("error", () => {}));
  await wait(300);
  for (const s of many) s.destroy();
  await wait(200);
  await alive("two hundred silent connections");
  check("nobody ended it", child.exitCode === null);

  const taken = await run(["view", "sim:frames=5", "--port", String(port)]);
  check("a port that is taken is one line", taken.code === 1 && taken.err.trim().split("\n").length === 1, taken.err);
  const noRoute = spawnSync("unshare", ["-n", program, "view", "--lcm", "udpm://239.255.76.67:7667?ttl=0", "--port", "0"], { encoding: "utf8", timeout: 15000 });
  check("no LCM route is one line", noRoute.status === 1 && noRoute.stderr.trim().split("\n").length === 1, noRoute);
  for (const [args, code] of [[["view", "/nowhere"], 1], [["view", "sim", "--lcm", "udpm://239.255.76.67:7667?ttl=0"], 2], [["view", "sim:frames=5", "--listen", "localhost.example"], 1]]) {
    const bad = await run(args);
    check(`${args.join(" ")} is one line`, bad.code === code && bad.err.trim().split("\n").length === 1, bad);
  }

  const open = await startView("sim:frames=10", "--listen", "0.0.0.0");
  const at = new URL(open.address), token = at.searchParams.get("token"), there = `127.0.0.1:${at.port}`;
  check("beyond loopback the address holds a token", /^[0-9a-f]{32}$/.test(token ?? ""), open.address);
  check("without it nothing is served", status(await talk(Number(at.port), get("/", `Host: ${there}`))) === 403);
  check("a wrong one is refused", status(await talk(Number(at.port), get(`/?token=${"0".repeat(32)}`, `Host: ${there}`))) === 403);
  const let_in = await talk(Number(at.port), get(`/?token=${token}`, `Host: ${there}`));
  check("with it the page is served", status(let_in) === 200);
  const cookie = let_in.match(/Set-Cookie: ([^;]+)/)?.[1];
  check("then the cookie is enough", status(await talk(Number(at.port), get("/main.js", `Host: ${there}\r\nCookie: a=b; ${cookie}`))) === 200);
  check("no WebSocket without it", status(await talk(Number(at.port), upgrade(`Host: ${there}\r\nOrigin: http://${there}`), { ms: 400 })) === 403);
  check("one with it", status(await talk(Number(at.port), upgrade(`Host: ${there}\r\nOrigin: http://${there}\r\nCookie: ${cookie}`), { ms: 400 })) === 101);
  await until("", () => true);
});
