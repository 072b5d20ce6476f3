// SPDX-License-Identifier: Apache-2.0
// Search in the site as it is opened from the disk: a word that one page has is found, and its link leads there.
//   node search.test.mjs SITE PACKAGES      ends with 77 where there is no Chromium, except with CI=true

import assert from "node:assert/strict";
import {existsSync} from "node:fs";
import {createRequire} from "node:module";
import {join, resolve} from "node:path";
import {pathToFileURL} from "node:url";

const [site, packages] = process.argv.slice(2).map(path => resolve(path));
const chromium = (process.env.PATH || "").split(":").map(place => join(place, "chromium")).find(existsSync);
if (!chromium || !existsSync(site)) {
  console.log(chromium ? `there is no ${site}: docs_site makes it` : "the program chromium is not installed");
  process.exit(process.env.CI === "true" ? 1 : 77);
}
const {chromium: driver} = createRequire(join(packages, "node_modules/"))("playwright-core");
const browser = await driver.launch({executablePath: chromium, args: ["--no-sandbox", "--disable-gpu"]});

try {
  // From the top, and from a page in a folder: links are relative to where the reader is.
  for (const from of ["index.html", "theory/smoother.html"]) {
    const page = await browser.newPage({viewport: {width: 1400, height: 1000}});
    await page.goto(pathToFileURL(join(site, from)).href);
    await page.fill("input[name=query]", "Rauch-Tung-Striebel");
    const link = page.locator(".md-search-result__link").first();
    await link.waitFor({timeout: 60000});
    assert.match(await link.getAttribute("href"), /theory\/smoother\.html/, "the first hit is the page of the smoother");
    await page.close();
  }
} finally {
  await browser.close();
}
