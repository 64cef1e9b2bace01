// SPDX-License-Identifier: BSD-3-Clause
// How fast the page is with software rendering, alone on the machine: frames drawn and turns of the page's loop a second while
// a simulated course is played at 30 Hz, at two sizes and with each overlay.
// Beside other programs the processor time a frame says more: 40 ms on one core are 25 frames a second.
//   tests/web/run tests/web/page_bench.mjs PROGRAM OUTPUT [--seconds 8] [--profile]
import fs from "node:fs";
import path from "node:path";
import { parseArgs } from "node:util";
import { check, main, openPage, output, processorTime, startView, until, wait } from "./harness.mjs";

const { values: options } = parseArgs({ args: process.argv.slice(4), options: { seconds: { type: "string", default: "8" }, profile: { type: "boolean", default: false } } });
const seconds = Number(options.seconds), least = 25;

// Turns of the page's loop, counted in the page.
const countTurns = () => { window.turns = 0; const turn = () => { ++window.turns; requestAnimationFrame(turn); }; requestAnimationFrame(turn); };

async function measure(page, name, results) {
  await page.keyboard.press("Home");
  await page.keyboard.press(" ");
  await wait(700);
  const read = () => page.evaluate(() => [window.cliquevo.drawn, window.turns, performance.now(), window.cliquevo.at]);
  const before = await read(), spent = processorTime();
  await wait(1000 * seconds);
  const cpu = processorTime() - spent, after = await read(), s = (after[2] - before[2]) / 1000;
  await page.keyboard.press(" ");
  const one = { name, frames: (after[0] - before[0]) / s, turns: (after[1] - before[1]) / s, played: (after[3] - before[3]) / s, cpu_ms: (1000 * cpu) / Math.max(1, after[0] - before[0]) };
  results.push(one);
  console.log(`     ${name}: ${one.frames.toFixed(1)} frames drawn and ${one.turns.toFixed(1)} turns a second, ${one.played.toFixed(1)} played; ${one.cpu_ms.toFixed(0)} ms of processor time a frame, browser and view`);
  check(`${name}: ${least} frames a second and more`, one.frames >= least, one.frames);
}

async function profiled(page, name, body) {
  if (!options.profile) return body();
  const client = await page.context().newCDPSession(page);
  await client.send("Profiler.enable");
  await client.send("Profiler.start");
  await body();
  const { profile } = await client.send("Profiler.stop");
  fs.writeFileSync(path.join(output, `${name.replace(/\W+/g, "-")}.cpuprofile`), JSON.stringify(profile));
  const self = new Map(), names = new Map(profile.nodes.map((n) => [n.id, `${n.callFrame.functionName || "(anonymous)"} ${n.callFrame.url.split("/").pop()}:${n.callFrame.lineNumber + 1}`]));
  profile.samples.forEach((id, i) => self.set(names.get(id), (self.get(names.get(id)) ?? 0) + profile.timeDeltas[i] / 1000));
  for (const [what, ms] of [...self].sort((a, b) => b[1] - a[1]).slice(0, 14)) console.log(`       ${ms.toFixed(0).padStart(7)} ms  ${what}`);
}

await main(async (browser) => {
  const results = [];
  for (const [width, height] of [[512, 384], [1242, 375]]) {
    const frames = Math.ceil(30 * (seconds + 3));
    const { address, child } = await startView(`sim:frames=${frames},movers=3,width=${width},height=${height}`);
    const page = await openPage(browser, address, { width: 1440, height: 900 });
    await until("all frames have come", () => page.evaluate((n) => window.cliquevo.records.end === n && window.cliquevo.state.done, frames), 400);
    await page.evaluate(countTurns);
    for (const [what, key] of [["features", null], ["disparity", "d"], ["right image", "r"]]) {
      if (key) await page.keyboard.press(key);
      await profiled(page, `${width} x ${height} ${what}`, () => measure(page, `${width} x ${height}, ${what}`, results));
      if (key) await page.keyboard.press(key);
    }
    check("no complaint in the console", page.complaints.length === 0, page.complaints);
    await page.close();
    child.removeAllListeners("exit");
    child.kill("SIGTERM");
  }
  fs.writeFileSync(path.join(output, "page_bench.json"), JSON.stringify(results, null, 1));
});
