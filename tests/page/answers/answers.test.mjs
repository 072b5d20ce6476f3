// SPDX-License-Identifier: Apache-2.0
// The pages of three examples at 1400 and at 380 pixels.

import assert from "node:assert/strict";
import {spawnSync} from "node:child_process";
import {readFileSync, rmSync} from "node:fs";
import {dirname, join} from "node:path";
import {fileURLToPath} from "node:url";
import {after, before, test} from "node:test";
import {assertQuiet, launch, open, shoot} from "../browser/browser.mjs";

const source = join(dirname(fileURLToPath(import.meta.url)), "../../..");
const runs = {
  measured: ["start/measured/case.yaml"],
  doubted: ["start/measured/case.yaml", "--set", "sensors.body.noise=2 m/s^2"],
  chain: ["chain/chain.yaml", "--set", "simulate.duration=4s"],
  plate: ["static/hole.yaml"],
};
const screens = {wide: {width: 1400, height: 900}, narrow: {width: 380, height: 800}};

let browser;
before(async () => {
  for (const [name, [example, ...options]] of Object.entries(runs)) {
    const out = join(process.env.PAGES, name);
    rmSync(out, {recursive: true, force: true});
    const run = spawnSync(process.env.PROGRAM, ["run", "--quiet", join(source, "examples", example), ...options, "--out", out]);
    assert.ok([0, 3].includes(run.status), String(run.stderr));
  }
  browser = await launch();
});
after(() => browser.close());

const opened = (name, screen, options = {}) => open(browser, `${name}/report.html`, {viewport: screens[screen], ...options});

// {number, elements, answered} of the table of questions; `column` counts from the first example.
function questions(column) {
  const lines = readFileSync(join(source, "docs/page-questions.md"), "utf8").split("\n").filter(line => /^\| \d/.test(line));
  return lines.map(line => line.slice(2, -2).split(" | ")).map(cells => ({
    number: cells[0], elements: cells[4].split("`").filter((part, i) => i % 2), answered: cells[5 + column] === "yes",
  }));
}

for (const screen of ["wide", "narrow"]) {
  test(`the main numbers and their bands stand on the first screen, ${screen}`, async () => {
    const page = await opened("measured", screen);
    const row = page.locator("tr", {hasText: "suspension.k"}).first();
    for (const part of [row.locator("th"), row.locator("td").first(), row.locator("svg")]) {
      const {x, y, width, height} = await part.boundingBox();
      assert.ok(x >= 0 && x + width <= screens[screen].width && y + height <= screens[screen].height, `${x} ${y}`);
    }
    const cut = await page.evaluate(() => {
      const card = document.querySelector(".table.half");
      return card.scrollWidth - card.clientWidth;
    });
    assert.equal(cut, 0, "the table is wider than its card");
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= screens[screen].width);
    await shoot(page, `first-screen-${screen}`);
    assertQuiet(page);
  });

  test(`every question is answered, ${screen}`, async () => {
    const page = await opened("chain", screen);
    const html = await page.content();
    for (const {number, elements, answered} of questions(0))
      assert.equal(elements.some(element => html.includes(element)), answered, `question ${number}`);
    const aside = await page.evaluate(() => [...document.querySelectorAll("figure, .table")]
        .filter(node => node.getBoundingClientRect().right > innerWidth).map(node => node.className));
    assert.deepEqual(aside, []);
  });

  test(`units and numbers are set as people write them, ${screen}`, async () => {
    for (const name of Object.keys(runs)) {
      const page = await opened(name, screen);
      const text = await page.evaluate(() => {
        document.querySelectorAll("pre, script, style, .listing").forEach(node => node.remove());
        return document.body.textContent;
      });
      assert.doesNotMatch(text, /[A-Za-z]\^-?\d/, name);
      assert.doesNotMatch(text, /\d(\.\d+)?e[+-]\d\d\b/, name);
    }
  });
}

test("the force over velocity with its points and band, and the law, stand beside the numbers", async () => {
  const page = await opened("measured", "wide");
  const chart = await page.locator("#chart-law").boundingBox();
  assert.ok(chart.y + chart.height <= 900, `ends at ${chart.y + chart.height}`);
  const data = JSON.parse(await page.locator("#chart-data").textContent())[0];
  const [points, law] = data.series;
  assert.ok(points.points && points.x.length > 100);
  assert.ok(law.lower.length > 10 && law.lower.every((low, i) => low <= law.upper[i]));
  assert.equal(points.label, "measured");  // accelerations feel the force at once
  const near = points.x.map((v, i) => [v, points.y[i]]).filter(([v]) => v > 0.5 * Math.max(...points.x));
  assert.ok(near.every(([, force]) => force > 0), "a damper resists");
  assert.ok(new Set(points.y.map((f, i) => (f / points.x[i]).toPrecision(3))).size > 50, "the points scatter about the law");
  const equation = await page.locator("figure.listing", {hasText: "The law of suspension"}).locator("pre").textContent();
  assert.match(equation, /^f = k d \+ k3 d³ \+ c v\nf = \(1[78]\.\d+ kN\/m\) d \+ \(1[12]\.\d+ MN\/m³\) d³ \+ \(1\.2\d* kN s\/m\) v$/);
  assertQuiet(page);
});

