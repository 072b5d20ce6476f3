// SPDX-License-Identifier: Apache-2.0
// One case as it is now: condition, reasons, unknowns, alarms, trend, motion and events.

import {ChartGroup} from "../chart_group.js";
import {ChartView, zoomHint} from "../chart_view.js";
import {make} from "../dom.js";
import {formatted, typeset, withBand} from "../numbers.js";
import {redrawWhenNeeded} from "../redraw.js";
import {badge} from "./badge.js";
import {moment} from "./moment.js";

const deviations = 1.96;  // half a band of 95 %
const group = new ChartGroup();
redrawWhenNeeded(group);

export class CaseView {
  constructor(watched) {
    this.watched = watched;
    this.charts = new Map();  // of the courses, by their keys
    this.subtitle = make("p", {class: "subtitle"});
    this.verdict = make("div", {class: "verdict", role: "status"});
    this.unknowns = section("Unknowns");
    this.health = section("Health");
    this.alarms = section("Alarms");
    this.trend = section("Trend by day");
    this.outputs = section("Motion and inputs");
    this.events = section("Events");
    this.node = make("div", {}, make("header", {}, make("h1", {}, watched.name), this.subtitle, this.verdict),
                     make("main", {id: "main"}, this.unknowns.node, this.alarms.node, this.trend.node, this.outputs.node,
                          this.health.node, this.events.node));
    this.unknowns.node.querySelector(".items").before(make("div", {class: "tools"}, make("p", {}, zoomHint)));
  }

  renew() {
    const {latest} = this.watched;
    if (latest) this.renewHead(latest);
    if (latest) this.renewUnknowns(latest);
    if (latest) this.renewHealth(latest);
    this.renewAlarms(latest);
    this.renewCharts();
    const rows = this.watched.events.map(event => [moment(event.t), event.channel, event.kind, event.text]);
    this.events.table(["time", "channel", "event", "what was done"], rows);
    this.events.node.hidden = !rows.length;
  }

  leave() { this.charts.forEach(view => group.remove(view)); }

  renewHead({t, samples, late, bad_lines, condition, reasons, failure}) {
    const odd = [late && `${late} values came too late or twice`, bad_lines && `${bad_lines} lines could not be used`];
    this.subtitle.textContent = [`the stream stands at ${moment(t)}`, `${samples} samples`, ...odd.filter(Boolean)].join(", ");
    const said = [...reasons.map(({subject, text}) => subject && !text.includes(subject) ? `${subject}: ${text}` : text),
                  ...(failure ? [`the filter has stopped: ${failure}`] : [])];
    this.verdict.replaceChildren(badge(condition), ...said.map(text => make("p", {}, typeset(text))));
  }

  renewUnknowns({parameters, changes = []}) {
    const changeOf = name => changes.find(({parameter}) => parameter === name);
    const rows = Object.entries(parameters).map(([name, {estimate, std, unit}]) => {
      const change = changeOf(name);
      return [name, withBand(estimate, deviations * std), unit,
              change ? `${percent(change.change)} since ${moment(change.since)}` : "\u2013"];
    });
    this.unknowns.table(["", "estimate, 95 % band", "unit", "change that stands"], rows);
    this.unknowns.node.hidden = !rows.length;
  }

  renewHealth({health}) {
    const shares = all => Object.entries(all).sort((a, b) => b[1] - a[1]).map(([what, share]) => `${what} ${partOf(share)}`);
    const rows = Object.entries(health).map(([span, {shares: told, nis, expected_nis, reasons}]) => [
      `last ${span}`, shares(told).join(", ") || "\u2013", nis == null ? "\u2013" : `${formatted(nis)} of ${formatted(expected_nis)}`,
      reasons.slice(0, 3).map(({code, subject, share}) => `${code.replace(/_/g, " ")}${subject && ` of ${subject}`} ${partOf(share)}`).join(", ") || "\u2013",
    ]);
    this.health.table(["", "condition", "mean NIS, of what is expected", "reasons"], rows);
    this.health.node.hidden = !rows.length;
  }

  // Without alarms in the case there is nothing to say of them.
  renewAlarms(latest) {
    const {alarms} = this.watched;
    this.alarms.node.hidden = !alarms.length && !latest?.reference;
    if (this.alarms.node.hidden) return;
    this.alarms.table(["number", "given at", "kind", "what has changed"],
                      alarms.map(({number, t, kind, text}) => [number, moment(t), kind, text]));
    const {windows, of} = latest?.reference ?? {windows: 0, of: 0};
    this.alarms.say(alarms.length ? "" : windows < of ? `None yet: ${windows} of ${of} windows of the reference are there.` : "None.");
  }

  renewCharts() {
    const places = {unknown: this.unknowns, trend: this.trend, output: this.outputs};
    for (const [key, course] of this.watched.courses) {
      if (this.charts.has(key)) this.charts.get(key).renew();
      else this.charts.set(key, this.draw(places[course.kind], course));
    }
    const has = kind => [...this.watched.courses.values()].some(course => course.kind === kind);
    this.trend.node.hidden = !has("trend");
    this.outputs.node.hidden = !has("output");
    document.body.dataset.points = Math.max(0, ...group.views.map(view => view.data.x.length));
  }

  draw({charts}, {kind, name, data}) {
    const figure = make("figure", {class: "chart half", id: `chart-${kind}-${name.replace(/\s+/g, "_")}`},
                        make("h3", {}, name), make("div", {class: "plot"}));
    charts.append(figure);
    return new ChartView(figure, data, group);
  }
}

// A section with a table, a sentence and charts.
function section(heading) {
  const table = make("div", {class: "table", tabindex: "0", role: "group", "aria-label": heading, hidden: ""});
  const words = make("p", {hidden: ""}), charts = make("div", {class: "items live"});
  const node = make("section", {hidden: ""}, make("h2", {}, heading), words, table, charts);
  return {
    node, charts,
    say(text) { words.textContent = text; words.hidden = !text; },
    table(columns, rows) {
      table.hidden = !rows.length;
      table.replaceChildren(make("table", {}, make("thead", {}, rowOf(columns, "th")),
                                 make("tbody", {}, ...rows.map(row => rowOf(row, "td")))));
    },
  };
}

const longestPlainCell = 48;  // characters; longer ones fill several lines

function rowOf(cells, tag) {
  return make("tr", {}, ...cells.map((cell, k) => {
    const text = typeset(String(cell));
    return make(tag === "td" && k === 0 ? "th" : tag, text.length > longestPlainCell ? {class: "prose"} : {}, text);
  }));
}

const partOf = share => `${formatted(Number((100 * share).toPrecision(3)))} %`;
const percent = value => `${value > 0 ? "+" : ""}${formatted(100 * value)} %`;
