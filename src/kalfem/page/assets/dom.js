// SPDX-License-Identifier: Apache-2.0
// Elements of the page and the colours of its style sheet.

export function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

export function button(text, action, attributes = {}) {
  const node = make("button", {type: "button", ...attributes}, text);
  node.addEventListener("click", action);
  return node;
}

export const cssColor = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// What `read` returns while the page has its printed look: light, whatever the screen shows.
export function withPrintedColors(read) {
  const root = document.documentElement.dataset;
  const printing = "printing" in root;
  root.printing = "";
  try {
    return read();
  } finally {
    if (!printing) delete root.printing;
  }
}

export const isPrinting = () => "printing" in document.documentElement.dataset;
export const prefersDark = matchMedia("(prefers-color-scheme: dark)");
export const prefersStill = matchMedia("(prefers-reduced-motion: reduce)");
