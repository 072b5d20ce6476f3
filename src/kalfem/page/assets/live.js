// SPDX-License-Identifier: Apache-2.0
// The page of `kalfem watch`: follows the messages of all cases, and shows one of them.

import {button, make} from "./dom.js";
import {badge} from "./live/badge.js";
import {CaseView} from "./live/case_view.js";
import {WatchedCase} from "./live/watched_case.js";
import {startTally} from "./tally.js";

const drawingInterval = 250;  // [ms] between two drawings

startTally();
const cases = new Map();
const place = document.getElementById("live");
const connection = make("p", {class: "connection", role: "status"}, "Connecting \u2026");
const choice = make("nav", {class: "cases", "aria-label": "Cases", hidden: ""});
const body = make("div");
place.append(choice, body, connection);
let shown = null, waits = false;
follow();

// The server sends all that it has kept whenever it is asked anew: what was known is dropped before.
function follow() {
  const events = new EventSource("events");
  events.onopen = () => { cases.clear(); say("Connected: this page follows what comes."); };
  events.onerror = () => {
    say("Not connected: kalfem watch has ended, or cannot be reached. This page goes on trying.", "lost");
    if (events.readyState === EventSource.CLOSED) setTimeout(follow, 2000);
  };
  events.onmessage = ({data}) => {
    const message = JSON.parse(data);
    if (!cases.has(message.case)) cases.set(message.case, new WatchedCase(message.case));
    cases.get(message.case).take(message.kind, message.line);
    drawSoon();
  };
}

function say(text, kind = "") {
  connection.textContent = text;
  document.body.dataset.connection = kind || "there";
}

function drawSoon() {
  if (waits) return;
  waits = true;
  setTimeout(() => { waits = false; draw(); }, drawingInterval);
}

function draw() {
  const wanted = decodeURIComponent(location.hash.slice(1));
  const chosen = cases.get(wanted) ?? cases.values().next().value;
  if (!chosen) return;
  if (shown?.watched !== chosen) show(chosen);
  shown.renew();
  drawChoice(chosen);
}

function show(chosen) {
  shown?.leave();
  shown = new CaseView(chosen);
  body.replaceChildren(shown.node);
  document.title = `${chosen.name}: kalfem watch`;
}

function drawChoice(chosen) {
  choice.hidden = cases.size < 2;
  if (choice.hidden) return;
  const focused = choice.contains(document.activeElement) && document.activeElement.dataset.case;
  choice.replaceChildren(...[...cases.values()].map(each => {
    const key = button(each.name, () => { location.hash = encodeURIComponent(each.name); draw(); },
                       {"data-case": each.name, "aria-pressed": each === chosen});
    key.append(badge(each.condition));
    return key;
  }));
  if (focused) choice.querySelector(`[data-case="${CSS.escape(focused)}"]`)?.focus();
}
