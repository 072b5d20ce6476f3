// SPDX-License-Identifier: Apache-2.0
// The condition of a filter, as a mark in its colour.

import {make} from "../dom.js";

const signs = {consistent: "\u2713", suspicious: "!", unusable: "\u2717"};

export const badge = condition =>
    make("span", {class: `badge ${condition in signs ? condition : "waiting"}`}, `${signs[condition] ?? "\u2026"} ${condition}`);
