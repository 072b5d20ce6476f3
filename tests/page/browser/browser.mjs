// SPDX-License-Identifier: Apache-2.0
// Opens the pages in Chromium and looks at them.

import assert from "node:assert/strict";
import {readFileSync} from "node:fs";
import {createRequire} from "node:module";
import {join} from "node:path";
import {pathToFileURL} from "node:url";

const {chromium} = createRequire(join(process.env.TEST_PACKAGES, "node_modules/"))("playwright-core");
const flags = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
               "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

export const launch = (more = []) => chromium.launch({executablePath: process.env.CHROMIUM, args: [...flags, ...more]});

// Opens a page of the folder, or the one at an `address`; `page.complaints` collects errors and warnings of its scripts.
export async function open(browser, name, {hash = "", address = "", ...options} = {}) {
  const page = await browser.newPage({viewport: {width: 1400, height: 1000}, reducedMotion: "reduce", ...options});
  page.complaints = [];
  const isOut = text => address && text.includes("ERR_CONNECTION_REFUSED");  // the server of the address has ended
  const onSpeed = text => text.includes("GL Driver Message") || text.startsWith("Canvas2D: Multiple readback");  // of tests
  page.on("console", message => {
    if (["error", "warning"].includes(message.type()) && !onSpeed(message.text()) && !isOut(message.text())) page.complaints.push(message.text());
  });
  page.on("pageerror", error => page.complaints.push(error.stack));
  page.on("request", request => {
    const own = address && request.url().startsWith(address);
    if (!own && !/^(file|data|blob):/.test(request.url())) page.complaints.push(`asked for ${request.url()}`);
  });
  await page.goto(address || pathToFileURL(join(process.env.PAGES, name)) + hash);
  return page;
}

export const tally = page => page.evaluate(() => ({...document.body.dataset}));

export function assertQuiet(page) {
  assert.deepEqual(page.complaints, []);
}

// A screenshot that is kept beside the pages.
export const shoot = (target, name, options = {}) =>
    target.screenshot({path: join(process.env.PAGES, `${name}.png`), ...options});

// Number of different colours in a picture (a PNG).
export const colors = (page, png) => page.evaluate(async address => {
  const image = Object.assign(document.createElement("img"), {src: address});
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), {width: image.width, height: image.height});
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  return new Set(new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer)).size;
}, `data:image/png;base64,${png.toString("base64")}`);

// Saves what a chart shows, by its menu: the name and the bytes of the file.
export async function exported(page, chart, kind) {
  await page.click(`#chart-${chart} summary`);
  const [download] = await Promise.all([page.waitForEvent("download"),
                                        page.click(`#chart-${chart} .export button:text-is("${kind}")`)]);
  return {name: download.suggestedFilename(), bytes: readFileSync(await download.path())};
}

// First and last time that a chart shows, read from its numbers.
export async function shownTimes(page, chart) {
  const {bytes} = await exported(page, chart, "CSV");
  const times = bytes.toString().trim().split("\r\n").slice(1).map(line => Number(line.split(",")[0]));
  return [times[0], times.at(-1)];
}

// Drags over a part of a chart, from one share of its width to another.
export async function drag(page, chart, from, to) {
  const area = page.locator(`#chart-${chart} .u-over`);
  await area.scrollIntoViewIfNeeded();
  const {x, y, width, height} = await area.boundingBox();
  await page.mouse.move(x + from * width, y + 0.4 * height);
  await page.mouse.down();
  await page.mouse.move(x + (from + to) / 2 * width, y + 0.5 * height);
  await page.mouse.move(x + to * width, y + 0.6 * height);
  await page.mouse.up();
}
