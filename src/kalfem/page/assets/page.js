// SPDX-License-Identifier: Apache-2.0
// Draws the charts of the page from the JSON in #chart-data, and makes them work together.

import {ChartGroup} from "./chart_group.js";
import {ChartView, zoomHint} from "./chart_view.js";
import {followLinksToMoments} from "./moments.js";
import {whenUnfolded} from "./folds.js";
import {make} from "./dom.js";
import {markContents, openContentsBeside} from "./contents.js";
import {offerCopies} from "./copy.js";
import {redrawWhenNeeded} from "./redraw.js";
import {count, countResources, startTally} from "./tally.js";

startTally();
openContentsBeside();
offerCopies();
const group = new ChartGroup();
drawCharts();
addZoomLine();
followLinksToMoments(group);
redrawWhenNeeded(group);
markContents();
countResources();

function drawCharts() {
  const data = JSON.parse(document.getElementById("chart-data").textContent);
  for (const figure of document.querySelectorAll("[data-chart]")) {
    whenUnfolded(figure, () => drawChart(figure, data[figure.dataset.chart]));
  }
}

function drawChart(figure, data) {
  try {
    new ChartView(figure, data, group);
  } catch (error) {
    count("errors");
    figure.querySelector(".plot").append(make("p", {class: "note"}, `This chart could not be drawn: ${error.message}`));
  }
}

// Above the first charts below the overview: how to zoom, and the switch of the common zoom where there is anything in
// common.
function addZoomLine() {
  const first = group.views.find(view => !view.figure.closest(".abreast")) || group.views[0];
  if (!first) return;
  const line = make("div", {class: "tools"}, make("p", {}, zoomHint));
  if (group.views.some(view => group.alike(view).length > 1)) {
    const together = make("input", {type: "checkbox", role: "switch", checked: ""});
    together.addEventListener("change", () => { group.together = together.checked; });
    line.append(make("label", {}, together, "Zoom together"));
  }
  first.figure.closest(".items").before(line);
}
