// SPDX-License-Identifier: Apache-2.0
// Charts: they are drawn, zoom together, follow links to moments, and save what they show.

import assert from "node:assert/strict";
import {after, before, test} from "node:test";
import {assertQuiet, colors, drag, exported, launch, open, shoot, shownTimes, tally} from "./browser.mjs";

const overTime = ["mu_k1", "mu_c1", "p5", "p5-late", "nis"];
let browser;
before(async () => { browser = await launch(); });
after(() => browser.close());

const close = (value, expected, tolerance) =>
    assert.ok(Math.abs(value - expected) <= tolerance, `${value} is not ${expected} within ${tolerance}`);

test("every chart has ink", async () => {
  const page = await open(browser, "charts.html");
  assert.deepEqual(await tally(page), {charts: "6", curves: "17", scenes: "0", errors: "0", resources: "0"});
  const inks = await page.evaluate(() => [...document.querySelectorAll("[data-chart] canvas")].map(canvas => {
    const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }));
  assert.equal(inks.length, 6);
  inks.forEach(count => assert.ok(count > 20, `${count} colours`));
  await shoot(page, "charts-light", {fullPage: true});
  assertQuiet(page);
});

test("charts of one value or none are drawn", async () => {
  const page = await open(browser, "meagre.html");
  const {charts, errors} = await tally(page);
  assert.deepEqual({charts, errors}, {charts: "4", errors: "0"});
  assertQuiet(page);
});

test("charts that are folded away are drawn when they are opened", async () => {
  const page = await open(browser, "folded.html");
  assert.equal((await tally(page)).charts, "1");
  await drag(page, "open", 0.25, 0.5);
  await page.click("summary:text-is('more')");
  await page.waitForFunction(() => document.body.dataset.charts === "3");
  close((await shownTimes(page, "first"))[0], 5, 0.05);  // it joins the zoom
  await page.locator("#chart-first .u-over").dblclick();
  await drag(page, "open", 0.5, 0.75);
  close((await shownTimes(page, "second"))[0], 10, 0.05);
  assertQuiet(page);
});

test("a link to a folded chart opens it", async () => {
  const page = await open(browser, "folded.html", {hash: "#chart-second@12.5"});
  assert.equal((await tally(page)).charts, "3");
  const [from, to] = await shownTimes(page, "second");
  assert.ok(from < 12.5 && 12.5 < to);
  assertQuiet(page);
});

test("folded charts are printed", async () => {
  const page = await open(browser, "folded.html");
  await page.pdf({format: "A4"});
  assert.equal((await tally(page)).charts, "3");
});

test("a drag zooms all charts over time, a double click shows everything", async () => {
  const page = await open(browser, "charts.html");
  await drag(page, "p5", 0.25, 0.5);
  for (const chart of overTime) {
    const [from, to] = await shownTimes(page, chart);
    close(from, 5, 0.05);
    close(to, 10, 0.05);
  }
  await shoot(page, "charts-zoomed", {fullPage: true});
  await page.locator("#chart-nis .u-over").dblclick();
  for (const chart of overTime) assert.deepEqual(await shownTimes(page, chart), [0, 20]);
  await page.click("#chart-p5-late button:text-is('First view')");
  const [from, to] = await shownTimes(page, "p5-late");
  close(from, 2, 0.01);
  close(to, 3.5, 0.01);
  assertQuiet(page);
});

test("a chart off the screen is drawn when it comes into sight", async () => {
  const page = await open(browser, "charts.html", {viewport: {width: 1400, height: 700}});
  const picture = chart => page.evaluate(id => document.querySelector(`#chart-${id} canvas`).toDataURL(), chart);
  const before = {near: await picture("mu_c1"), far: await picture("nis")};
  await drag(page, "mu_k1", 0.25, 0.5);
  await page.waitForTimeout(100);
  assert.notEqual(await picture("mu_c1"), before.near);
  assert.equal(await picture("nis"), before.far);
  await page.locator("#chart-nis").scrollIntoViewIfNeeded();
  await page.waitForFunction(old => document.querySelector("#chart-nis canvas").toDataURL() !== old, before.far);
  assertQuiet(page);
});

test("without the switch a chart zooms alone", async () => {
  const page = await open(browser, "charts.html");
  await page.uncheck("input[role=switch]");
  await drag(page, "p5", 0.25, 0.5);
  close((await shownTimes(page, "p5"))[0], 5, 0.05);
  assert.deepEqual(await shownTimes(page, "nis"), [0, 20]);
});

