// SPDX-License-Identifier: BSD-3-Clause
// A guided calibration from start to file: simulated cameras over the real protocol, a board that is moved before them,
// the page in the browser, and then a drive with the calibration that came out of it. In a network of its own
// (tests/web/run makes it).
import fs from "node:fs";
import path from "node:path";
import { check, main, openPage, output, run, shot, startUntil, until } from "./harness.mjs";

const board = "chessboard:9x6:0.03";
const size = ["width=512", "height=384"];
const long = process.argv.includes("--long");
const at = (name) => path.join(output, name);

fs.writeFileSync(at("calibrate.yaml"), `source:
  type: aravis
  cameras: {left: HIL-LEFT, right: HIL-RIGHT, rate_hz: 10, exposure_us: 3000, gain: 0, shared_clock: true}
`);

// Mean error over segments, in percent of their length.
async function drift(drive, ...more) {
  const poses = at("calibrate-poses.txt");
  const played = await run(["replay", drive, "--trajectory", poses, ...more]);
  check(`replay ${more.join(" ")}`, played.code === 0, played.err);
  const judged = await run(["eval", "--reference", path.join(drive, "poses.txt"), "--estimate", poses, "--lengths", long ? "10,20,40" : "5,10,20", "--json"]);
  return JSON.parse(judged.out);
}

await main(async (browser) => {
  const rig = at("calibrate-rig.yaml"), drive = at("calibrate-drive");
  fs.rmSync(rig, { force: true });
  fs.rmSync(drive, { recursive: true, force: true });
  await startUntil(/READY/, "hil", ["sim:board=" + board, "raw=on", ...size, "frames=360", "rate_hz=10", "board_hold_s=0.5", "board_move_s=0.2"].join(","), "--pingpong");
  const began = Date.now();
  const { child, found: address } = await startUntil(/http:\/\/\S+/, "calibrate", "--config", at("calibrate.yaml"), "--board", board, "--out", rig, "--json", "--page", "--port", "0");
  const page = await openPage(browser, address);
  await until("pictures come", () => page.evaluate(() => window.calibrate.drawn > 3), 60);
  const state = () => page.evaluate(() => window.calibrate.state);
  await until("views are taken by themselves", async () => (await state()).views >= 3, 60);
  const early = await state();
  check("it says what to do next", /next: |hold it still/.test(await page.locator("#advice").innerText()), early);
  check("bars show what is missing", early.bars.length === 6 && early.bars.some((bar) => bar.share < 1), early.bars);
  await page.locator("#drop").click();
  await shot(page, "calibrate-1");
  await until("more views are taken", async () => { const s = await state(); return s.views > early.views || s.phase !== "looking"; }, 60);
  const cells = (await state()).left.filter((cell) => cell).length;
  check("parts with corners are shaded", cells > 5, cells);
  await until("it is enough, and solved", async () => (await state()).phase === "done", 200);
  await shot(page, "calibrate-2");
  check("the page has the result", /baseline/.test(await page.locator("#result").innerText()));
  check("the program ends well", (await child.ended) === 0, child.err);
  const result = JSON.parse(child.out);
  console.log(`     ${((Date.now() - began) / 1000).toFixed(0)} s, ${result.views_used} views, baseline ${(1e3 * result.baseline_m).toFixed(2)} mm, error ${result.rms_px.toFixed(3)} px`);
  check("the baseline is 120 mm", Math.abs(result.baseline_m - 0.12) < 3 * result.baseline_sigma_m + 1e-5, result.baseline_m);
  check("the file is there", fs.existsSync(rig));
  check("no request beyond its own origin", page.strangers.length === 0, page.strangers);

  // A single drive has luck, and so have two short ones: the long test has six of 60 m.
  const courses = long ? ["wheeled", "walking"].flatMap((c) => [1, 2, 3].map((seed) => [c, seed])) : [["wheeled", 0], ["walking", 0]];
  const frames = long ? ["--frames", "600"] : ["--frames", "300", "--every", "3"];
  const means = { truth: 0, ours: 0 };
  for (const [course, seed] of courses) {
    const seeds = seed ? ["--world-seed", seed, "--noise-seed", seed].map(String) : [];
    const made = await run(["simulate", "--out", drive, "--raw", "--course", course, ...frames, ...seeds, ...size.flatMap((s) => [`--${s.split("=")[0]}`, s.split("=")[1]])]);
    check(`a ${course} drive of the same cameras`, made.code === 0, made.err);
    const truth = await drift(drive), ours = await drift(drive, "--calibration", rig);
    console.log(`     ${course}: drift ${truth.t_err_pct.toFixed(4)} % with the true calibration, ${ours.t_err_pct.toFixed(4)} % with ours`);
    means.truth += truth.t_err_pct / courses.length;
    means.ours += ours.t_err_pct / courses.length;
    fs.rmSync(drive, { recursive: true, force: true });
  }
  console.log(`     the calibration says that it may add ${result.accuracy.drift_pct.toFixed(4)} %`);
  const said = long ? 0 : result.accuracy.drift_pct;
  check("it drifts as with the true calibration", means.ours <= 1.2 * means.truth + said, means);
});
