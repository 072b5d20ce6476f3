// SPDX-License-Identifier: Apache-2.0
// Links to a moment of a chart: "#chart-<id>@12.5" shows 12.5 s in all charts over time.

import {unfold} from "./folds.js";

export function followLinksToMoments(group) {
  const follow = hash => {
    const {id, moment} = target(hash);
    unfold(document.getElementById(id));
    const view = group.views.find(each => each.figure.id === id);
    if (!view || view.data.scatter) return false;
    view.figure.scrollIntoView({block: "center"});
    view.canvas.focus({preventScroll: true});
    group.showMoment(view, moment);
    return true;
  };
  addEventListener("hashchange", () => follow(location.hash));
  // A second click on the same link changes no hash, but the reader wants to be there again.
  document.addEventListener("click", event => {
    const link = event.target.closest?.("a[href^='#chart-']");
    if (link && link.hash === location.hash) follow(link.hash);
  });
  follow(location.hash);
}

function target(hash) {
  const [, id, moment] = decodedOrEmpty(hash).match(/^#(chart-.*)@(-?[\d.]+(?:e[+-]?\d+)?)$/i) || [];
  return {id, moment: Number(moment)};
}

function decodedOrEmpty(hash) {
  try {
    return decodeURIComponent(hash);
  } catch {
    return "";  // a stray percent sign: no link of this page
  }
}
