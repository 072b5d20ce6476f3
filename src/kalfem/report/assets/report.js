// Draws the charts of the page from the JSON in #chart-data. The <body> tells what came of it, for tests:
// data-charts and data-curves drawn, data-errors met, data-resources taken from outside (always 0).
(() => {
"use strict";

const styles = {
  measured:  {color: "--measured",  width: 1},
  estimate:  {color: "--estimate",  width: 1.75},
  predicted: {color: "--predicted", width: 1.75},
  initial:   {color: "--initial",   width: 1.5, dash: [2, 3]},
  limit:     {color: "--limit",     width: 1.25, dash: [7, 3, 2, 3]},
  truth:     {color: "--truth",     width: 1.1, dash: [5, 4]},
};
const extraColors = ["--other-1", "--other-2", "--other-3", "--other-4"];
const drawingOrder = ["measured", "other", "predicted", "estimate", "initial", "limit", "truth"];
const heights = {full: 270, half: 290, scatter: 290};
const font = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";
const printedWidth = {full: 650, half: 300};  // CSS pixels that fit on A4

const tally = {charts: 0, curves: 0, errors: 0, resources: 0};
const publish = () => Object.assign(document.body.dataset, tally);
window.addEventListener("error", () => { ++tally.errors; publish(); });

const cssColor = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

// ---- numbers ------------------------------------------------------------------------------------------------------

const withMinus = text => String(text).replace(/-/g, "\u2212");

function formatted(value) {
  if (value == null) return "\u2013";
  const size = Math.abs(value);
  return withMinus(size === 0 || (size >= 1e-3 && size < 1e6) ? Number(value.toPrecision(5)) : value.toExponential(3));
}

// Values as an axis shows them, divided by its power of ten; `join` puts them into words.
function inUnitsOf(scale, values, join) {
  const exponent = axisExponent(scale);
  const text = join(...values.map(value => formatted(value == null ? null : value / 10 ** exponent)));
  return exponent ? `${text} ${powerOfTen(exponent)}` : text;
}

// Exponent of the power of thousand that an axis is divided by, so that its labels stay short.
function axisExponent(scale) {
  const size = Math.max(Math.abs(scale.min), Math.abs(scale.max));
  if (!(size > 0) || (size >= 1e-2 && size < 1e5)) return 0;
  return 3 * Math.floor(Math.log10(size) / 3);
}

function powerOfTen(exponent) {
  const raised = {"-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3"};
  const digit = c => raised[c] || String.fromCharCode(0x2070 + Number(c));
  return "\u00d710" + [...String(exponent)].map(digit).join("");
}

function extent(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) for (const value of list) {
    if (value == null) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 1];
}

const padded = ([low, high]) => uPlot.rangeNum(low, high, 0.06, true);

// ---- one chart ----------------------------------------------------------------------------------------------------

class ChartView {
  constructor(figure, data) {
    this.figure = figure;
    this.data = data;
    this.size = ["scatter", "half", "full"].find(name => figure.classList.contains(name));
    this.curves = styledCurves(data.series);
    this.xExtent = extent(data.scatter ? data.series.map(s => s.x) : [data.x]);
    this.xWindow = data.x_window || null;
    this.yWindow = data.y_window || null;
    this.legend = make("div", {class: "legend", role: "group", "aria-label": "Curves"});
    this.canvas = make("div", {class: "canvas", tabindex: "0", role: "application", "aria-roledescription": "chart",
                               "aria-label": this.description()});
    this.tip = make("div", {class: "tip", role: "status"});
    figure.querySelector(".plot").append(this.legend, this.canvas);
    this.canvas.addEventListener("keydown", event => this.onKey(event));
    this.canvas.addEventListener("blur", () => { this.byKeyboard = false; this.showTip(); });
    this.fillLegend();
    this.build();
  }

  description() {
    const title = this.figure.querySelector("h3")?.textContent || "Chart";
    return `${title}: ${this.data.y_label} over ${this.data.x_label}. Curves: ${this.data.series.map(s => s.label).join(", ")}. ` +
           "Arrow keys read values, plus and minus zoom, zero shows everything.";
  }

  // Draws anew, with the colours and the width of the moment.
  build(width = this.canvas.clientWidth) {
    this.plot?.destroy();
    this.plot = new uPlot(this.options(Math.max(width, 160)), this.table(), this.canvas);
    this.plot.over.append(this.tip);
    this.showFirst();
  }

  // uPlot's rows: x, then y of each curve and the edges of its band; on a scatter chart a pair of lists for each curve.
  table() {
    if (this.data.scatter) return [null, ...this.curves.map(c => [c.x, c.y])];
    return [this.data.x, ...this.curves.flatMap(c => c.lower ? [c.y, c.lower, c.upper] : [c.y])];
  }

  options(width) {
    const {scatter} = this.data;
    const series = [{}], bands = [];
    for (const curve of this.curves) {
      curve.index = series.length;
      series.push(this.seriesOptions(curve));
      if (!curve.lower) continue;
      const edge = {show: curve.show, width: 0, stroke: "transparent", pxAlign: 0, points: {show: false}};
      series.push(edge, {...edge});
      bands.push({series: [curve.index + 2, curve.index + 1], fill: cssColor(curve.color) + "38"});
    }
    const edges = new Set(bands.flatMap(band => band.series));
    return {
      mode: scatter ? 2 : 1, width, height: heights[this.size], series, bands, legend: {show: false},
      padding: [10, 14, 0, 0],
      scales: {x: {time: false, range: (u, low, high) => this.xRange(low, high)},
               y: {range: (u, low, high) => this.yRange(low, high)}},
      axes: [this.axis("x"), this.axis("y")],
      cursor: {
        y: scatter, drag: {x: true, y: scatter, uni: 20},
        points: {show: (u, i) => edges.has(i) ? false : undefined, size: 7},
        bind: {dblclick: () => () => { this.showAll(); return null; }},
        ...(scatter ? {dataIdx: (u, i) => this.nearest(u, i)} : {sync: syncedCursor(this.data.x_label)}),
      },
      hooks: {draw: [u => this.countOnce(u)], setCursor: [() => this.showTip()], setScale: [() => this.shown && this.offerViews()]},
    };
  }

  seriesOptions(curve) {
    const color = cssColor(curve.color);
    const common = {label: curve.label, show: curve.show, stroke: color, width: curve.width, dash: curve.dash,
                    pxAlign: 0, points: {show: false}};
    if (!this.data.scatter) return {...common, points: {size: 4, fill: color}, paths: curveWithBand};
    return {...common, facets: [{scale: "x", auto: true}, {scale: "y", auto: true}], paths: path};
  }

  axis(scale) {
    const label = this.data[scale + "_label"];
    const exponent = u => axisExponent(u.scales[scale]);
    return {
      scale, font, labelFont: font, labelGap: 2, labelSize: 20, gap: 6, stroke: cssColor("--muted"),
      grid: {stroke: cssColor("--grid"), width: 1}, ticks: {stroke: cssColor("--grid"), width: 1, size: 5},
      label: u => exponent(u) ? `${label}  ${powerOfTen(exponent(u))}` : label,
      values: (u, splits) => splits.map(v => v == null ? "" : withMinus(Number((v / 10 ** exponent(u)).toPrecision(6)))),
      ...(scale === "x" ? {size: 34} : {size: fittedSize}),
    };
  }

  xRange(low, high) {
    if (low == null) return this.xExtent;
    return low < high ? [low, high] : padded([low, high]);
  }

  // A given window holds, also while zooming along x, until everything is asked for.
  yRange(low, high) {
    if (this.data.scatter) return low == null ? [0, 1] : this.xRange(low, high);
    if (this.first && this.yWindow) return this.yWindow;
    return low == null ? [0, 1] : padded([low, high]);
  }

  // ---- views

  showFirst() {
    this.first = true;
    this.show(this.xWindow || this.everything("x"), this.yWindow || this.everything("y"));
  }

  showAll() {
    this.first = false;
    this.show(this.everything("x"), this.everything("y"));
  }

  everything(scale) {
    if (scale === "x" && !this.data.scatter) return this.xExtent;
    return padded(extent(this.curves.map(curve => curve[scale])));
  }

  show(x, y) {
    this.plot.batch(() => {
      this.plot.setScale("x", {min: x[0], max: x[1]});
      if (this.data.scatter) this.plot.setScale("y", {min: y[0], max: y[1]});
    });
    this.shown = this.ranges();
    this.offerViews();
  }

  ranges() {
    const {x, y} = this.plot.scales;
    return String(this.data.scatter ? [x.min, x.max, y.min, y.max] : [x.min, x.max]);
  }

  // Offers the views that are not on show: the first one, everything, or both after a zoom.
  offerViews() {
    const zoomed = this.ranges() !== this.shown;
    const same = !this.xWindow && !this.yWindow;
    this.toFirst.hidden = same || (this.first && !zoomed);
    this.toAll.hidden = !zoomed && (same || !this.first);
  }

  zoom(factor) {
    const {min, max} = this.plot.scales.x;
    const {left} = this.plot.cursor;
    const middle = left >= 0 ? this.plot.posToVal(left, "x") : (min + max) / 2;
    const half = factor * (max - min) / 2;
    const [first, last] = this.everything("x");
    const low = Math.max(first, middle - half), high = Math.min(last, middle + half);
    if (low < high) this.plot.setScale("x", {min: low, max: high});
  }

  // ---- legend and readout

  fillLegend() {
    for (const curve of this.data.series.map(s => this.curves.find(c => c.source === s))) {
      const button = make("button", {type: "button", "aria-pressed": "true", title: "Show or hide"});
      button.innerHTML = swatch(curve);
      button.append(curve.label);
      button.addEventListener("click", () => this.toggle(curve, button));
      this.legend.append(button);
    }
    const choice = (text, action) => {
      const button = make("button", {type: "button"}, text);
      button.addEventListener("click", action);
      return button;
    };
    this.toFirst = choice("First view", () => this.showFirst());
    this.toAll = choice("Show all", () => this.showAll());
    this.legend.append(make("span", {class: "view"}, this.toFirst, this.toAll));
  }

  toggle(curve, button) {
    curve.show = !curve.show;
    button.setAttribute("aria-pressed", curve.show);
    for (let i = 0; i < (curve.lower ? 3 : 1); ++i) this.plot.setSeries(curve.index + i, {show: curve.show});
  }

  // The point of a path that is nearest to the cursor, within reach of the eye.
  nearest(u, i) {
    const curve = this.curves[i - 1];
    const reach = 40;
    let best = null, distance = reach * reach;
    for (let k = 0; k < curve.x.length; ++k) {
      if (curve.x[k] == null || curve.y[k] == null) continue;
      const d = (u.valToPos(curve.x[k], "x") - u.cursor.left) ** 2 + (u.valToPos(curve.y[k], "y") - u.cursor.top) ** 2;
      if (d < distance) { distance = d; best = k; }
    }
    return best;
  }

  showTip() {
    const {cursor} = this.plot;
    const lines = this.figure.matches(":hover") || this.byKeyboard ? this.readings() : [];
    this.tip.replaceChildren(...lines);
    if (!lines.length) return;
    const {clientWidth: width, clientHeight: height} = this.plot.over;
    const right = cursor.left < width / 2;
    this.tip.style.left = right ? `${cursor.left + 14}px` : "auto";
    this.tip.style.right = right ? "auto" : `${width - cursor.left + 14}px`;
    this.tip.style.top = `${Math.max(0, Math.min(cursor.top, height - this.tip.offsetHeight))}px`;
  }

  readings() {
    const {left, idx, idxs} = this.plot.cursor;
    if (!(left >= 0)) return [];
    const lines = this.curves.filter(curve => curve.show && idxs[curve.index] != null)
                      .map(curve => this.reading(curve, idxs[curve.index]));
    if (this.data.scatter || idx == null) return lines;
    return [make("span", {}, `${this.data.x_label}  `, make("b", {}, formatted(this.data.x[idx]))), ...lines];
  }

  reading(curve, k) {
    const {x, y} = this.plot.scales;
    const mark = make("i", {style: `background:${cssColor(curve.color)}`});
    const at = this.data.scatter ? inUnitsOf(x, [curve.x[k]], a => a) + ", " : "";
    const value = at + inUnitsOf(y, [curve.y[k]], v => v);
    const band = curve.lower ? inUnitsOf(y, [curve.lower[k], curve.upper[k]], (a, b) => `  ${a} \u2026 ${b}`) : "";
    return make("span", {}, mark, `${curve.label}  `, make("b", {}, value), band);
  }

  onKey(event) {
    const actions = {
      ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1), PageUp: () => this.step(-50), PageDown: () => this.step(50),
      "+": () => this.zoom(0.5), "-": () => this.zoom(2), "0": () => this.showAll(), Escape: () => this.canvas.blur(),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  step(count) {
    this.byKeyboard = true;
    const u = this.plot;
    if (this.data.scatter) return u.setCursor({left: Math.max(0, (u.cursor.left ?? 0) + 4 * count), top: u.over.clientHeight / 2});
    const start = u.cursor.idx ?? u.valToIdx((u.scales.x.min + u.scales.x.max) / 2);
    const k = Math.max(0, Math.min(this.data.x.length - 1, start + count));
    u.setCursor({left: u.valToPos(this.data.x[k], "x"), top: u.over.clientHeight / 2});
  }

  countOnce(u) {
    if (this.counted) return;
    this.counted = true;
    ++tally.charts;
    tally.curves += this.curves.filter(curve => u.series[curve.index]._paths).length;
    publish();
  }
}

// The series in drawing order, dashed ones on top. The first of a role has its colour, the others take a free one.
function styledCurves(series) {
  const taken = new Set();
  let extra = 0;
  const curves = series.map(source => {
    const style = styles[source.role] || {width: 1.5};
    const color = style.color && !taken.has(source.role) ? style.color : extraColors[extra++ % extraColors.length];
    taken.add(source.role);
    return {...source, ...style, color, source, show: true};
  });
  return curves.sort((a, b) => drawingOrder.indexOf(a.role) - drawingOrder.indexOf(b.role));
}

function swatch(curve) {
  const band = curve.lower ? `<rect width="26" height="12" rx="2" fill="var(${curve.color})" opacity="0.22"/>` : "";
  return `<svg viewBox="0 0 26 12" aria-hidden="true">${band}<line x1="0" x2="26" y1="6" y2="6" stroke="var(${curve.color})" ` +
         `stroke-width="${curve.width + 0.5}" stroke-dasharray="${(curve.dash || []).join(" ")}"/></svg>`;
}

// Charts over the same abscissa share the cursor, not the zoom.
function syncedCursor(key) {
  const passes = type => type === "mousemove" || type === "mouseleave";
  return {key, setSeries: false, scales: ["x", null], filters: {pub: passes, sub: passes}};
}

// A line through the points in their order, broken at gaps.
function path(u, i) {
  const stroke = new Path2D();
  uPlot.orient(u, i, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height, moveTo, lineTo) => {
    let drawing = false;
    for (let k = 0; k < xs.length; ++k) {
      const there = xs[k] != null && ys[k] != null;
      if (there) (drawing ? lineTo : moveTo)(stroke, toX(xs[k], scaleX, width, left), toY(ys[k], scaleY, height, top));
      drawing = there;
    }
  });
  return {stroke, fill: null, clip: null, band: null, gaps: null, flags: 0};
}

// uPlot's own line steps from pixel to pixel where points are dense; its areas do well.
const uplotLine = uPlot.paths.linear();
function curveWithBand(u, i, from, to) {
  return {...uplotLine(u, i, from, to), stroke: path(u, i).stroke};
}

// Room for the longest label of the vertical axis.
function fittedSize(u, values, axisIndex, cycle) {
  const axis = u.axes[axisIndex];
  if (cycle > 1) return axis._size;
  u.ctx.font = axis.font[0];
  const widths = (values || []).map(text => u.ctx.measureText(text).width / devicePixelRatio);
  return Math.ceil(Math.max(30, ...widths) + axis.ticks.size + axis.gap + 2);
}

// ---- the page -----------------------------------------------------------------------------------------------------

const data = JSON.parse(document.getElementById("chart-data").textContent);
const views = [];
for (const figure of document.querySelectorAll("[data-chart]")) {
  try {
    views.push(new ChartView(figure, data[figure.dataset.chart]));
  } catch (error) {
    ++tally.errors;
    figure.querySelector(".plot").append(make("p", {class: "note"}, `This chart could not be drawn: ${error.message}`));
  }
}

const rebuild = () => views.forEach(view => view.build());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", rebuild);
addEventListener("beforeprint", () => {
  document.documentElement.dataset.printing = "";
  views.forEach(view => view.build(printedWidth[view.size === "full" ? "full" : "half"]));
});
addEventListener("afterprint", () => { delete document.documentElement.dataset.printing; rebuild(); });

const onResize = new ResizeObserver(entries => entries.forEach(({target}) => {
  const view = views.find(v => v.canvas === target);
  const width = target.clientWidth;
  if (width > 0 && width !== view.plot.width && !("printing" in document.documentElement.dataset)) {
    view.plot.setSize({width, height: view.plot.height});
  }
}));
views.forEach(view => onResize.observe(view.canvas));

// The contents mark the section that is being read.
const links = new Map([...document.querySelectorAll("nav a")].map(link => [link.hash.slice(1), link]));
const onScroll = new IntersectionObserver(entries => {
  const seen = entries.find(entry => entry.isIntersecting);
  if (!seen) return;
  links.forEach(link => link.removeAttribute("aria-current"));
  links.get(seen.target.id)?.setAttribute("aria-current", "true");
}, {rootMargin: "0px 0px -70% 0px"});
document.querySelectorAll("main > section").forEach(section => onScroll.observe(section));

tally.resources = performance.getEntriesByType("resource").length +
                  document.querySelectorAll("[src], link[href], [href^='http'], [href^='//']").length;
publish();
})();
