// SPDX-License-Identifier: Apache-2.0
// Numbers as axes and readouts show them.

export const withMinus = text => String(text).replace(/-/g, "\u2212");

export function formatted(value) {
  if (value == null) return "\u2013";
  const size = Math.abs(value);
  const plain = size === 0 || (size >= 1e-3 && size < 1e6);
  return withMinus(plain ? Number(value.toPrecision(5)) : value.toExponential(3));
}

// Exponent of the power of thousand that an axis is divided by, so that its labels stay short.
export function axisExponent(scale) {
  const size = Math.max(Math.abs(scale.min), Math.abs(scale.max));
  if (!(size > 0) || (size >= 1e-2 && size < 1e5)) return 0;
  return 3 * Math.floor(Math.log10(size) / 3);
}

const raised = {"-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3"};
const superscript = text => [...text].map(c => raised[c] || String.fromCharCode(0x2070 + Number(c))).join("");

// Text with the signs of print: "\u22120.3 m/s\u00b2" for "-0.3 m/s^2".
export const typeset = text =>
    text.replace(/\^(-?\d+)/g, (all, power) => superscript(power)).replace(/(^|[\s(])-(?=\d)/g, "$1\u2212");

export const powerOfTen = exponent => `\u00d710${superscript(String(exponent))}`;

// Values as an axis shows them, divided by its power of ten; `join` puts them into words.
export function inUnitsOf(scale, values, join) {
  const exponent = axisExponent(scale);
  const text = join(...values.map(value => formatted(value == null ? null : value / 10 ** exponent)));
  return exponent ? `${text} ${powerOfTen(exponent)}` : text;
}

// A value with the half-width of its band, both to the second digit of the latter: "2.977 \u00b1 0.045 \u00d710\u2076".
export function withBand(value, half) {
  if (value == null || !(half > 0)) return formatted(value);
  const exponent = axisExponent({min: value, max: value}), factor = 10 ** exponent;
  const digits = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(half / factor))));
  const text = `${withMinus((value / factor).toFixed(digits))} \u00b1 ${(half / factor).toFixed(digits)}`;
  return exponent ? `(${text}) ${powerOfTen(exponent)}` : text;
}

// Lowest and highest value of some lists, whose gaps are null; null where there is none.
export function extent(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) for (const value of list) {
    if (value == null) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : null;
}

// A length in metres with the unit that reads best.
export function lengthText(metres) {
  const [unit, factor] = metres >= 1 ? ["m", 1] : metres >= 1e-3 ? ["mm", 1e3] : ["\u00b5m", 1e6];
  return `${formatted(Number((factor * metres).toPrecision(3)))} ${unit}`;
}
