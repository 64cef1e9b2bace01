// SPDX-License-Identifier: BSD-3-Clause
// What the browser's tests share: the program under test, Debian's Chromium, checks that print what they found.
import { spawn } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { chromium } from "playwright-core";

export const program = process.argv[2];
export const output = process.argv[3];
fs.mkdirSync(output, { recursive: true });

let failures = 0;
export function check(what, ok, found = "") {
  console.log(`${ok ? "ok  " : "FAIL"} ${what}${ok || found === "" ? "" : `: ${JSON.stringify(found)}`}`);
  if (!ok) ++failures;
}

const started = [];
// Starts `cliquevo view ...` on a free port; resolves to its address.
export function startView(...args) {
  const child = spawn(program, ["view", ...(args.includes("--port") ? [] : ["--port", "0"]), ...args], { stdio: ["ignore", "pipe", "pipe"] });
  started.push(child);
  child.errors = "";
  child.stderr.on("data", (text) => { child.errors += text; });
  return new Promise((resolve, reject) => {
    let printed = "";
    child.stdout.on("data", (text) => {
      printed += text;
      const found = printed.match(/http:\/\/\S+/);
      if (found) resolve({ address: found[0], child });
    });
    child.on("exit", (code) => reject(new Error(`cliquevo view ended with ${code}: ${child.errors}`)));
  });
}

// Another program, which ends with the test.
export function start(path, ...args) {
  const child = spawn(path, args, { stdio: ["ignore", "ignore", "ignore"] });
  started.push(child);
  return child;
}

// A program of ours that ends with the test; resolves once it has printed what matches.
export function startUntil(pattern, ...args) {
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"] });
  started.push(child);
  child.out = child.err = "";
  child.ended = new Promise((resolve) => child.on("close", resolve));
  return new Promise((resolve, reject) => {
    const look = () => { const found = (child.out + child.err).match(pattern); if (found) resolve({ child, found: found[0] }); };
    child.stdout.on("data", (text) => { child.out += text; look(); });
    child.stderr.on("data", (text) => { child.err += text; look(); });
    child.on("exit", (code) => reject(new Error(`cliquevo ${args[0]} ended with ${code}: ${child.err}`)));
  });
}

export function run(args, options = {}) {
  return new Promise((resolve) => {
    const child = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"], ...options });
    let out = "", err = "";
    child.stdout.on("data", (t) => { out += t; });
    child.stderr.on("data", (t) => { err += t; });
    child.on("exit", (code) => resolve({ code, out, err }));
  });
}

export const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
export async function until(what, test, seconds = 40) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await wait(60)) {
    try { if (await test()) return true; } catch { /* not yet */ }
  }
  check(what, false, "waited in vain");
  return false;
}

// It draws as it does where there is no graphics card: with the processor, WebGL too.
export async function startBrowser() {
  const executablePath = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find((p) => fs.existsSync(p));
  if (!executablePath) throw new Error("no Chromium: tools/setup installs it");
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"] });
}

// Seconds of processor time of every program that this one has started, and of those that they have.
export function processorTime() {
  const of = new Map();
  for (const pid of fs.readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const [, parent, ...f] = fs.readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
      of.set(Number(pid), { parent: Number(parent), seconds: (Number(f[9]) + Number(f[10])) / 100 });
    } catch { /* it has ended */ }
  }
  const ours = (pid) => pid === process.pid || (of.has(pid) && ours(of.get(pid).parent));
  return [...of].filter(([pid]) => pid !== process.pid && ours(pid)).reduce((sum, [, p]) => sum + p.seconds, 0);
}

// CLIQUEVO_PAGE: a folder whose scripts and styles the page gets instead of the program's own: no build between changes.
// A page whose every complaint and every request to another place is kept.
export async function openPage(browser, address, size = { width: 1440, height: 900 }) {
  const page = await browser.newPage({ viewport: size });
  page.complaints = [];
  page.strangers = [];
  page.on("console", (m) => { if (m.type() === "error" || m.type() === "warning") if (!/GPU stall|GL Driver|WebGL|willReadFrequently/.test(m.text())) page.complaints.push(m.text()); });
  page.on("pageerror", (e) => page.complaints.push(String(e)));
  // A page from a server: what is beyond its origin; one from disk: all but itself.
  const own = address.startsWith("http") ? `${new URL(address).origin}/` : address.split("?")[0];
  page.on("request", (r) => { const u = r.url(); if (!u.startsWith(own) && !/^(data|blob):/.test(u)) page.strangers.push(u); });
  if (process.env.CLIQUEVO_PAGE) await page.route(/\.(js|css)$/, (r) => r.fulfill({ path: path.join(process.env.CLIQUEVO_PAGE, new URL(r.request().url()).pathname) }));
  await page.goto(address, { timeout: 120000 });
  return page;
}

export const shot = (page, name) => page.screenshot({ path: path.join(output, `${name}.png`) });

// Asked to end: what was started ends, too.
const stopped = new Promise((resolve) => process.once("SIGTERM", resolve));

// Runs the whole test; the exit code is CTest's verdict.
export async function main(body) {
  let browser = null;
  try {
    browser = await startBrowser();
    await Promise.race([body(browser), stopped]);
  } catch (error) {
    check("the test ran through", false, String(error.stack ?? error));
  }
  await browser?.close();
  for (const child of started) { child.removeAllListeners("exit"); child.kill("SIGTERM"); }
  console.log(failures ? `${failures} checks failed` : "all checks passed");
  process.exit(failures ? 1 : 0);
}
