// SPDX-License-Identifier: Apache-2.0
// A mode or a motion: displacements of all places, u = sum of coordinates times shapes.

import {numbers} from "./structure_data.js";

const secondsPerCycle = 1.5;  // of a mode on the screen

export class Field {
  constructor({name, peak, shapes, times, coordinates, measured}) {
    this.name = name;
    this.isMeasured = Boolean(measured);  // a measured shape stands beside that of the model
    this.peak = peak || 1;  // largest displacement of any place at any time; 0 of a field at rest
    this.shapes = shapes.map(({factor, steps}) => ({factor, steps: numbers(Int16Array, steps)}));
    this.times = times && numbers(Float32Array, times);
    this.coordinates = coordinates && numbers(Float32Array, coordinates);
  }

  get isMode() { return !this.times; }
  get begin() { return this.isMode ? 0 : this.times[0]; }
  get end() { return this.isMode ? secondsPerCycle : this.times[this.times.length - 1]; }

  // Where a still picture is taken: at the largest displacement.
  get stillAt() { return this.isMode ? secondsPerCycle / 4 : this.times[this.largestMoment()]; }

  largestMoment() {
    const weights = this.shapes.map(({factor}) => factor);
    const sizes = Array.from(this.times, (_, k) =>
        weights.reduce((sum, weight, i) => sum + (weight * this.coordinates[k * weights.length + i]) ** 2, 0));
    return sizes.indexOf(Math.max(...sizes));
  }

  // Coordinates at a time, between two given times in proportion.
  coordinatesAt(time) {
    if (this.isMode) return [Math.sin(2 * Math.PI * time / secondsPerCycle)];
    const {times, coordinates, shapes: {length: count}} = this;
    let after = times.findIndex(each => each >= time);
    if (after < 0) after = times.length - 1;
    const before = Math.max(0, after - 1);
    const share = after === before ? 0 : (time - times[before]) / (times[after] - times[before]);
    return Array.from({length: count}, (_, i) =>
        (1 - share) * coordinates[before * count + i] + share * coordinates[after * count + i]);
  }

  // Writes the displacements for given coordinates into a list of x, y, z.
  displacement(coordinates, out) {
    out.fill(0);
    this.shapes.forEach(({factor, steps}, i) => {
      const scale = coordinates[i] * factor;
      for (let k = 0; k < out.length; ++k) out[k] += scale * steps[k];
    });
  }
}
