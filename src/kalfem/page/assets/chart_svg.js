// SPDX-License-Identifier: Apache-2.0
// What a chart shows as a drawing: title, legend, axes, bands and curves as vectors, in the colours of print.

import {bandOpacity, inLegendOrder} from "./curves.js";
import {cssColor, withPrintedColors} from "./dom.js";
import {axisTitle} from "./plot_options.js";

const fontFamily = "system-ui, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";
const margin = 14, titleHeight = 24, rowHeight = 19;
const swatchWidth = 26, swatchGap = 7, entryGap = 16;

// {text, width, height}: the svg element and its size in pixels.
export const chartSvg = view => withPrintedColors(() => new ChartDrawing(view).drawn());

class ChartDrawing {
  constructor(view) {
    this.view = view;
    this.plot = view.plot;
    this.shown = view.curves.filter(curve => curve.show);
    this.measure = document.createElement("canvas").getContext("2d");
    this.measure.font = `12px ${fontFamily}`;
    const {left, top, width, height} = this.plot.bbox;  // in device pixels
    const dots = devicePixelRatio;
    this.legend = this.placedLegend();
    this.area = {left: left / dots, top: top / dots + this.legend.bottom, width: width / dots, height: height / dots};
  }

  drawn() {
    const width = this.plot.width, height = Math.ceil(this.plot.height + this.legend.bottom + 4);
    const {left, top, width: w, height: h} = this.area;
    const text =
        `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" ` +
        `font-family="${fontFamily}" font-size="12" fill="${cssColor("--text")}">\n` +
        `<title>${escaped(this.view.title)}</title>\n<rect width="100%" height="100%" fill="#ffffff"/>\n` +
        `<clipPath id="area"><rect x="${dot(left)}" y="${dot(top)}" width="${dot(w)}" height="${dot(h)}"/></clipPath>\n` +
        `<text x="${margin}" y="${titleHeight - 4}" font-size="14" font-weight="600">${escaped(this.view.title)}</text>\n` +
        this.legend.text + this.axis("x") + this.axis("y") +
        `<g clip-path="url(#area)" fill="none" stroke-linejoin="round">\n` +
        this.shown.map(curve => this.band(curve)).join("") + this.shown.map(curve => this.curve(curve)).join("") +
        "</g>\n</svg>\n";
    return {text, width, height};
  }

  // The legend's entries one after the other, in as many rows as they need.
  placedLegend() {
    let x = margin, y = titleHeight + 10, text = "";
    for (const curve of inLegendOrder(this.view.curves, this.view.data.series).filter(each => each.show)) {
      const width = swatchWidth + swatchGap + this.measure.measureText(curve.label).width;
      if (x > margin && x + width > this.plot.width - margin) { x = margin; y += rowHeight; }
      const color = cssColor(curve.color);
      if (curve.lower)
        text += `<rect x="${x}" y="${y - 6}" width="${swatchWidth}" height="12" rx="2" fill="${color}" ` +
                `fill-opacity="${bandOpacity}"/>\n`;
      text += `<path d="M${x} ${y}h${swatchWidth}" ${strokeOf(curve)}/>\n` +
              `<text x="${x + swatchWidth + swatchGap}" y="${y + 4}">${escaped(curve.label)}</text>\n`;
      x += Math.ceil(width) + entryGap;
    }
    return {text, bottom: y + rowHeight / 2};
  }

  axis(name) {
    const axis = this.plot.axes[name === "x" ? 0 : 1], scale = this.plot.scales[name];
    const {left, top, width, height} = this.area, bottom = top + height;
    const grid = cssColor("--grid"), muted = cssColor("--muted");
    const ticks = axis._splits.map((value, i) => ({value, label: axis._values[i]})).filter(tick => tick.label);
    const title = escaped(axisTitle(this.view.data[name + "_label"], scale));
    if (name === "x") {
      return `<g text-anchor="middle" fill="${muted}">\n` + ticks.map(({value, label}) =>
          `<path d="M${this.x(value)} ${dot(top)}V${dot(bottom + 5)}" stroke="${grid}"/>` +
          `<text x="${this.x(value)}" y="${dot(bottom + 18)}">${label}</text>\n`).join("") +
          `<text x="${dot(left + width / 2)}" y="${dot(bottom + 38)}">${title}</text>\n</g>\n`;
    }
    const middle = dot(top + height / 2), atTitle = dot(Math.max(12, left - axis._size - 6));
    return `<g text-anchor="end" fill="${muted}">\n` + ticks.map(({value, label}) =>
        `<path d="M${dot(left - 5)} ${this.y(value)}H${dot(left + width)}" stroke="${grid}"/>` +
        `<text x="${dot(left - 9)}" y="${this.y(value)}" dy="4">${label}</text>\n`).join("") +
        `<text x="${atTitle}" y="${middle}" text-anchor="middle" transform="rotate(-90 ${atTitle} ${middle})">` +
        `${title}</text>\n</g>\n`;
  }

  curve(curve) {
    const x = curve.x ?? this.view.data.x, {from, to} = this.rows(x);
    if (curve.points) return this.cloud(curve);
    let line = "", drawing = false;
    for (let k = from; k < to; ++k) {
      const there = x[k] != null && curve.y[k] != null;
      if (there) line += `${drawing ? "L" : "M"}${this.x(x[k])} ${this.y(curve.y[k])}`;
      drawing = there;
    }
    return line && `<path d="${line}" ${strokeOf(curve)}/>\n`;
  }

  cloud({x, y, color}) {
    const dots = x.map((value, k) => value == null || y[k] == null ? "" : `M${this.x(value)} ${this.y(y[k])}h0`).join("");
    return `<path d="${dots}" stroke="${cssColor(color)}" stroke-opacity="${bandOpacity}" stroke-width="3.2" ` +
           `stroke-linecap="round"/>\n`;
  }

  // One area for each stretch without gaps: along the upper edge and back along the lower one.
  band({lower, upper, color, x = this.view.data.x}) {
    if (!lower) return "";
    const {from, to} = this.rows(x);
    let areas = "", ahead = [], back = [];
    const close = () => {
      if (ahead.length) areas += `M${ahead.join("L")}L${back.reverse().join("L")}Z`;
      ahead = [];
      back = [];
    };
    for (let k = from; k < to; ++k) {
      if (lower[k] == null || upper[k] == null) { close(); continue; }
      ahead.push(`${this.x(x[k])} ${this.y(upper[k])}`);
      back.push(`${this.x(x[k])} ${this.y(lower[k])}`);
    }
    close();
    return areas && `<path d="${areas}" fill="${cssColor(color)}" fill-opacity="${bandOpacity}"/>\n`;
  }

  // Rows of the part in view and one on either side, so that lines run up to the edge; all of a path.
  rows(x) {
    if (this.view.data.scatter) return {from: 0, to: x.length};
    const {min, max} = this.plot.scales.x;
    const first = x.findIndex(value => value >= min), behind = x.findIndex(value => value > max);
    return {from: first < 0 ? x.length : Math.max(0, first - 1), to: behind < 0 ? x.length : behind + 1};
  }

  x(value) { return dot(this.area.left + this.plot.valToPos(value, "x")); }
  y(value) { return dot(this.area.top + this.plot.valToPos(value, "y")); }
}

const strokeOf = curve => `stroke="${cssColor(curve.color)}" stroke-width="${curve.width}"` +
                          (curve.dash ? ` stroke-dasharray="${curve.dash.join(" ")}"` : "");

const dot = value => Number(value.toFixed(2));

const escaped = text => text.replace(/[&<>"]/g, c => ({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;"})[c]);
