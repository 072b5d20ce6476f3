// SPDX-License-Identifier: Apache-2.0
// Symbols and names above the canvas: sensors, forces, supports ... at their places, and the directions of the axes.

import {Vector3} from "three";
import {make} from "../dom.js";

const drawn = (shape, width) => `<g fill="none" stroke-width="${width}">${shape}</g>`;
const symbols = {
  sensor: {name: "sensor", color: "--estimate", shape: drawn('<circle cx="7" cy="7" r="4.2"/>', 2.6)},
  input: {name: "force", color: "--predicted", shape: drawn('<path d="M7 1v8M3.4 6.4L7 12l3.6-5.6"/>', 2.2)},
  boundary: {name: "boundary", color: "--limit", shape: '<rect x="2.5" y="2.5" width="9" height="9" rx="1.5"/>'},
  connector: {name: "connector", color: "--initial", shape: '<path d="M7 1l6 6-6 6-6-6z"/>'},
  spring: {name: "spring to ground", color: "--other-1", shape: drawn('<path d="M1 10l2.4-6L7 10l3.6-6L13 10"/>', 2)},
  mass: {name: "mass", color: "--truth", shape: '<circle cx="7" cy="7" r="4.8"/>'},
  measured: {name: "measured", color: "--predicted", shape: '<circle cx="7" cy="7" r="3.6"/>'},
  support: {name: "support", color: "--limit", shape: '<path d="M7 2l6 10H1z"/>'},
};

export const symbol = kind => `<svg viewBox="0 0 14 14" aria-hidden="true" style="color:var(${symbols[kind].color})" ` +
                              `fill="currentColor" stroke="currentColor">${symbols[kind].shape}</svg>`;
export const nameOf = kind => symbols[kind].name;

export class Marks {
  constructor(marks) {
    this.node = make("div", {class: "marks", "aria-hidden": "true"});
    this.measuredShown = false;
    this.spots = [...groupedByPlace(marks)].map(([place, at]) =>
        ({place, node: spot(at), isMeasured: at.every(mark => mark.kind === "measured")}));
    this.axes = make("div", {class: "axes"});
    this.axes.innerHTML = '<svg viewBox="-30 -30 60 60"></svg>';
    this.node.append(...this.spots.map(each => each.node), this.axes);
  }

  showNames(shown) { this.node.classList.toggle("nameless", !shown); }

  // Where sensors were in a measured shape, which only some fields hold.
  showMeasured(shown) { this.measuredShown = shown; }

  // In per cent of the canvas, so that they stay in place when it is printed at another size.
  update(places, camera) {
    const at = new Vector3();
    for (const {place, node, isMeasured} of this.spots) {
      at.fromArray(places, 3 * place).project(camera);
      node.style.left = `${50 + 50 * at.x}%`;
      node.style.top = `${50 - 50 * at.y}%`;
      node.hidden = Math.abs(at.x) > 1 || Math.abs(at.y) > 1 || (isMeasured && !this.measuredShown);
      node.classList.toggle("leftwards", at.x > 0.5);
    }
    this.updateAxes(camera);
  }

  updateAxes(camera) {
    const right = new Vector3(), up = new Vector3();
    camera.matrixWorld.extractBasis(right, up, new Vector3());
    const arms = ["x", "y", "z"].map(axis => {
      const x = 20 * right[axis], y = -20 * up[axis];
      return `<path d="M0 0L${x.toFixed(1)} ${y.toFixed(1)}"/>` +
             `<text x="${(1.35 * x).toFixed(1)}" y="${(1.35 * y + 3.5).toFixed(1)}">${axis}</text>`;
    });
    this.axes.firstChild.innerHTML = arms.join("");
  }
}

function groupedByPlace(marks) {
  const places = new Map();
  for (const mark of marks) places.set(mark.place, [...(places.get(mark.place) || []), mark]);
  return places;
}

// The symbols of all marks at one place, and their names once each.
function spot(marks) {
  const node = make("span", {class: "spot"});
  node.innerHTML = marks.map(mark => symbol(mark.kind)).join("");
  const names = [...new Set(marks.map(mark => mark.label).filter(Boolean))];
  node.append(make("b", {}, names.join(", ")));
  return node;
}
