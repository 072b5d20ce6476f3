// SPDX-License-Identifier: Apache-2.0
// The page as a whole: dark, narrow, on paper, read aloud.

import assert from "node:assert/strict";
import {writeFileSync} from "node:fs";
import {join} from "node:path";
import {after, before, test} from "node:test";
import {assertQuiet, launch, open, shoot} from "./browser.mjs";

let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

const background = page => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
const inkOfAxes = page => page.evaluate(() => {
  const canvas = document.querySelector("[data-chart] canvas");
  return Array.from(canvas.getContext("2d").getImageData(0, 0, 60, canvas.height).data).reduce((sum, value) => sum + value, 0);
});

test("the first screen holds the sentence, the verdict, the parameters and the picture", async () => {
  const page = await open(browser, "overview.html", {viewport: {width: 1400, height: 900}});
  for (const part of [".verdict .badge", ".verdict p", ".table.half table", ".picture.half svg"]) {
    const {x, y, width, height} = await page.locator(part).boundingBox();
    assert.ok(width > 0 && x + width <= 1400, `${part} ends at ${x + width} across`);
    assert.ok(height > 0 && y + height <= 900, `${part} ends at ${y + height} down`);
  }
  const {cut} = await page.evaluate(() => {
    const card = document.querySelector(".table.half");
    return {cut: card.scrollWidth - card.clientWidth};
  });
  assert.equal(cut, 0, "the table is wider than its card");
  assertQuiet(page);
});

test("dark surroundings make the page and its charts dark", async () => {
  const light = await open(browser, "structure.html");
  const dark = await open(browser, "structure.html", {colorScheme: "dark"});
  assert.notEqual(await background(light), await background(dark));
  assert.notEqual(await inkOfAxes(light), await inkOfAxes(dark));
  await dark.locator(".scene canvas").first().waitFor();
  await shoot(dark, "page-dark", {fullPage: true});
  await light.emulateMedia({colorScheme: "dark"});  // while it is open
  const darkInk = await inkOfAxes(dark);
  let ink;
  for (let trial = 0; trial < 100 && ink !== darkInk; ++trial) {  // a busy machine draws late
    await light.waitForTimeout(100);
    ink = await inkOfAxes(light);
  }
  assert.equal(ink, darkInk);
  assertQuiet(dark);
});

test("a phone shows all of it without scrolling aside", async () => {
  const page = await open(browser, "structure.html", {viewport: {width: 380, height: 800}, hasTouch: true, isMobile: true});
  await page.locator(".scene canvas").first().waitFor();
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 380);
  const wide = await page.evaluate(() => [...document.querySelectorAll("figure, .table, .tools, .controls")]
      .filter(node => node.getBoundingClientRect().right > innerWidth).map(node => node.className));
  assert.deepEqual(wide, []);
  await shoot(page, "page-narrow", {fullPage: true});
  assertQuiet(page);
});

test("it prints on A4", async () => {
  const page = await open(browser, "structure.html", {colorScheme: "dark"});
  await page.locator(".scene canvas").first().waitFor();
  const pdf = await page.pdf({format: "A4"});
  writeFileSync(join(process.env.PAGES, "page.pdf"), pdf);
  assert.ok(pdf.toString("latin1").match(/\/Type\s*\/Page\b/g).length >= 3);
  assertQuiet(page);
});

test("nothing is cut by the end of a sheet", async () => {
  const page = await open(browser, "structure.html", {viewport: {width: 690, height: 1017}});  // A4 without its margins
  await page.emulateMedia({media: "print"});
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  const cards = await page.evaluate(() => [...document.querySelectorAll(".chart, .table")].map(card => ({
    broken: getComputedStyle(card).breakInside, height: card.getBoundingClientRect().height,
    wide: [...card.querySelectorAll("canvas, svg, img, .stage")].some(node => node.getBoundingClientRect().right > innerWidth),
  })));
  assert.ok(cards.length >= 9);
  for (const {broken, height, wide} of cards) {
    assert.equal(broken, "avoid");
    assert.ok(height < 1017, `${height}`);
    assert.equal(wide, false);
  }
  assertQuiet(page);
});

test("charts and structures describe themselves", async () => {
  const page = await open(browser, "structure.html");
  await page.locator(".stage").first().waitFor();
  const chart = await page.getAttribute("#chart-p5 .canvas", "aria-label");
  assert.match(chart, /frame\.p5\.z, displacement: displacement \[m\] over time \[s\]\. Curves: measured, .* to .*; estimate/);
  assert.match(await page.getAttribute(".stage", "aria-label"), /plate.*mode 2: 31\.25 Hz.*arrows turn/);
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, select, input, summary")]
      .filter(node => !(node.textContent.trim() || node.getAttribute("aria-label") || node.closest("label")?.textContent.trim()))
      .map(node => node.outerHTML));
  assert.deepEqual(unnamed, []);
});
