// SPDX-License-Identifier: BSD-3-Clause
// What the documentation shows of frames that fail a check: the picture of such a frame from a report, with its features
// and what failed. See tools/check_pictures.
// check_pictures.mjs PROGRAM OUTPUT NAME=REPORT.html:FRAME ...
import path from "node:path";
import { pathToFileURL } from "node:url";
import { check, main, openPage, output, until } from "./harness.mjs";

await main(async (browser) => {
  for (const wanted of process.argv.slice(4)) {
    const [, name, report, frame] = wanted.match(/^([^=]+)=(.*):(\d+)$/);
    const page = await openPage(browser, pathToFileURL(report).href, { width: 560, height: 700 });
    await until(`the report of ${name}`, () => page.evaluate(() => window.cliquevoReport?.ready));
    // Only what failed: the page beside the picture has the rest.
    await page.addStyleTag({ content: "table.checks tr.failed td, .explain { font-size: 13px } table.checks tr:not(.failed):has(td) { display: none }" });
    await page.evaluate(() => { for (const p of document.querySelectorAll(".explain")) if (/: $/.test(p.textContent)) p.remove(); });
    const figure = page.locator("figure", { has: page.locator("figcaption", { hasText: new RegExp(`^frame ${frame},`) }) });
    check(`${name}: frame ${frame} is among the worst`, (await figure.count()) === 1);
    await figure.screenshot({ path: path.join(output, `${name}.png`) });
    await page.close();
  }
});
