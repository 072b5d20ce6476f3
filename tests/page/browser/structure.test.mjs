// SPDX-License-Identifier: Apache-2.0
// The structure: it is drawn, takes the shapes of its modes, turns, plays, and does without WebGL.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {assertQuiet, colors, launch, open, shoot, tally} from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

const settle = page => page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));

async function opened(options) {
  const page = await open(browser, "structure.html", options);
  const figure = page.locator(".scene").first();
  await figure.locator("canvas").waitFor();
  await settle(page);
  const stage = figure.locator(".stage");
  const picture = async () => { await settle(page); return stage.screenshot(); };
  const choose = name => figure.getByLabel("Shape").selectOption(name);
  return {page, figure, stage, picture, choose};
}

test("a structure is drawn and takes the shapes of its modes", async () => {
  const {page, figure, picture, choose} = await opened();
  assert.deepEqual(await tally(page), {charts: "6", curves: "17", scenes: "1", errors: "0", resources: "0"});
  const resting = await picture();
  assert.ok(await colors(page, resting) > 100);
  await shoot(figure, "structure-undeformed");
  await choose("mode 1: 12.50 Hz");
  const first = await picture();
  await shoot(figure, "structure-mode-1");
  await choose("mode 2: 31.25 Hz");
  const second = await picture();
  await choose("estimated motion");
  const motion = await picture();
  await shoot(figure, "structure-motion");
  assert.equal(new Set([resting, first, second, motion].map(String)).size, 4);
  assert.match(await figure.locator(".key").textContent(), /1\.\d+ mm, drawn \d+ times as large/);
  await choose("undeformed");
  assert.deepEqual(await picture(), resting);
  assertQuiet(page);
});

test("marks and names stand on it", async () => {
  const {page, figure, stage} = await opened();
  const names = await stage.locator(".spot b").allTextContents();
  assert.deepEqual(names.filter(Boolean).sort(), ["a1 <&>, p1", "damper", "hammer", "motor"]);
  for (const name of ["left <&>", "right", "legs", "sensor", "boundary", "force", "connector", "spring to ground", "mass", "support"])
    assert.ok((await figure.locator(".key").textContent()).includes(name), name);
  await figure.getByLabel("Names").uncheck();
  assert.equal(await stage.locator(".spot b").first().isVisible(), false);
  assertQuiet(page);
});

test("a measured shape stands over that of the model, and only with it", async () => {
  const {page, figure, stage, picture, choose} = await opened();
  const dots = () => stage.locator(".spot:not([hidden])").count();
  await choose("mode 1: 12.50 Hz");
  const alone = await picture(), fewer = await dots();
  await choose("measured 12.4 Hz over mode 1");
  assert.notDeepEqual(await picture(), alone);
  assert.equal(await dots(), fewer + 3);
  const tops = () => stage.locator(".spot").evaluateAll(nodes => nodes.slice(-3).map(node => parseFloat(node.style.top)));
  const still = await tops();
  await figure.getByLabel("Amplitude").fill("0");
  await picture();
  const resting = await tops();
  assert.ok(still.every((top, i) => Math.abs(top - resting[i]) > 1), `${still} ${resting}`);  // they move with the shape
  await figure.getByLabel("Amplitude").fill("0.08");
  await shoot(figure, "structure-measured");
  await choose("undeformed");
  await picture();
  assert.equal(await dots(), fewer);
  assert.match(await figure.locator(".key").textContent(), /measured/);
  assertQuiet(page);
});

test("it turns by mouse and keyboard and comes back", async () => {
  const {page, stage, picture} = await opened();
  const first = await picture();
  const {x, y} = await stage.boundingBox();
  await page.mouse.move(x + 300, y + 200);
  await page.mouse.down();
  await page.mouse.move(x + 400, y + 220);
  await page.mouse.up();
  const turned = await picture();
  assert.notDeepEqual(turned, first);
  for (const key of ["ArrowRight", "Shift+ArrowUp", "+", "-"]) {
    const before = await picture();
    await stage.press(key);
    assert.notDeepEqual(await picture(), before, key);
  }
  await stage.press("0");
  await stage.blur();
  assert.deepEqual(await picture(), first);
});

test("it plays, and stands still for those who ask for it", async () => {
  const {page, figure, choose, picture} = await opened({reducedMotion: "no-preference"});
  await choose("estimated motion");
  const clock = () => figure.locator("output").textContent();
  assert.equal(await figure.locator(".play").textContent(), "Pause");
  const before = await clock();
  await page.waitForFunction(text => document.querySelector("output").textContent !== text, before);
  await figure.locator(".play").click();
  const still = await picture();
  await page.waitForTimeout(200);
  assert.deepEqual(await picture(), still);
  await figure.getByLabel("Time").fill("1");
  assert.equal(await clock(), "1.00 s");
  const large = await picture();
  await figure.getByLabel("Amplitude").fill("0");
  assert.notDeepEqual(await picture(), large);

  const quiet = await opened();
  await quiet.choose("mode 1: 12.50 Hz");
  assert.equal(await quiet.figure.locator(".play").textContent(), "Play");
});

test("without WebGL the page says so", async () => {
  const plain = await launch(["--disable-webgl", "--disable-3d-apis"]);
  try {
    const page = await open(plain, "structure.html");
    await page.locator(".structure .note").first().waitFor();
    assert.match(await page.textContent(".structure .note"), /offers no WebGL/);
    assert.deepEqual(await tally(page), {charts: "6", curves: "17", scenes: "0", errors: "0", resources: "0"});
  } finally {
    await plain.close();
  }
});
