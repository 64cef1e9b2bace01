// SPDX-License-Identifier: BSD-3-Clause
// The page on a simulated recording with movers and a stretch of blank frames, as a user goes through it.
import { check, main, openPage, shot, startView, until, wait } from "./harness.mjs";

const frames = 120, firstBlank = 60, blank = 6;

const at = (page) => page.evaluate(() => window.cliquevo.at);
const failed = (page) => page.evaluate(() => window.cliquevo.records.failed);
// Sum over the pixels of the picture: distinguishes one picture from another.
const sum = (page) => page.evaluate(() => { const c = document.querySelector("#picture canvas"); const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; let s = 0; for (let i = 0; i < d.length; i += 16) s += d[i] + 3 * d[i + 1] + 7 * d[i + 2]; return s; });
const shownIs = (page, n) => page.evaluate((k) => window.cliquevo.shown.startsWith?.(`${k}/`), n);

await main(async (browser) => {
  const { address } = await startView(`sim:frames=${frames},movers=3,fault=blank,fault_first=${firstBlank},fault_frames=${blank}`);
  const page = await openPage(browser, address);
  await until("the first picture is drawn", () => page.evaluate(() => window.cliquevo.drawn > 0));
  check("it plays by itself", await until("", async () => (await at(page)) > 5));
  await until("all frames have come", () => page.evaluate((n) => window.cliquevo.records.end === n && window.cliquevo.state.done, frames), 120);
  await wait(800);
  await shot(page, "1-now");

  const level = await page.evaluate(() => { const r = window.cliquevo.records.list.at(-1); return { rise: Math.abs(r.p[2]) / Math.hypot(...r.p), told: document.querySelector("#up").textContent }; });
  check("the way over level ground is level, though the camera looks down", level.rise < 0.05 && /vehicle/.test(level.told), level);
  await page.keyboard.press("Home");
  check("Home goes to the first frame and pauses", (await at(page)) === 0 && !(await page.evaluate(() => window.cliquevo.playing)));
  await page.keyboard.press("ArrowRight");
  check("an arrow steps", (await at(page)) === 1);
  await until("the stepped frame's picture is shown", () => shownIs(page, 1));
  const before = await sum(page);
  await page.keyboard.press("ArrowRight");
  await until("the next picture is shown", () => shownIs(page, 2));
  check("another frame is another picture", before !== (await sum(page)));

  await until("failed frames are known", async () => (await failed(page)).length > 0);
  const bad = await failed(page);
  check("the blank frames failed", bad.includes(firstBlank + 2), bad);
  const ribbon = await page.locator("#ribbon").boundingBox();
  await page.mouse.click(ribbon.x + ((firstBlank + 2.5) / frames) * ribbon.width, ribbon.y + ribbon.height / 2);
  check("a click on the ribbon goes to the failed frame", bad.includes(await at(page)), await at(page));
  const reasons = await page.locator("#why tr.failed").allInnerTexts();
  check("the failed frame shows why, with value and bound", reasons.length > 0 && /\d/.test(reasons[0]), reasons);
  await until("the failed frame's picture is shown", async () => shownIs(page, await at(page)));
  await shot(page, "2-failed-frame");

  for (const [key, name] of [["d", "disparity"], ["r", "right"]]) {
    const plain = await sum(page);
    await page.keyboard.press("Home");
    await page.keyboard.press("PageDown");
    await until("picture before the overlay", async () => shownIs(page, await at(page)));
    await wait(150);
    const without = await sum(page);
    await page.keyboard.press(key);
    await until(`the ${name} overlay is drawn`, async () => (await sum(page)) !== without && (await page.evaluate(() => !window.cliquevo.shown.endsWith("/false/false"))));
    await wait(200);
    await shot(page, `3-${name}`);
    await page.keyboard.press(key);
    check(`${name} can be switched`, plain !== null);
  }
  await page.locator("#show-features").click();
  await wait(150);
  const bare = await sum(page);
  await page.locator("#show-features").click();
  await wait(150);
  check("features can be switched", bare !== (await sum(page)));

  const chart = await page.locator(".chart .u-over").first().boundingBox();
  await page.mouse.click(chart.x + chart.width * 0.75, chart.y + chart.height / 2);
  check("a click in a chart seeks", Math.abs((await at(page)) - 0.75 * frames) < 0.1 * frames, await at(page));
  await page.locator("#above").click();
  await wait(300);
  await shot(page, "4-from-above");
  await page.locator("#behind").click();
  const way = await page.evaluate(async () => {
    const { ScenePanel } = await import("./where.js");
    const scene = new ScenePanel(document.createElement("div"), null), p = [0, 0, 0];
    for (let n = 0; n < 130000; ++n) scene.add([{ n, ep: 0, s: n === 777 ? 2 : 1, p: [n / 10, p[1], 0], pt: [n, 1, 2] }]);
    const failed = Array.from({ length: scene.path.count }, (_, v) => v).filter((v) => Math.abs(scene.path.colours[3 * v] - scene.palette[2].r) < 1e-6).length;
    return { way: scene.path.count, points: scene.points.count, cells: scene.cells.size, last: scene.path.places[3 * scene.path.count - 3], failed };
  });
  check("a long way and its points stay within their most", way.way <= 120000 && way.points === 60000 && way.cells === 60000 && Math.abs(way.last - 12999.9) < 0.01 && way.failed > 0, way);

  await page.keyboard.press("Home");
  await page.selectOption("#speed", "2");
  const drawn = await page.evaluate(() => window.cliquevo.drawn);
  await page.keyboard.press(" ");
  await wait(1000);
  const played = await at(page), pictures = (await page.evaluate(() => window.cliquevo.drawn)) - drawn;
  check("it plays at the chosen speed", played > 25 && played < 90, played);
  console.log(`     ${pictures} pictures drawn in a second at ${played} frames a second`);
  await page.keyboard.press(" ");

  for (const [width, height] of [[900, 700], [480, 900], [1440, 900]]) {
    await page.setViewportSize({ width, height });
    await wait(300);
    const seen = await page.locator("#picture").boundingBox();
    check(`the picture is in view at ${width} x ${height}`, seen.height > 90 && seen.y < height, seen);
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    check(`nothing sticks out at ${width} x ${height}`, overflow <= 1, overflow);
    await shot(page, `5-${width}x${height}`);
  }
  await page.reload();
  await until("after a reload it is all there again", () => page.evaluate((n) => window.cliquevo?.records?.end === n && window.cliquevo.drawn > 0, frames));
  const other = await openPage(browser, address);
  await until("a second tab has its own place", () => other.evaluate(() => window.cliquevo.drawn > 0));
  await other.keyboard.press("Home");
  await page.keyboard.press("End");
  check("two tabs do not disturb each other", (await at(other)) === 0 && (await at(page)) === frames - 1);
  for (const p of [page, other]) {
    check("no complaint in the console", p.complaints.length === 0, p.complaints);
    check("no request beyond its own origin", p.strangers.length === 0, p.strangers);
  }
});
