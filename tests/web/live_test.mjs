// SPDX-License-Identifier: BSD-3-Clause
// The page beside a running daemon, in a network of its own (tests/web/run makes it): it follows, pauses, scrolls back,
// and finds its way again when daemon or view are started anew. Several tabs, one of which reads nothing.
import fs from "node:fs";
import net from "node:net";
import path from "node:path";
import { check, main, openPage, output, program, run, shot, start, startView, until, wait } from "./harness.mjs";

const url = "udpm://239.255.76.67:7667?ttl=0";
const seconds = Number(process.env.CLIQUEVO_LIVE_SECONDS ?? 8);
const size = (process.env.CLIQUEVO_LIVE_SIZE ?? "512x384").split("x");
const config = path.join(output, "live.yaml"), socket = path.join(output, "control");

// The lower right corner is the vehicle's own, as a mask says.
const mask = path.join(output, "mask.pgm"), course = path.join(output, "live_course"), [width, height] = size.map(Number);
fs.writeFileSync(mask, Buffer.concat([Buffer.from(`P5\n${width} ${height}\n255\n`), Buffer.from(Array.from({ length: width * height }, (_, i) => (i % width > 0.7 * width && i > 0.7 * width * height ? 0 : 255)))]));
fs.writeFileSync(config, `source: {loop: pingpong, type: recording, recording: {path: ${course}, left_mask: ${mask}, rate_hz: 30}}
body: {translation_m: [0.3, 0.06, 0.85], roll_pitch_yaw_deg: [0, 13, 0]}
lcm: {url: "${url}", images_channel: VO_IMAGES, images_rate_hz: 5, images_right: true, features_channel: VO_FEATURES, movers_channel: VO_MOVERS}
control: {socket: ${socket}}
recording: {folder: ${path.join(output, "recordings")}}
`);
const startDaemon = () => start(process.env.CLIQUEVOD ?? path.join(path.dirname(program), "cliquevod"), "--config", config);

