// SPDX-License-Identifier: Apache-2.0
// Charts that stand folded away are drawn when they are opened or printed: a page may hold hundreds.

export function whenUnfolded(figure, draw) {
  const fold = figure.closest("details:not([open])");
  if (!fold) return draw();
  let waits = true;
  const drawOnce = () => {
    if (waits) draw();
    waits = false;
  };
  fold.addEventListener("toggle", drawOnce);
  addEventListener("beforeprint", () => {
    fold.open = true;
    drawOnce();
  });
}

// Opens what a figure is folded away in; its charts are drawn when this returns.
export function unfold(figure) {
  const fold = figure?.closest("details:not([open])");
  if (!fold) return;
  fold.open = true;
  fold.dispatchEvent(new Event("toggle"));
}