test("the keyboard reads values and zooms", async () => {
  const page = await open(browser, "charts.html");
  await page.focus("#chart-p5 .canvas");
  await page.keyboard.press("ArrowRight");
  assert.match(await page.textContent("#chart-p5 .tip"), /time \[s\]\s+10\.\d+.*estimate/);
  await page.keyboard.press("+");
  const [from, to] = await shownTimes(page, "nis");
  close(to - from, 10, 0.1);
  await page.focus("#chart-p5 .canvas");
  await page.keyboard.press("0");
  assert.deepEqual(await shownTimes(page, "nis"), [0, 20]);
});

test("a link shows a moment in all charts", async () => {
  const page = await open(browser, "charts.html", {hash: "#chart-p5@12.5"});
  const [from, to] = await shownTimes(page, "nis");
  close(from, 11, 0.02);  // the zoomed view is 1.5 s wide
  close(to, 14, 0.02);
  await page.mouse.move(0, 0);
  await page.evaluate(() => { location.hash = "#chart-mu_k1@3"; });
  await page.waitForFunction(() => document.activeElement.closest("figure")?.id === "chart-mu_k1");
  assert.match(await page.textContent("#chart-mu_k1 .tip"), /time \[s\]\s+3/);
  for (const stray of ["#chart-none@3", "#chart-p5@soon", "#%"]) await page.evaluate(hash => { location.hash = hash; }, stray);
  assertQuiet(page);
});

test("saved numbers have names, units, bands and gaps", async () => {
  const page = await open(browser, "charts.html");
  const {name, bytes} = await exported(page, "p5", "CSV");
  assert.equal(name, "chart-p5.csv");
  const [head, ...lines] = bytes.toString().trim().split("\r\n");
  assert.equal(head, 'time [s],measured [m],estimate [m],"estimate, lower limit [m]","estimate, upper limit [m]",reference [m]');
  assert.ok(lines.length > 1000, `${lines.length} lines`);
  for (const line of lines) {
    const [time, , estimate, lower, upper, reference] = line.split(",").map(Number);
    assert.ok(lower <= estimate && estimate <= upper);
    close(reference, 3e-3 * Math.sin(8 * time) + 1.2e-3 * Math.sin(31 * time + 0.4) * Math.cos(0.7 * time), 1e-8);
  }
  await page.click("#chart-p5 .legend button:has-text('measured')");
  assert.doesNotMatch((await exported(page, "p5", "CSV")).bytes.toString(), /measured/);
  const loop = (await exported(page, "loop", "CSV")).bytes.toString();
  assert.ok(loop.startsWith("reference: deformation [m],reference: force [N],estimate: deformation [m],estimate: force [N]\r\n"));
});

test("a saved drawing is a drawing", async () => {
  const page = await open(browser, "charts.html", {colorScheme: "dark"});
  const {name, bytes} = await exported(page, "p5-late", "SVG");
  assert.equal(name, "chart-p5-late.svg");
  const found = await page.evaluate(text => {
    const svg = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    const paths = [...svg.querySelectorAll("g[clip-path] path")];
    return {tag: svg.tagName, texts: [...svg.querySelectorAll("text")].map(node => node.textContent),
            strokes: paths.map(path => path.getAttribute("stroke")), images: svg.querySelectorAll("image").length,
            corners: paths.map(path => path.getAttribute("d").split("L").length)};
  }, bytes.toString());
  assert.equal(found.tag, "svg");
  assert.equal(found.images, 0);
  for (const text of ["The same after two seconds", "measured", "estimate", "reference", "time [s]", "2.4"])
    assert.ok(found.texts.includes(text), `${text} in ${found.texts}`);
  assert.deepEqual(found.strokes, [null, "#98a2ad", "#0072b2", "#1b2129"]);  // a band and the curves, in colours of print
  found.corners.forEach(count => assert.ok(count > 1000, `${count} corners`));
  const loop = (await exported(page, "loop", "SVG")).bytes.toString();
  assert.match(loop, />deformation \[m\]/);
});

test("a saved picture has what the drawing has", async () => {
  const page = await open(browser, "charts.html");
  const {name, bytes} = await exported(page, "p5", "PNG");
  assert.equal(name, "chart-p5.png");
  assert.ok(await colors(page, bytes) > 50);
  assertQuiet(page);
});

test("the menu is reached and left with the keyboard", async () => {
  const page = await open(browser, "charts.html");
  await page.focus("#chart-nis summary");
  await page.keyboard.press("Enter");
  await page.keyboard.press("Tab");
  assert.equal(await page.evaluate(() => document.activeElement.textContent), "PNG");
  await page.keyboard.press("Escape");
  assert.equal(await page.getAttribute("#chart-nis details", "open"), null);
});
