// SPDX-License-Identifier: Apache-2.0
// The page of `kalfem watch`: it moves with the stream, names alarms and sensors that are out, and finds the command again.

import assert from "node:assert/strict";
import {execFileSync, spawn} from "node:child_process";
import {mkdirSync, mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {get} from "node:http";
import {connect, createServer} from "node:net";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {assertQuiet, launch, open, shoot, tally} from "../browser/browser.mjs";

const structure = `kalfem: 1
substructures:
  wheel: {masses: {w: 40 kg}, springs: [{name: tyre, from: ground, to: w, stiffness: 180 kN/m, damping: 200}]}
  body: {masses: {b: 300 kg}}
connectors:
  strut: {from: wheel.w, to: body.b, law: polynomial, parameters: {k1: 20 kN/m, k3: 3e6, c1: 1200}}
sensors:
  wheel: {acceleration: wheel.w, noise: 0.05 m/s^2}
  body: {acceleration: body.b, noise: 0.02 m/s^2}
`;
const driven = `${structure}excitation:
  road: {base_displacement: wheel.ground, random: {rms: 8 mm, band: [0.5, 12 Hz], seed: 4}}
simulate: {duration: 40 s, sample_rate: 500 Hz, tolerance: 1e-5, seed: 2}
`;
const watched = more => `${structure}excitation:
  road: {base_displacement: wheel.ground, file: live, channel: road}
live:
  {sample_rate: 500 Hz, horizon: 1 s, every: 1 s, lag: 25${more},
   alarms: {window: 1 s, reference: 12, memory: 12, level: 2 %, false_alarms_every: 720 h}}
estimate:
  unknown: {strut.k1: {initial: 19 kN/m, std: 2 kN/m}}
`;

const freePort = () => new Promise(resolve => {
  const probe = createServer().listen(0, "127.0.0.1", () => {
    const {port} = probe.address();
    probe.close(() => resolve(port));
  });
});

let browser, folder, port, lines;
before(async () => {
  browser = await launch();
  folder = mkdtempSync(join(tmpdir(), "kalfem_live_page_"));
  port = await freePort();
  writeFileSync(join(folder, "drive.yaml"), driven);
  writeFileSync(join(folder, "car.yaml"), watched(""));
  const play = (...more) => execFileSync(process.env.PROGRAM, ["play", "drive.yaml", "--speed", "0", ...more],
                                         {cwd: folder, maxBuffer: 1 << 28, encoding: "utf8"});
  // After 40 s the strut is softer, and for some seconds the sensor of the body is dead.
  lines = (play() + play("--start", "40", "--set", "connectors.strut.parameters.k1=18.8kN/m", "--fault", "dead:body:30:36"))
              .trim().split("\n");
});
after(async () => {
  await browser.close();
  rmSync(folder, {recursive: true});
});

// `kalfem watch` with what it has said; its page is there when this returns.
async function watching(what, ...more) {
  const child = spawn(process.env.PROGRAM, ["watch", what, "--page", String(port), ...more],
                      {cwd: folder, stdio: ["pipe", "ignore", "pipe"]});
  child.said = "";
  await new Promise((resolve, reject) => {
    child.stderr.on("data", bytes => {
      child.said += bytes;
      if (child.said.includes(`http://127.0.0.1:${port}/`)) resolve();
    });
    child.on("exit", code => reject(new Error(`kalfem watch ended with ${code}: ${child.said}`)));
  });
  child.feed = some => child.stdin.write(some.map(line => line + "\n").join(""));
  const after = end => new Promise(resolve => { child.on("exit", resolve); end(); });
  child.ended = () => after(() => child.stdin.end());
  child.stopped = () => after(() => child.kill());
  return child;
}

const address = () => ({address: `http://127.0.0.1:${port}/`});
const has = (page, text) => page.waitForFunction(words => document.body.innerText.includes(words), text);

const told = (path, host) => new Promise((resolve, reject) => {
  get({port, host: "127.0.0.1", path, headers: host ? {host} : {}}, response => {
    let text = "";
    response.on("data", bytes => { text += bytes; });
    response.on("end", () => resolve({status: response.statusCode, text}));
  }).on("error", reject);
});

test("the page moves with the stream", async () => {
  const watch = await watching("car.yaml");
  const page = await open(browser, "", address());
  await has(page, "Connected");
  watch.feed(lines.slice(0, 1000));  // 20 s
  await has(page, "the stream stands at 19 s");
  const charts = await page.locator("figure.chart").count();
  assert.ok(charts >= 3, `${charts} charts`);
  const before = Number(await page.evaluate(() => document.body.dataset.points));
  watch.feed(lines.slice(1000, 2000));
  await has(page, "the stream stands at 39 s");
  assert.ok(Number(await page.evaluate(() => document.body.dataset.points)) >= before + 19);
  assert.match(await page.locator("header .badge").innerText(), /consistent/);
  assert.match(await page.locator("section:has(h2:text-is('Unknowns')) tbody").innerText(), /strut\.k1\s+\((19|20)\.\d+ ± 0\.\d+\) ×10³\s+N\/m\s+–|strut\.k1\s+(19|20)\d\d\d ± \d+\s+N\/m\s+–/);
  const ink = await page.evaluate(() => [...document.querySelectorAll("figure.chart canvas")].map(canvas => {
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }));
  ink.forEach(colors => assert.ok(colors > 20, `${colors} colours`));

  watch.feed(lines.slice(2000));  // the strut is softer, the sensor dies and comes back
  await has(page, "strut.k1 has changed by");
  await has(page, "raised");
  await has(page, "stuck");
  await has(page, "the stream stands at 79 s");
  assert.match(await page.locator("section:has(h2:text-is('Unknowns')) tbody").innerText(), /\u2212[56]\.\d+ % since 4\d/);
  assert.match(await page.locator("section:has(h2:text-is('Health')) tbody").innerText(), /last minute\s+(consistent|suspicious) \d/);
  await shoot(page, "live", {fullPage: true});
  assert.equal((await tally(page)).errors, "0");
  assertQuiet(page);

  // Gone, and there again: what it knew of alarms and the trend comes back with the state.
  assert.equal(await watch.ended(), 0);
  await has(page, "Not connected");
  const again = await watching("car.yaml");
  await has(page, "Connected");
  await has(page, "strut.k1 has changed by");
  await again.ended();
});

test("on a narrow screen nothing is cut", async () => {
  const watch = await watching("car.yaml", "--state", join(folder, "narrow"));
  watch.feed(lines.slice(0, 1000));
  const page = await open(browser, "", {...address(), viewport: {width: 380, height: 800}});
  await has(page, "the stream stands at 19 s");
  const {scroll, shown} = await page.evaluate(() => ({scroll: document.documentElement.scrollWidth, shown: innerWidth}));
  assert.ok(scroll <= shown, `${scroll} of ${shown} px`);
  await shoot(page, "live-narrow");
  assertQuiet(page);
  await watch.ended();
});

test("a folder of cases is a choice of pages", async () => {
  mkdirSync(join(folder, "cases"));
  const ports = [await freePort(), await freePort()];
  ["north", "south"].forEach((name, k) => writeFileSync(join(folder, "cases", `${name}.yaml`),
                                                        watched(`, port: ${ports[k]}, metrics: 9`)));
  const watch = await watching("cases");
  const page = await open(browser, "", address());
  await has(page, "Connected");
  assert.match(watch.said, /north: live\.metrics and live\.page are of a case that is watched alone/);
  ports.forEach(each => connect(each, "127.0.0.1").end(lines.slice(0, 300).join("\n") + "\n"));
  await page.getByRole("button", {name: "south"}).click();
  await has(page, "the stream stands at 5 s");
  assert.equal(await page.locator("h1").innerText(), "south");
  assertQuiet(page);
  await watch.stopped();
});

test("the page is for this computer alone, and nothing else is told", async () => {
  const watch = await watching("car.yaml", "--state", join(folder, "asked"));
  assert.equal((await told("/")).status, 200);
  assert.equal((await told("/", "localhost:80")).status, 200);
  assert.equal((await told("/", "elsewhere.example")).status, 403);
  assert.equal((await told("/events", "elsewhere.example")).status, 403);
  assert.equal((await told("/health", "elsewhere.example")).status, 200);
  assert.match((await told("/nothing")).text, /there are \/, \/events, \/metrics and \/health/);
  await watch.ended();
});
