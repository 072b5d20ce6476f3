// SPDX-License-Identifier: Apache-2.0
// What has been told of one case: its latest line of estimates, its alarms and events, and the course of each quantity
// as the data of a chart, whose lists grow.

import {typeset} from "../numbers.js";
import {origin} from "./moment.js";

const mostPoints = 4000;   // of a chart; then the oldest quarter goes
const mostListed = 200;    // events and alarms
const deviations = 1.96;   // half a band of 95 %
const day = 86400;         // [s]

export class WatchedCase {
  constructor(name) {
    this.name = name;
    this.latest = null;
    this.alarms = [];        // the latest first
    this.events = [];        // likewise
    this.courses = new Map();  // of each quantity {kind, name, from, data}; a chart counts its times from `from`
  }

  get condition() { return this.latest?.condition ?? "warming up"; }

  take(kind, line) {
    if (kind === "alarm") this.list(this.alarms, [line.alarm]);
    if (kind === "trend") this.takeDay(line.trend);
    if (kind === "estimates") this.takeEstimates(line);
  }

  takeEstimates(line) {
    this.latest = line;
    this.list(this.events, line.events);
    for (const [name, {estimate, std, unit}] of Object.entries(line.parameters))
      add(this.course("unknown", name, line.t, unit), line.t, estimate, std);
    for (const [name, {mean, std}] of Object.entries(line.outputs)) add(this.course("output", name, line.t), line.t, mean, std);
    for (const [name, {mean, std}] of Object.entries(line.smoothed?.outputs ?? {}))
      add(this.course("output", `${name}, smoothed`, line.t), line.smoothed.t, mean, std);
  }

  takeDay({day: start, parameters}) {
    for (const [name, {mean, lower, upper, unit, corrected}] of Object.entries(parameters)) {
      const {data, from} = this.course("trend", name, start, unit);
      const [measured, without] = data.series;
      push(data.x, (start - from) / day);
      for (const [series, told] of [[measured, {mean, lower, upper}], [without, corrected]]) {
        push(series.y, told.mean);
        push(series.lower, told.lower);
        push(series.upper, told.upper);
      }
    }
  }

  course(kind, name, time, unit = "SI") {
    const key = `${kind} ${name}`;
    if (!this.courses.has(key)) this.courses.set(key, emptyCourse(kind, name, time, unit));
    return this.courses.get(key);
  }

  list(all, fresh) {
    all.unshift(...[...fresh].reverse());
    all.length = Math.min(all.length, mostListed);
  }
}

const emptySeries = (label, role) => ({label, role, y: [], lower: [], upper: []});

function emptyCourse(kind, name, time, unit) {
  const isTrend = kind === "trend", {from, words} = origin(time, isTrend ? day : 60);
  const series = isTrend ? [emptySeries("mean of the day", "estimate"), emptySeries("without covariates", "predicted")]
                         : [emptySeries("estimate, 95 % band", "estimate")];
  return {kind, name, from,
          data: {x_label: isTrend ? `day${words}` : `time${words} [s]`, y_label: `${name} [${typeset(unit)}]`, x: [], series}};
}

// A value of a time, in the place of one of the same time; one of an earlier time is left out.
function add({data, from}, t, value, deviation) {
  const {x, series: [{y, lower, upper}]} = data, time = t - from;
  if (x.at(-1) === time) [x, y, lower, upper].forEach(list => list.pop());
  if (x.at(-1) > time) return;
  const half = deviations * deviation;
  x.push(time);
  push(y, value);
  push(lower, value == null ? null : value - half);
  push(upper, value == null ? null : value + half);
  if (x.length > mostPoints) [x, y, lower, upper].forEach(list => list.splice(0, mostPoints / 4));
}

function push(list, value) { list.push(value ?? null); }
