// SPDX-License-Identifier: Apache-2.0
// The values under the cursor of a chart, beside it.

import {cssColor, make} from "./dom.js";
import {formatted, inUnitsOf} from "./numbers.js";

const reach = 40;  // pixels from the cursor within which a point of a path is read

export class Readout {
  constructor(data, curves) {
    this.data = data;
    this.curves = curves;
    this.node = make("div", {class: "tip", role: "status"});
  }

  // Shows the values at the plot's cursor, or nothing.
  show(plot, wanted) {
    const lines = wanted ? this.lines(plot) : [];
    if (!lines.length && !this.node.firstChild) return;
    this.node.replaceChildren(...lines);
    if (!lines.length) return;
    const {cursor, over: {clientWidth: width, clientHeight: height}} = plot;
    const right = cursor.left < width / 2;
    this.node.style.left = right ? `${cursor.left + 14}px` : "auto";
    this.node.style.right = right ? "auto" : `${width - cursor.left + 14}px`;
    this.node.style.top = `${Math.max(0, Math.min(cursor.top, height - this.node.offsetHeight))}px`;
  }

  lines(plot) {
    const {left, idx, idxs} = plot.cursor;
    if (!(left >= 0)) return [];
    const lines = this.curves.filter(curve => curve.show && idxs[curve.index] != null)
                      .map(curve => this.line(plot.scales, curve, idxs[curve.index]));
    if (this.data.scatter || idx == null) return lines;
    return [make("span", {}, `${this.data.x_label}  `, make("b", {}, formatted(this.data.x[idx]))), ...lines];
  }

  line({x, y}, curve, k) {
    const mark = make("i", {style: `background:${cssColor(curve.color)}`});
    const at = this.data.scatter ? inUnitsOf(x, [curve.x[k]], a => a) + ", " : "";
    const value = at + inUnitsOf(y, [curve.y[k]], v => v);
    const band = curve.lower ? inUnitsOf(y, [curve.lower[k], curve.upper[k]], (a, b) => `  ${a} \u2026 ${b}`) : "";
    return make("span", {}, mark, `${curve.label}  `, make("b", {}, value), band);
  }

  // The point of a path that is nearest to the cursor.
  nearest(plot, seriesIndex) {
    const curve = this.curves[seriesIndex - 1];
    let best = null, distance = reach * reach;
    for (let k = 0; k < curve.x.length; ++k) {
      if (curve.x[k] == null || curve.y[k] == null) continue;
      const d = (plot.valToPos(curve.x[k], "x") - plot.cursor.left) ** 2 +
                (plot.valToPos(curve.y[k], "y") - plot.cursor.top) ** 2;
      if (d < distance) { distance = d; best = k; }
    }
    return best;
  }
}
