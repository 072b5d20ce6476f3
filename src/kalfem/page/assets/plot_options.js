// SPDX-License-Identifier: Apache-2.0
/*! With uPlot, Copyright (c) Leon Sorokin, MIT licence. */

// A chart's data and look in the terms of uPlot.

import uPlot from "uplot";
import {bandOpacity} from "./curves.js";
import {cssColor} from "./dom.js";
import {axisExponent, powerOfTen, withMinus} from "./numbers.js";

const font = "12px system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif";

// A range with room beside its values, and of some width even for a single one.
export const padded = ([low, high]) => uPlot.rangeNum(low, high, 0.06, true);

// uPlot's rows: x, then y of each curve and the edges of its band; on a scatter chart a pair of lists for each curve.
export function plotRows(data, curves) {
  if (data.scatter) return [null, ...curves.map(curve => [curve.x, curve.y])];
  return [data.x, ...curves.flatMap(curve => curve.lower ? [curve.y, curve.lower, curve.upper] : [curve.y])];
}

// Series and bands in the order of `plotRows`; each curve learns the `index` of its own.
export function plotSeries(data, curves) {
  const series = [{}], bands = [];
  for (const curve of curves) {
    curve.index = series.length;
    series.push(seriesOptions(curve, data.scatter));
    if (!curve.lower || data.scatter) continue;
    const edge = {show: curve.show, width: 0, stroke: "transparent", pxAlign: 0, points: {show: false}, isEdge: true};
    series.push(edge, {...edge});
    bands.push({series: [curve.index + 2, curve.index + 1], fill: translucent(cssColor(curve.color))});
  }
  return {series, bands};
}

const translucent = (color, opacity = bandOpacity) => color + Math.round(255 * opacity).toString(16);

function seriesOptions(curve, scatter) {
  const color = cssColor(curve.color);
  const common = {label: curve.label, show: curve.show, stroke: color, width: curve.width, dash: curve.dash,
                  pxAlign: 0, points: {show: false}};
  if (!scatter) return {...common, points: {size: 4, fill: color}, paths: curveWithBand};
  const facets = [{scale: "x", auto: true}, {scale: "y", auto: true}];
  if (curve.points) return {...common, width: 0, fill: translucent(color, 0.5), facets, paths: cloud};
  return {...common, fill: curve.lower ? translucent(color) : undefined, facets,
          paths: (u, i) => ({...path(u, i), fill: curve.lower ? band(u, i, curve) : null})};
}

// Label of an axis with the power of ten that its numbers are divided by.
export function axisTitle(label, scale) {
  const exponent = axisExponent(scale);
  return exponent ? `${label}  ${powerOfTen(exponent)}` : label;
}

export function tickText(value, scale) {
  return value == null ? "" : withMinus(Number((value / 10 ** axisExponent(scale)).toPrecision(6)));
}

export function axisOptions(scale, label) {
  return {
    scale, font, labelFont: font, labelGap: 2, labelSize: 20, gap: 6, stroke: cssColor("--muted"),
    grid: {stroke: cssColor("--grid"), width: 1}, ticks: {stroke: cssColor("--grid"), width: 1, size: 5},
    label: u => axisTitle(label, u.scales[scale]),
    values: (u, splits) => splits.map(value => tickText(value, u.scales[scale])),
    ...(scale === "x" ? {size: 34} : {size: fittedSize}),
  };
}

// Room for the longest label of the vertical axis.
function fittedSize(u, values, axisIndex, cycle) {
  const axis = u.axes[axisIndex];
  if (cycle > 1) return axis._size;
  u.ctx.font = axis.font[0];
  const widths = (values || []).map(text => u.ctx.measureText(text).width / devicePixelRatio);
  return Math.ceil(Math.max(30, ...widths) + axis.ticks.size + axis.gap + 2);
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

// A dot at each point.
function cloud(u, i) {
  const fill = new Path2D(), radius = 2.4 * devicePixelRatio;
  uPlot.orient(u, i, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    for (let k = 0; k < xs.length; ++k) {
      if (xs[k] == null || ys[k] == null) continue;
      const x = toX(xs[k], scaleX, width, left), y = toY(ys[k], scaleY, height, top);
      fill.moveTo(x + radius, y);
      fill.arc(x, y, radius, 0, 2 * Math.PI);
    }
  });
  return {stroke: null, fill, clip: null, band: null, gaps: null, flags: 0};
}

// The area between the edges of a band over the points of a path.
function band(u, i, {lower, upper}) {
  const area = new Path2D();
  uPlot.orient(u, i, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    const there = xs.map((x, k) => k).filter(k => lower[k] != null && upper[k] != null);
    const edge = (k, values) => area.lineTo(toX(xs[k], scaleX, width, left), toY(values[k], scaleY, height, top));
    there.forEach(k => edge(k, lower));
    there.reverse().forEach(k => edge(k, upper));
  });
  area.closePath();
  return area;
}

// uPlot's own line steps from pixel to pixel where points are dense; its areas do well.
const uplotLine = uPlot.paths.linear();
function curveWithBand(u, i, from, to) {
  return {...uplotLine(u, i, from, to), stroke: path(u, i).stroke};
}
