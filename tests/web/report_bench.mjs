// SPDX-License-Identifier: BSD-3-Clause
// What a report costs: a replay of 4000 frames with it and without, in turns; its size, for 1000 frames and for all; and how
// long the browser takes until it is drawn.
//   tests/web/run tests/web/report_bench.mjs PROGRAM OUTPUT [--rounds 2]
import { spawnSync } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";
import { check, main, openPage, output, program, run, until } from "./harness.mjs";

const { values: options } = parseArgs({ args: process.argv.slice(4), options: { rounds: { type: "string", default: "2" } } });
const rendered = 120, frames = 4000;
const file = (name) => path.join(output, name), course = file("long_course");

// A short course, driven forward and backward until there are enough frames.
async function makeCourse() {
  fs.rmSync(course, { recursive: true, force: true });
  const made = await run(["simulate", "--out", course, "--frames", String(rendered), "--movers", "2"]);
  check("a course", made.code === 0, made.err);
  const image = (k) => `${String(k).padStart(6, "0")}.png`;
  for (const side of ["image_0", "image_1"]) {
    for (let k = rendered; k < frames; ++k) {
      const back = k % (2 * rendered - 2);
      fs.symlinkSync(image(back < rendered ? back : 2 * rendered - 2 - back), path.join(course, side, image(k)));
    }
  }
  fs.writeFileSync(path.join(course, "times.txt"), Array.from({ length: frames }, (_, k) => `${(k / 30).toFixed(6)}\n`).join(""));
  fs.rmSync(path.join(course, "poses.txt"), { force: true });
}

// Seconds of processor time: what other programs take does not count. The report is made on one thread, so that it takes
// no longer than that.
function timed(args) {
  const done = spawnSync("bash", ["-c", 'TIMEFORMAT="%U %S"; { time "$@" >/dev/null 2>&3; } 3>&2', "bash", program, ...args], { encoding: "utf8" });
  check(args.join(" "), done.status === 0, done.stderr);
  const [user, system] = done.stderr.trim().split("\n").at(-1).split(" ").map(Number);
  return user + system;
}
const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

await main(async (browser) => {
  await makeCourse();
  const times = { without: [], with: [] };
  timed(["replay", course, "--last", "500"]);  // files into memory
  for (let k = 0; k < Number(options.rounds); ++k) {
    times.without.push(timed(["replay", course]));
    times.with.push(timed(["replay", course, "--report", file("long.html")]));
  }
  const more = median(times.with) - median(times.without);
  const bytes = fs.statSync(file("long.html")).size;
  timed(["replay", course, "--last", "999", "--report", file("thousand.html")]);
  const ofThousand = fs.statSync(file("thousand.html")).size;
  const begun = Date.now(), page = await openPage(browser, pathToFileURL(file("long.html")).href);
  await until("the report is drawn", () => page.evaluate(() => window.cliquevoReport?.ready), 60);
  const drawn = (Date.now() - begun) / 1000;
  console.log(`     ${frames} frames: ${median(times.without).toFixed(1)} s of processor time, with the report ${more.toFixed(1)} s more; ${(bytes / 1e6).toFixed(1)} MB (1000 frames: ${(ofThousand / 1e6).toFixed(2)} MB); drawn in ${drawn.toFixed(1)} s`);
  check("the report of 4000 frames takes less than ten seconds", more < 10, more);
  check("of 1000 frames it has less than 5 MB", ofThousand < 5e6, ofThousand);
  check("it has all frames", (await page.evaluate(() => window.cliquevoReport.data.records.length)) === frames);
  check("no complaint in the console", page.complaints.length === 0, page.complaints);
  fs.writeFileSync(file("report_bench.json"), JSON.stringify({ frames, times, more_s: more, bytes, bytes_of_1000: ofThousand, drawn_s: drawn }));
  fs.rmSync(course, { recursive: true, force: true });
});
