// SPDX-License-Identifier: Apache-2.0
// Builds the views of the structures on the page from the JSON in #scene-data, each when it first comes near the screen.

import {make} from "./dom.js";
import {StructureView} from "./structure/structure_view.js";

const scenes = JSON.parse(document.getElementById("scene-data").textContent);
const waiting = new Set(document.querySelectorAll("[data-scene]"));

const sight = new IntersectionObserver(entries => {
  entries.filter(entry => entry.isIntersecting).forEach(entry => build(entry.target));
}, {rootMargin: "50% 0px"});
waiting.forEach(figure => sight.observe(figure));
addEventListener("beforeprint", () => waiting.forEach(build));

function build(figure) {
  sight.unobserve(figure);
  if (!waiting.delete(figure)) return;
  const room = figure.querySelector(".structure");
  if (hasWebGL()) {
    new StructureView(room, scenes[figure.dataset.scene], figure.querySelector("h3")?.textContent || "Structure");
  } else {
    room.replaceChildren(make("p", {class: "note"}, "The structure cannot be shown in three dimensions, because this " +
                                                    "browser offers no WebGL. The picture of its mesh needs none."));
  }
}

function hasWebGL() {
  try {
    return Boolean(make("canvas").getContext("webgl2"));
  } catch {
    return false;
  }
}
