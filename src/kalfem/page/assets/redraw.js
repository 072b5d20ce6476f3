// SPDX-License-Identifier: Apache-2.0
// Charts are drawn anew where their colours change, and as wide as the paper to be printed.

import {prefersDark} from "./dom.js";

export function redrawWhenNeeded(group) {
  const rebuild = () => group.views.forEach(view => view.build());
  prefersDark.addEventListener("change", rebuild);
  addEventListener("beforeprint", () => {
    document.documentElement.dataset.printing = "";
    group.views.forEach(view => view.buildForPrint());
  });
  addEventListener("afterprint", () => { delete document.documentElement.dataset.printing; rebuild(); });
}
