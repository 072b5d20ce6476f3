// SPDX-License-Identifier: Apache-2.0
// What the colours and symbols of a structure mean, below it.

import {make} from "../dom.js";
import {formatted, lengthText} from "../numbers.js";
import {gradient} from "./color_scale.js";
import {nameOf, symbol} from "./marks.js";

const mostRegions = 18;

export class Key {
  constructor(regions, marks) {
    this.regions = make("span", {class: "group"}, ...regions.slice(0, mostRegions).map(regionEntry));
    if (regions.length > mostRegions) this.regions.append(`and ${regions.length - mostRegions} more`);
    this.largest = make("span", {});
    const bar = make("i", {class: "scale", style: `background:${gradient}`});
    this.scale = make("span", {}, "displacement 0", bar, this.largest);
    this.node = make("div", {class: "key"}, this.regions, this.scale,
                     ...[...new Set(marks.map(mark => mark.kind))].map(markEntry));
    this.showFor(null);
  }

  // The colours of a field, of which only motions have a size; null: those of the regions.
  showFor(field, enlarged) {
    this.regions.hidden = Boolean(field);
    this.scale.hidden = !field;
    if (!field) return;
    this.largest.textContent = field.isMode ? "largest"
        : `${lengthText(field.peak)}, drawn ${formatted(Number(enlarged.toPrecision(2)))} times as large`;
  }
}

const regionEntry = ({name, colour}) => make("span", {}, make("i", {style: `background:${colour}`}), name);

function markEntry(kind) {
  const entry = make("span", {});
  entry.innerHTML = symbol(kind);
  entry.append(nameOf(kind));
  return entry;
}
