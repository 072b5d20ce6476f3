// SPDX-License-Identifier: Apache-2.0
// node run.mjs <program> <folder of node_modules> <folder for pages and screenshots> [folder of tests]
//
// Lets the program write the pages and runs every *.test.mjs beside this file on them; tests in another folder start the
// program, PROGRAM of their surroundings, themselves. Ends with 77, which ctest takes as skipped, where there is no
// Chromium; with CI=true that is a failure, because continuous integration has it.

import {execFileSync, spawnSync} from "node:child_process";
import {existsSync, mkdirSync, readdirSync} from "node:fs";
import {dirname, join, resolve} from "node:path";
import {fileURLToPath} from "node:url";

const [program, packages, folder, others] = process.argv.slice(2).map(path => resolve(path));
const places = (process.env.PATH || "").split(":").map(place => join(place, "chromium"));
const chromium = places.find(existsSync);
if (!chromium) {
  console.log("the program chromium is not installed; scripts/setup --tests installs it");
  process.exit(process.env.CI === "true" ? 1 : 77);
}
mkdirSync(folder, {recursive: true});
if (!others) execFileSync(program, [folder], {stdio: "inherit"});
const here = others || dirname(fileURLToPath(import.meta.url));
const tests = readdirSync(here).filter(name => name.endsWith(".test.mjs")).map(name => join(here, name));
const run = spawnSync(process.execPath, ["--test", "--test-concurrency=1", ...tests], {
  stdio: "inherit", env: {...process.env, CHROMIUM: chromium, TEST_PACKAGES: packages, PAGES: folder, PROGRAM: program},
});
process.exit(run.status ?? 1);
