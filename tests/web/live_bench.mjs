// SPDX-License-Identifier: BSD-3-Clause
// Beside a running daemon for a while: what pages cost the view, how fast they are, whether anything grows, whether the
// daemon drops frames. A line every ten seconds, also into OUTPUT/live_bench.csv.
//   tests/web/run tests/web/live_bench.mjs PROGRAM OUTPUT [--seconds 60] [--tabs 5] [--browser N] [--size 512x384]
//       [--images-rate 30] [--beside URL]
// --browser: so many of the tabs are in Chromium here; the others are plain WebSockets, as of browsers elsewhere. --beside: a daemon runs already.
import fs from "node:fs";
import path from "node:path";
import { parseArgs } from "node:util";
import { check, main, openPage, output, program, start, startView, until, wait } from "./harness.mjs";
import { PlainPage } from "./plain_page.mjs";

const { values: options } = parseArgs({
  args: process.argv.slice(4),
  options: { seconds: { type: "string", default: "60" }, tabs: { type: "string", default: "5" }, browser: { type: "string", default: "0" }, size: { type: "string", default: "512x384" }, "images-rate": { type: "string", default: "30" }, beside: { type: "string" } },
});
const url = options.beside ?? "udpm://239.255.76.67:7667?ttl=0";
const [width, height] = options.size.split("x");
const seconds = Number(options.seconds), count = Number(options.tabs), inBrowser = Number(options.browser);

const ticks = (pid) => { const f = fs.readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" "); return Number(f[11]) + Number(f[12]); };
const resident = (pid) => Number(fs.readFileSync(`/proc/${pid}/status`, "utf8").match(/VmRSS:\s+(\d+)/)[1]) / 1024;
const mean = (list) => list.reduce((a, b) => a + b, 0) / Math.max(1, list.length);

function startDaemon() {
  const config = path.join(output, "live_bench.yaml");
  fs.writeFileSync(config, `source: {type: simulator, loop: pingpong, simulator: {frames: 150, movers: 2, width: ${width}, height: ${height}}}
lcm: {url: "${url}", images_channel: VO_IMAGES, images_rate_hz: ${options["images-rate"]}, images_right: true, features_channel: VO_FEATURES, movers_channel: VO_MOVERS}
control: {socket: ""}
`);
  return start(process.env.CLIQUEVOD ?? path.join(path.dirname(program), "cliquevod"), "--config", config);
}

// What every tab has drawn so far, and the newest word on the daemon.
const drawnOf = (tabs) => Promise.all(tabs.map((t) => (t instanceof PlainPage ? t.drawn : t.evaluate(() => window.cliquevo.drawn))));
const stateOf = (tab) => (tab instanceof PlainPage ? tab.state : tab.evaluate(() => window.cliquevo.state));
// What the page holds, garbage apart; MB.
async function heapOf(tab) {
  if (tab instanceof PlainPage) return 0;
  const client = (tab.inspector ??= await tab.context().newCDPSession(tab));
  await client.send("HeapProfiler.collectGarbage");
  return (await client.send("Runtime.getHeapUsage")).usedSize / 1e6;
}

await main(async (browser) => {
  const daemon = options.beside ? null : startDaemon();
  const { address, child } = await startView("--lcm", url, "--socket", "");
  const port = Number(new URL(address).port), tabs = [];
  for (let i = 0; i < count; ++i) tabs.push(i < inBrowser ? await openPage(browser, address, { width: 1280, height: 800 }) : new PlainPage(port));
  await until("frames come", async () => (await drawnOf(tabs)).every((n) => n > 30) && (await stateOf(tabs[0])).health?.pose_rate_hz > 1, 300);
  const dropped = (await stateOf(tabs[0])).health?.frames_dropped ?? 0;

  const log = path.join(output, "live_bench.csv"), rows = [];
  fs.writeFileSync(log, "seconds,view_mb,view_percent,daemon_mb,page_heap_mb,pictures_a_second_slowest,pictures_a_second_mean\n");
  const begun = Date.now();
  for (let before = { at: Date.now(), ticks: ticks(child.pid), drawn: await drawnOf(tabs) }; Date.now() - begun < 1000 * seconds; ) {
    await wait(Math.min(10, seconds) * 1000);
    const now = { at: Date.now(), ticks: ticks(child.pid), drawn: await drawnOf(tabs) }, s = (now.at - before.at) / 1000;
    const rates = now.drawn.map((n, i) => (n - before.drawn[i]) / s);
    rows.push({ t: (now.at - begun) / 1000, view: resident(child.pid), cpu: (now.ticks - before.ticks) / s, daemon: daemon ? resident(daemon.pid) : 0, heap: await heapOf(tabs[0]), least: Math.min(...rates), mean: mean(rates) });
    const line = Object.values(rows.at(-1)).map((v) => v.toFixed(1)).join(",");
    fs.appendFileSync(log, line + "\n");
    console.log(`     ${line}`);
    before = now;
  }
  const share = mean(rows.map((r) => r.cpu)) / count, rate = mean(rows.map((r) => r.mean)), health = (await stateOf(tabs[0])).health;
  console.log(`     ${options.size}, pictures at ${options["images-rate"]} Hz, ${count} pages, ${inBrowser} of them in Chromium: the view takes ${share.toFixed(1)} % of a core a page, ${rate.toFixed(1)} frames a second a page, daemon ${health?.pose_rate_hz.toFixed(1)} Hz, latency median ${health?.latency_p50_us} us, 99 % ${health?.latency_p99_us} us`);
  check("the view takes at most a fifth of a core a page", share <= 20, share);
  check("the daemon drops nothing", (health?.frames_dropped ?? 0) === dropped, [dropped, health?.frames_dropped]);
  if (inBrowser === 0) check("a page gets 25 frames a second and more", rate >= 25, rate);
  // The last ten minutes are kept: only then nothing may grow any more.
  const full = rows.filter((r) => r.t > 660);
  if (full.length > 20) {
    const third = Math.floor(full.length / 3), grown = (key) => mean(full.slice(-third).map((r) => r[key])) - mean(full.slice(0, third).map((r) => r[key]));
    for (const [key, most] of [["view", 4], ["daemon", 3], ["heap", 5]]) check(`memory is flat: ${key}`, Math.abs(grown(key)) < most || grown(key) < 0, grown(key));
    console.log(`     MB more in the last third than in the first, of ${((full.at(-1).t - full[0].t) / 60).toFixed(0)} minutes: view ${grown("view").toFixed(2)}, daemon ${grown("daemon").toFixed(2)}, page ${grown("heap").toFixed(2)}`);
  }
  for (const t of tabs) if (t instanceof PlainPage) t.close(); else check("no complaint in the console", t.complaints.length === 0, t.complaints);
});
