// SPDX-License-Identifier: BSD-3-Clause
// What the documentation shows of the view: frames of the moving picture, and screenshots. See tools/view_pictures.
import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { main, openPage, output, run, startView, until, wait } from "./harness.mjs";

const to = (name) => path.join(output, name);
const seek = (page, n) => page.evaluate(async (k) => {
  const v = window.cliquevo;
  v.playing = false; v.follow = false; v.at = k - 1;
  document.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight" }));
  for (let i = 0; i < 200 && !String(v.shown).startsWith(`${k}/`); ++i) await new Promise((r) => setTimeout(r, 20));
}, n);

await main(async (browser) => {
  const { address } = await startView("sim:frames=150,movers=3,fault=blank,fault_first=104,fault_frames=5");
  const page = await openPage(browser, address, { width: 1360, height: 850 });
  await until("all frames", () => page.evaluate(() => window.cliquevo.state.done && window.cliquevo.records.end === 150), 200);
  await wait(1200);
  for (let i = 0; i < 18; ++i) {
    if (i === 6) await page.keyboard.press("d");
    if (i === 12) await page.keyboard.press("d");
    await seek(page, 30 + i * 5);
    await wait(120);
    await page.screenshot({ path: to(`moving-${String(i).padStart(3, "0")}.png`) });
  }
  await seek(page, 106);
  await wait(300);
  await page.screenshot({ path: to("view-failed.png") });
  await seek(page, 45);
  await page.keyboard.press("d");
  await wait(900);
  await page.screenshot({ path: to("view-disparity.png") });
  await run(["replay", "sim:frames=150,movers=3,fault=blank,fault_first=104,fault_frames=5", "--report", to("report.html")]);
  const report = await openPage(browser, pathToFileURL(to("report.html")).href, { width: 1240, height: 1500 });
  await until("report", () => report.evaluate(() => window.cliquevoReport?.ready));
  await wait(500);
  await report.screenshot({ path: to("report.png") });
  fs.rmSync(to("report.html"));
});
