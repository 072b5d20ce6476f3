// SPDX-License-Identifier: Apache-2.0
// What came of the page's scripts, on <body> for tests: data-charts, data-curves and data-scenes drawn, data-errors met,
// data-resources taken from outside (always 0).

const tally = {charts: 0, curves: 0, scenes: 0, errors: 0, resources: 0};

export function count(what, more = 1) {
  tally[what] += more;
  document.body.dataset[what] = tally[what];
}

export function startTally() {
  Object.assign(document.body.dataset, tally);
  addEventListener("error", () => count("errors"));
  addEventListener("unhandledrejection", () => count("errors"));
}

export function countResources() {
  const outside = "[src]:not([src^='data:']), link[href], [href^='http'], [href^='//']";
  count("resources", performance.getEntriesByType("resource").length + document.querySelectorAll(outside).length);
}
