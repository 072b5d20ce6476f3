// SPDX-License-Identifier: Apache-2.0
// Times of a stream: seconds from its start, or since 1970, whatever its source counts.

import {withMinus} from "../numbers.js";

const since1970 = time => time > 1e8;

export const moment = time =>
    since1970(time) ? new Date(1000 * time).toISOString().replace(/\.\d+Z$/, "Z") : `${withMinus(Number(time.toFixed(2)))} s`;

// Where a chart counts from whose first value comes at `time`, in steps of `step` seconds, and what its axis says of it.
export function origin(time, step) {
  if (!since1970(time)) return {from: 0, words: ""};
  const from = step * Math.floor(time / step);
  return {from, words: ` since ${moment(from)}`};
}
