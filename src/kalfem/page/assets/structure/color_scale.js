// SPDX-License-Identifier: Apache-2.0
// Colours for displacements from none to the largest: told apart by lightness alone, too.

import {Color, SRGBColorSpace} from "three";

const stops = ["#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725"];
const steps = 256;

export const gradient = `linear-gradient(to right, ${stops.join(", ")})`;

// Red, green and blue of each step, as the renderer takes them.
const table = (() => {
  const colors = stops.map(stop => new Color().setStyle(stop, SRGBColorSpace));
  const list = new Float32Array(3 * steps);
  for (let k = 0; k < steps; ++k) {
    const place = k / (steps - 1) * (colors.length - 1), from = Math.min(Math.floor(place), colors.length - 2);
    colors[from].clone().lerp(colors[from + 1], place - from).toArray(list, 3 * k);
  }
  return list;
})();

// Writes the colours of the lengths of displacements, of which `peak` has the last colour.
export function colorByLength(displacement, peak, out) {
  for (let k = 0; k < displacement.length; k += 3) {
    const length = Math.hypot(displacement[k], displacement[k + 1], displacement[k + 2]);
    const step = 3 * Math.min(steps - 1, Math.round((steps - 1) * length / peak));
    out[k] = table[step];
    out[k + 1] = table[step + 1];
    out[k + 2] = table[step + 2];
  }
}
