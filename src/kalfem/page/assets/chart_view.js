// SPDX-License-Identifier: Apache-2.0
// One chart: its legend, its canvas drawn by uPlot, and what part of the data is in view.
//
// A view {x, y, base, zoomed} is the range along x, on a scatter chart also along y, the view that it was zoomed from
// ("first" or "all"), and whether it is closer than that one. Every change of it goes through the group of charts that
// zoom together. A chart that is off the screen takes a new view at once but draws it when it comes into sight.

import uPlot from "uplot";
import {inLegendOrder, styledCurves, swatch} from "./curves.js";
import {button, make} from "./dom.js";
import {exportMenu} from "./export_menu.js";
import {extent, formatted} from "./numbers.js";
import {axisOptions, padded, plotRows, plotSeries} from "./plot_options.js";
import {Readout} from "./readout.js";
import {count} from "./tally.js";

const heights = {full: 270, half: 290, scatter: 290};
const onPaper = {full: [650, 185], half: [300, 165], scatter: [300, 210]};  // CSS pixels that fit on A4

export const zoomHint = "Drag across a chart to zoom, double-click to show everything. With the keyboard: Tab to a chart, " +
                        "arrows read values, + and \u2212 zoom, 0 shows everything.";

export class ChartView {
  constructor(figure, data, group) {
    this.figure = figure;
    this.data = data;
    this.group = group;
    this.size = Object.keys(heights).find(name => figure.classList.contains(name));
    this.curves = styledCurves(data.series);
    this.readout = new Readout(data, this.curves);
    this.onScreen = true;
    this.legend = make("div", {class: "legend", role: "group", "aria-label": "Curves"});
    this.canvas = make("div", {class: "canvas", tabindex: "0", role: "application", "aria-roledescription": "chart",
                               "aria-label": this.description(), title: zoomHint});
    figure.querySelector(".plot").append(this.legend, this.canvas);
    this.canvas.addEventListener("keydown", event => this.onKey(event));
    this.canvas.addEventListener("blur", () => { this.byKeyboard = false; this.readOut(); });
    this.fillLegend();
    this.view = this.firstView();
    this.build();
    group.add(this);
  }

  get title() { return this.figure.querySelector("h3")?.textContent || "Chart"; }

  description() {
    const range = ({y}) => (extent([y]) || [null, null]).map(formatted).join(" to ");
    const curves = this.data.series.map(series => `${series.label}, ${range(series)}`);
    return `${this.title}: ${this.data.y_label} over ${this.data.x_label}. Curves: ${curves.join("; ")}. ` +
           "Arrow keys read values, plus and minus zoom, zero shows everything.";
  }

  // ---- drawing

  // Draws anew, with the colours and the width of the moment.
  build(width = this.canvas.clientWidth, height = heights[this.size]) {
    this.plot?.destroy();
    this.plot = new uPlot(this.options(Math.max(width, 160), height), plotRows(this.data, this.curves), this.canvas);
    this.plot.over.append(this.readout.node);
    this.draw();
  }

  buildForPrint() { this.build(...onPaper[this.size]); }

  options(width, height) {
    const {scatter, x_label, y_label} = this.data;
    return {
      mode: scatter ? 2 : 1, width, height, ...plotSeries(this.data, this.curves),
      legend: {show: false}, padding: [10, 14, 0, 0],
      scales: {x: {time: false, range: (u, low, high) => this.xRange(low, high)},
               y: {range: (u, low, high) => this.yRange(low, high)}},
      axes: [axisOptions("x", x_label), axisOptions("y", y_label)],
      cursor: {
        y: scatter, drag: {x: true, y: scatter, uni: 20, dist: 4, setScale: false},
        points: {show: (u, i) => u.series[i].isEdge ? false : undefined, size: 7},
        bind: {dblclick: () => () => { this.group.showAll(this); return null; }},
        ...(scatter ? {dataIdx: (u, i) => this.readout.nearest(u, i)} : {sync: this.group.cursorOf(this)}),
      },
      hooks: {draw: [u => this.countOnce(u)], setCursor: [() => this.readOut()], setSelect: [u => this.onSelect(u)]},
    };
  }

  xRange(low, high) {
    if (low == null) return [0, 1];
    return low < high ? [low, high] : padded([low, high]);
  }

  // A given window holds, also while zooming along x, until everything is asked for.
  yRange(low, high) {
    if (this.data.scatter) return this.xRange(low, high);
    if (this.view.base === "first" && this.data.y_window) return this.data.y_window;
    return low == null ? [0, 1] : padded([low, high]);
  }

  draw() {
    this.stale = false;
    this.offerViews();
    const {x, y} = this.view;
    this.plot.batch(() => {
      this.plot.setScale("x", {min: x[0], max: x[1]});
      if (this.data.scatter) this.plot.setScale("y", {min: y[0], max: y[1]});
    });
  }

