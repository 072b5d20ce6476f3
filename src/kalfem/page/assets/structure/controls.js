// SPDX-License-Identifier: Apache-2.0
// The line of controls above a structure.

import {button, make} from "../dom.js";

export const speeds = {"real time": 1, "1/4 speed": 1 / 4, "1/20 speed": 1 / 20};
export const amplitudes = {min: 0, max: 0.3, step: 0.005, value: 0.08};  // largest displacement / size of the structure

export class Controls {
  constructor(fields, showsEdges, on) {
    this.shape = select(["undeformed", ...fields.map(field => field.name)], index => on.shape(index - 1));
    this.play = button("Play", on.play, {"aria-pressed": "false", class: "play"});
    this.time = make("input", {type: "range", min: 0, max: 1, step: "any", "aria-label": "Time"});
    this.clock = make("output", {});
    this.speed = select(Object.keys(speeds), (index, name) => on.speed(speeds[name]), {"aria-label": "Speed"});
    this.speed.value = "1/4 speed";
    this.amplitude = make("input", {type: "range", ...amplitudes});
    this.time.addEventListener("input", () => on.time(Number(this.time.value)));
    this.amplitude.addEventListener("input", () => on.amplitude(Number(this.amplitude.value)));
    this.ofField = make("span", {class: "group"}, this.play, labelled("Amplitude", this.amplitude));
    this.ofMotion = make("span", {class: "group"}, this.time, this.clock, this.speed);
    this.node = make("div", {class: "controls"});
    if (fields.length) this.node.append(labelled("Shape", this.shape), this.ofField, this.ofMotion);
    this.node.append(switched("Edges", showsEdges, on.edges), switched("Names", true, on.names), button("Fit", on.fit));
    this.showFor(null);
  }

  // Offers what a field needs; null: the undeformed structure.
  showFor(field) {
    this.ofField.hidden = !field;
    this.ofMotion.hidden = !field || field.isMode;
    if (!field) return;
    this.time.min = field.begin;
    this.time.max = field.end;
  }

  showTime(time) {
    this.time.value = time;
    this.clock.textContent = `${time.toFixed(2)} s`;
  }

  showPlaying(playing) {
    this.play.textContent = playing ? "Pause" : "Play";
    this.play.setAttribute("aria-pressed", playing);
  }
}

function select(names, action, attributes = {}) {
  const node = make("select", attributes, ...names.map(name => make("option", {value: name}, name)));
  node.addEventListener("change", () => action(node.selectedIndex, node.value));
  return node;
}

const labelled = (text, node) => make("label", {}, text, node);

function switched(text, on, action) {
  const box = make("input", {type: "checkbox", ...(on ? {checked: ""} : {})});
  box.addEventListener("change", () => action(box.checked));
  return make("label", {}, box, text);
}
