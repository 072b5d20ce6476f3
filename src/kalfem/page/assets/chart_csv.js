// SPDX-License-Identifier: Apache-2.0
// The points of a chart that are in view, as comma-separated values with the digits that the page has.

import {inLegendOrder} from "./curves.js";

export function chartCsv(view) {
  const {data} = view;
  const shown = inLegendOrder(view.curves, data.series).filter(curve => curve.show);
  const columns = data.scatter ? pathColumns(view, shown) : seriesColumns(view, shown);
  const rows = Math.max(0, ...columns.map(column => column.values.length));
  const lines = [columns.map(column => quoted(column.name))];
  for (let k = 0; k < rows; ++k) lines.push(columns.map(column => column.values[k] ?? ""));
  return lines.map(line => line.join(",") + "\r\n").join("");
}

function seriesColumns({data, plot}, curves) {
  const {min, max} = plot.scales.x;
  const inView = values => values.filter((value, k) => data.x[k] >= min && data.x[k] <= max);
  const unit = unitOf(data.y_label);
  const columns = [{name: data.x_label, values: inView(data.x)}];
  for (const curve of curves) {
    columns.push({name: `${curve.label} ${unit}`, values: inView(curve.y)});
    if (!curve.lower) continue;
    columns.push({name: `${curve.label}, lower limit ${unit}`, values: inView(curve.lower)},
                 {name: `${curve.label}, upper limit ${unit}`, values: inView(curve.upper)});
  }
  return columns;
}

function pathColumns({data, plot}, curves) {
  const within = (value, {min, max}) => value >= min && value <= max;
  return curves.flatMap(curve => {
    const inView = curve.x.map((x, k) => within(x, plot.scales.x) && within(curve.y[k], plot.scales.y));
    return [{name: `${curve.label}: ${data.x_label}`, values: curve.x.filter((x, k) => inView[k])},
            {name: `${curve.label}: ${data.y_label}`, values: curve.y.filter((y, k) => inView[k])}];
  });
}

// "[N]" of "force [N]"; a label without a unit as a whole.
const unitOf = label => label.match(/\[[^\]]*\]\s*$/)?.[0] ?? `[${label}]`;

const quoted = text => /[",\r\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text.trim();