test("the edit that the verdict asks for and the numbers are copied", async () => {
  const context = await browser.newContext({permissions: ["clipboard-read", "clipboard-write"]});
  const page = await context.newPage();
  await page.goto(`file://${join(process.env.PAGES, "doubted/report.html")}`);
  const edit = page.locator("figure.listing", {hasText: "The edit that the verdict asks for"});
  assert.match(await edit.locator("pre").textContent(), /^sensors:\n  body: \{noise: [\d.]+ m?m\/s\^2\}/);
  await edit.locator("button").click();
  await edit.locator("button", {hasText: "Copied"}).waitFor();
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /^sensors:/);
  const numbers = page.locator(".table.half button.copy");
  await numbers.click();
  await page.locator("button", {hasText: "Copied"}).nth(1).waitFor();
  assert.match(await page.evaluate(() => navigator.clipboard.readText()), /suspension\.k\t1[78]\d{3}\.\d+\t/);
  await context.close();
});

test("agreement tells too large from too small, in words and colours", async () => {
  const page = await opened("doubted", "wide");
  const label = await page.locator("tr", {hasText: "body"}).locator("svg[aria-label^='Agreement']").first().getAttribute("aria-label");
  assert.match(label, /as expected \d+ %, too large 0 %, too small (9\d|100) %/);
  assert.ok(await page.locator("svg[aria-label^='Agreement'] rect[fill='var(--accent)']").count() > 0);
});

test("statics are in millimetres, their key ends at the headline, and no section is empty", async () => {
  const page = await opened("plate", "wide");
  const [, largest] = (await page.locator(".verdict p").textContent()).match(/largest stress is ([\d.]+) MPa/);
  const keys = await page.locator("figure.picture").allTextContents();
  assert.ok(keys.some(key => key.includes(`to ${largest} MPa`)));
  assert.equal(await page.locator("th", {hasText: "y [mm]"}).count(), 1);
  const empty = await page.evaluate(() => [...document.querySelectorAll("tbody")].filter(body => !body.rows.length)
      .map(body => body.closest("table").textContent));
  assert.deepEqual(empty, []);
});

test("the first sheet of paper is full", async () => {
  const page = await opened("measured", "wide", {viewport: {width: 690, height: 1017}});
  await page.emulateMedia({media: "print"});
  await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
  const {bottom} = await page.locator("#section-1").evaluate(node => node.getBoundingClientRect());
  assert.ok(bottom > 0.6 * 1017, `${bottom}`);
});

test("on paper nothing is cut, numbers keep to one line, and there are no buttons", async () => {
  for (const name of Object.keys(runs)) {
    const page = await opened(name, "wide", {viewport: {width: 690, height: 1017}});
    await page.emulateMedia({media: "print"});
    await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
    const {cut, broken, buttons} = await page.evaluate(() => {
      const seen = node => node.getClientRects().length > 0;
      const lines = node => {
        const range = document.createRange();
        range.selectNodeContents(node);
        return new Set([...range.getClientRects()].map(({bottom}) => Math.round(bottom / 4))).size;
      };
      return {
        cut: [...document.querySelectorAll(".table, .chart, figure")].filter(seen)
            .filter(node => node.scrollWidth > node.clientWidth + 1 || node.getBoundingClientRect().right > 691)
            .map(node => node.textContent.slice(0, 60)),
        broken: [...document.querySelectorAll("td.right")].filter(seen).filter(cell => !cell.querySelector("svg") && lines(cell) > 1)
            .map(cell => cell.textContent),
        buttons: [...document.querySelectorAll("button, select, input")].filter(node => seen(node) && !node.closest(".legend")).map(node => node.textContent),
      };
    });
    assert.deepEqual({cut, broken, buttons}, {cut: [], broken: [], buttons: []}, name);
  }
});

test("the force of a strut stands over time with its band and its extremes", async () => {
  const page = await opened("chain", "wide");
  const chart = page.locator("#chart-suspension-force");
  assert.equal(await chart.count(), 1);
  const data = JSON.parse(await page.locator("#chart-data").textContent())[Number(await chart.getAttribute("data-chart"))];
  const [force] = data.series;
  assert.ok(force.lower.every((low, i) => low === null || low <= force.upper[i]));
  const row = page.locator(".table", {hasText: "Forces after settling"}).locator("tbody tr").first();
  assert.match(await row.textContent(), /suspension/);
  const [low, high] = (await row.locator("td.right").allTextContents()).slice(0, 2).map(text => parseFloat(text.replace("\u2212", "-")));
  assert.ok(low < 0 && high > 0);
});
