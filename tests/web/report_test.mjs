// SPDX-License-Identifier: BSD-3-Clause
// Reports opened from disk: nothing is requested from any network, every number is that of --stats, hovering shows a frame.
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { check, main, openPage, output, run, shot, until, wait } from "./harness.mjs";

const frames = 150;
const file = (name) => path.join(output, name);

await main(async (browser) => {
  const source = `sim:frames=${frames},movers=2,fault=blank,fault_first=80,fault_frames=4`;
  const done = await run(["replay", source, "--stats", file("run.json"), "--report", file("run.html"), "--trajectory", file("run.txt")]);
  check("replay --report ends well", done.code === 0, done.err);
  const size = fs.statSync(file("run.html")).size;
  console.log(`     report of ${frames} frames: ${(size / 1e6).toFixed(2)} MB`);
  check("the report is small", size < 5e6, size);
  const page = await openPage(browser, pathToFileURL(file("run.html")).href);
  await until("the report is drawn", () => page.evaluate(() => window.cliquevoReport?.ready));
  const stats = JSON.parse(fs.readFileSync(file("run.json")));
  const shown = await page.evaluate(() => { const { stats, records } = window.cliquevoReport.data; return { stats, records }; });
  check("summary, reference and calibration are those of --stats", ["summary", "reference", "calibration"].every((k) => JSON.stringify(shown.stats[k]) === JSON.stringify(stats[k])));
  check("a record a frame", shown.records.length === stats.frames.length, shown.records.length);
  const near = (a, b) => Math.abs(a - b) <= 1e-5 + 1e-5 * Math.abs(b);
  const wrong = shown.records.filter((r, i) => {
    const f = stats.frames[i];
    return r.s !== f.status_code || r.q !== f.quality || r.c[3] !== f.inliers || r.i !== f.index || !near(r.e, f.reprojection_error_px) || !near(r.p[0], f.T_world_camera.translation_m[2]) || !near(-r.p[1], f.T_world_camera.translation_m[0]);
  });
  check("every frame's numbers are those of --stats", wrong.length === 0, wrong.slice(0, 2));
  check("failed frames are among the worst, with reasons", await page.evaluate(() => document.querySelectorAll("#worst figure").length >= 4 && document.querySelectorAll("#worst tr.failed").length > 0));
  await page.setViewportSize({ width: 1240, height: 1000 });
  await wait(500);
  await shot(page, "report-top");
  const ribbon = page.locator("#ribbon");
  await ribbon.scrollIntoViewIfNeeded();
  const box = await ribbon.boundingBox();
  await page.mouse.move(box.x + (81.5 / frames) * box.width, box.y + 10);
  await wait(200);
  const tip = await page.locator("#tip").innerText();
  check("hovering shows the frame", /frame 81/.test(tip), tip);
  check("with a picture", await page.evaluate(() => document.querySelector("#tip img")?.naturalWidth > 50));
  await shot(page, "report-hover");
  await page.locator("#worst").scrollIntoViewIfNeeded();
  await wait(400);
  await page.screenshot({ path: file("report-whole.png"), fullPage: true });

  fs.rmSync(file("course"), { recursive: true, force: true });  // of a run that was broken off
  const reference = await run(["simulate", "--out", file("course"), "--frames", String(frames)]);
  check("a course with truth", reference.code === 0, reference.err);
  const evaluated = await run(["eval", "--reference", file("course/poses.txt"), "--estimate", file("run.txt"), "--lengths", "2,5", "--report", file("eval.html")]);
  check("eval --report ends well", evaluated.code === 0, evaluated.err);
  const compared = await run(["compare", file("run.json"), file("run.json"), "--report", file("compare.html")]);
  check("compare --report ends well", compared.code === 0, compared.err);
  fs.rmSync(file("fleet"), { recursive: true, force: true });
  const small = "sim:width=160,height=120,focal_px=175,frames=40";
  const fleet = await run(["fleet", "run", "--out", file("fleet"), small, `${small},noise_seed=2,fault=blank,fault_first=20,fault_frames=3`, "/nowhere", "--set", "odometry.max_features=350,60"]);
  check("fleet run ends well", fleet.code === 0, fleet.err);
  const reported = await run(["fleet", "report", "--out", file("fleet"), "--baseline", "default odometry.max_features=350", "--pages", "1"]);
  check("fleet report ends with what the gate says", reported.code === 3, reported.err);
  fs.copyFileSync(file("fleet/report.html"), file("fleet.html"));
  const pages = [page];
  for (const name of ["eval", "compare", "fleet"]) {
    const other = await openPage(browser, pathToFileURL(file(`${name}.html`)).href);
    await until(`the report of ${name} is drawn`, () => other.evaluate(() => window.cliquevoReport?.ready));
    await wait(300);
    await shot(other, `report-${name}`);
    pages.push(other);
  }
  const season = pages.at(-1);
  const panels = await season.evaluate(() => [...document.querySelectorAll(".panel h2")].map((h) => h.textContent));
  for (const wanted of ["Configurations", "Without a result", "against default", "Distributions", "The worst frames", "Why frames were refused", "Recordings (4 units)"]) {
    check(`the fleet's report has ${wanted}`, panels.some((p) => p.includes(wanted)), panels);
  }
  check("the worst frames lead to a page that is there", await season.evaluate(() => document.querySelector("a[href^='pages/']")?.getAttribute("href")).then((page) => fs.existsSync(file(`fleet/${page}`))));
  const firstOf = () => season.evaluate(() => [...document.querySelectorAll("table")].at(-1).querySelector("tbody td").textContent);
  const heads = season.locator("table").last().locator("th");
  await heads.nth(3).click();
  await heads.nth(3).click();
  check("tables sort by a click on a head", /fault=blank/.test(await firstOf()), await firstOf());
  for (const p of pages) {
    check("no complaint in the console", p.complaints.length === 0, p.complaints);
    check("no request but for itself", p.strangers.length === 0, p.strangers);
  }
  for (const name of ["course", "fleet"]) fs.rmSync(file(name), { recursive: true, force: true });
});