const stat = (pid) => { const f = fs.readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" "); return Number(f[11]) + Number(f[12]); };
const resident = (pid) => Number(fs.readFileSync(`/proc/${pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/)[1]) / 1024;
const end = (page) => page.evaluate(() => window.cliquevo.records.end);
const at = (page) => page.evaluate(() => window.cliquevo.at);

// A page that requests frames and never reads one.
function sleeper(port) {
  const s = net.connect(port, "127.0.0.1");
  s.on("error", () => {});
  s.write(`GET /live HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n`);
  const body = Buffer.from('{"op":"frame","n":-1,"parts":15}'), frame = Buffer.concat([Buffer.from([0x81, 0x80 | body.length, 0, 0, 0, 0]), body]);
  const timer = setInterval(() => s.write(frame), 50);
  s.pause();
  return () => { clearInterval(timer); s.destroy(); };
}

await main(async (browser) => {
  fs.mkdirSync(path.join(output, "recordings"), { recursive: true });
  fs.rmSync(course, { recursive: true, force: true });  // of a run that was broken off
  const made = await run(["simulate", "--out", course, "--frames", "150", "--movers", "2", "--width", size[0], "--height", size[1]]);
  check("a course to drive", made.code === 0, made.err);
  let daemon = startDaemon();
  let { address, child } = await startView("--lcm", url, "--socket", socket);
  const port = Number(new URL(address).port);
  const page = await openPage(browser, address);
  await until("frames come", async () => (await end(page)) > 60, 90);
  await until("pictures come", () => page.evaluate(() => window.cliquevo.drawn > 10));
  await until("it follows the newest frame", async () => { const [e, a] = await page.evaluate(() => [window.cliquevo.records.end, window.cliquevo.at]); return e - a < 4; });
  await until("health is shown", () => page.evaluate(() => /Hz/.test(document.querySelector("#health").innerText)));
  check("metres are known", await page.evaluate(() => window.cliquevo.state.model?.baseline > 0.1));
  await shot(page, "live-1");
  check("values and bounds of checks are there", await page.evaluate(() => window.cliquevo.records.list.at(-1).ck.some((c) => c.length === 3)));

  await page.locator("#show-right").click();
  await until("the right image comes", () => page.evaluate(() => window.cliquevo.picture.picture?.right?.width > 0));
  check("it stands beside or below the left one", await page.evaluate(() => window.cliquevo.picture.layout.right.x !== window.cliquevo.picture.layout.left.x || window.cliquevo.picture.layout.right.y !== window.cliquevo.picture.layout.left.y));
  await until("the mask has come", () => page.evaluate(() => !document.querySelector("#show-mask").disabled));
  const pixel = () => page.evaluate(() => { const p = window.cliquevo.picture, l = p.layout.left, k = devicePixelRatio, d = p.canvas.getContext("2d").getImageData((l.x + 0.95 * p.layout.w) * k, (l.y + 0.95 * p.layout.h) * k, 4, 4).data; let s = 0; for (let i = 0; i < d.length; i += 4) s += d[i]; return s / 16; });
  await page.locator("#show-features").click();
  await wait(400);
  const unmasked = await pixel();
  await page.locator("#show-mask").click();
  await until("the mask darkens its corner", async () => (await pixel()) < 0.75 * unmasked);
  await shot(page, "live-right-mask");
  for (const name of ["mask", "features", "right"]) await page.locator(`#show-${name}`).click();
  check("up is the vehicle's", await page.evaluate(() => window.cliquevo.state.level && /vehicle/.test(document.querySelector("#up").textContent)));

  const tabs = [page];
  for (let i = 1; i < 3; ++i) tabs.push(await openPage(browser, address));
  const stopSleeping = [sleeper(port), sleeper(port)];
  await wait(2000);
  const [cpu, rss, drawn, t] = [stat(child.pid), resident(child.pid), await page.evaluate(() => window.cliquevo.drawn), Date.now()];
  await wait(1000 * seconds);
  const s = (Date.now() - t) / 1000;
  const share = (stat(child.pid) - cpu) / s, hz = ((await page.evaluate(() => window.cliquevo.drawn)) - drawn) / s, grown = resident(child.pid) - rss;
  console.log(`     five pages, two of them asleep: ${share.toFixed(1)} % of a core, ${hz.toFixed(1)} pictures a second in one, memory ${rss.toFixed(0)} MB and ${grown.toFixed(1)} MB more after ${s.toFixed(0)} s`);
  check("memory does not grow with pages that read nothing", grown < 12, grown);
  for (const stop of stopSleeping) stop();
  const health = await page.evaluate(() => window.cliquevo.state.health);
  console.log(`     daemon: ${health.pose_rate_hz.toFixed(1)} Hz, latency p99 ${health.latency_p99_us} us, dropped ${health.frames_dropped} of ${health.frames_grabbed}`);

  await page.locator("#ribbon").click({ position: { x: 200, y: 10 } });
  const paused = await at(page);
  await wait(700);
  check("scrolled back it stays there", (await at(page)) === paused && (await end(page)) > paused + 5);
  await page.keyboard.press("End");
  await until("End follows again", () => page.evaluate(() => window.cliquevo.follow && window.cliquevo.records.end - window.cliquevo.at < 4));

  await page.locator("#record-start").click();
  await until("a recording was begun from the page", () => fs.readdirSync(path.join(output, "recordings")).length > 0);
  await page.locator("#record-stop").click();

  daemon.kill("SIGKILL");
  await wait(500);
  const before = await end(page);
  daemon = startDaemon();
  await until("a daemon that is started again is seen", async () => (await end(page)) > before + 30, 60);
  check("the way has a break there", await page.evaluate(() => window.cliquevo.records.list.at(-1).ep > 0));

  child.removeAllListeners("exit");
  child.kill("SIGTERM");
  await until("the page shows that the view is gone", () => page.evaluate(() => /again/.test(document.querySelector("#connection").innerText)));
  page.complaints.length = 0;  // Chromium logs a refused connection
  await startView("--lcm", url, "--port", String(port));
  await until("and connects again", () => page.evaluate(() => document.querySelector("#connection").innerText === "connected" && window.cliquevo.records.end > 5), 30);
  await shot(page, "live-2");
  daemon.kill("SIGTERM");
  for (const p of tabs) check("no request beyond its own origin", p.strangers.length === 0, p.strangers);
  fs.rmSync(course, { recursive: true, force: true });
  fs.rmSync(path.join(output, "recordings"), { recursive: true, force: true });
});