  // Fits the plot into the room that the page gives it.
  fit() {
    const width = this.canvas.clientWidth;
    if (width > 0 && width !== this.plot.width) this.plot.setSize({width, height: this.plot.height});
  }

  comeIntoSight(onScreen) {
    this.onScreen = onScreen;
    if (onScreen && this.stale) this.draw();
  }

  countOnce(u) {
    if (this.counted) return;
    this.counted = true;
    count("charts");
    count("curves", this.curves.filter(curve => u.series[curve.index]._paths).length);
  }

  // ---- views

  firstView() {
    const {x_window, y_window} = this.data;
    return {x: x_window || this.everything("x"), y: y_window || this.everything("y"), base: "first", zoomed: false};
  }

  fullView() { return {x: this.everything("x"), y: this.everything("y"), base: "all", zoomed: false}; }

  closerView(x, y = this.view.y) { return {x, y, base: this.view.base, zoomed: true}; }

  everything(scale) {
    const range = extent(scale === "x" && !this.data.scatter ? [this.data.x] : this.curves.flatMap(curve => scale === "x" ? [curve.x] : [curve.y, curve.lower || [], curve.upper || []]));
    return scale === "x" && !this.data.scatter ? range || [0, 1] : padded(range || [0, 1]);
  }

  setView(view) {
    this.view = view;
    if (this.onScreen) this.draw();
    else this.stale = true;
  }

  // Draws what has come to the lists of its data since; a view that was zoomed stays.
  renew() {
    this.plot.setData(plotRows(this.data, this.curves), false);
    this.setView(this.view.zoomed ? this.view : this.firstView());
  }

  // Offers the views that are not on show: the first one, everything, or both after a zoom.
  offerViews() {
    const {base, zoomed} = this.view;
    const same = !this.data.x_window && !this.data.y_window;
    this.toFirst.hidden = same || (base === "first" && !zoomed);
    this.toAll.hidden = !zoomed && (same || base === "all");
  }

  onSelect(u) {
    const {left, top, width, height} = u.select;
    u.setSelect({left: 0, top: 0, width: 0, height: 0}, false);
    const x = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
    const y = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
    if (x[0] < x[1]) this.group.zoom(this, x, y);
  }

  zoomBy(factor) {
    const {min, max} = this.plot.scales.x;
    const {left} = this.plot.cursor;
    const middle = left >= 0 ? this.plot.posToVal(left, "x") : (min + max) / 2;
    const half = factor * (max - min) / 2;
    const [first, last] = this.everything("x");
    const x = [Math.max(first, middle - half), Math.min(last, middle + half)];
    if (x[0] < x[1]) this.group.zoom(this, x);
  }

  // ---- legend, readout and keyboard

  fillLegend() {
    for (const curve of inLegendOrder(this.curves, this.data.series)) {
      const key = button("", () => this.toggle(curve, key), {"aria-pressed": "true", title: "Show or hide"});
      key.innerHTML = swatch(curve);
      key.append(curve.label);
      this.legend.append(key);
    }
    this.toFirst = button("First view", () => this.group.showFirst(this));
    this.toAll = button("Show all", () => this.group.showAll(this));
    this.legend.append(make("span", {class: "view"}, this.toFirst, this.toAll, exportMenu(this)));
  }

  toggle(curve, key) {
    curve.show = !curve.show;
    key.setAttribute("aria-pressed", curve.show);
    for (let i = 0; i < (curve.lower && !this.data.scatter ? 3 : 1); ++i) this.plot.setSeries(curve.index + i, {show: curve.show});
  }

  readOut() { this.readout.show(this.plot, this.byKeyboard || this.figure.matches(":hover")); }

  onKey(event) {
    const actions = {
      ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1),
      PageUp: () => this.step(-50), PageDown: () => this.step(50),
      "+": () => this.zoomBy(0.5), "-": () => this.zoomBy(2), "0": () => this.group.showAll(this),
      Escape: () => this.canvas.blur(),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  // Moves the cursor by so many points, the view with it where it would leave it.
  step(points) {
    const u = this.plot, {min, max} = u.scales.x;
    if (this.data.scatter) {
      this.byKeyboard = true;
      return u.setCursor({left: Math.max(0, (u.cursor.left ?? 0) + 4 * points), top: u.over.clientHeight / 2});
    }
    const start = u.cursor.idx ?? u.valToIdx((min + max) / 2);
    const x = this.data.x[Math.max(0, Math.min(this.data.x.length - 1, start + points))];
    if (x < min || x > max) this.group.zoom(this, [x - (max - min) / 2, x + (max - min) / 2]);
    this.readAt(x);
  }

  // Puts the cursor at a place of x, as the arrow keys do.
  readAt(x) {
    this.byKeyboard = true;
    this.plot.setCursor({left: this.plot.valToPos(x, "x"), top: this.plot.over.clientHeight / 2});
  }
}
