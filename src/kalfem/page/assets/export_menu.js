// SPDX-License-Identifier: Apache-2.0
// The menu of a chart that saves it: as a picture, as a drawing, as numbers. All three hold what is in view.

import {chartCsv} from "./chart_csv.js";
import {chartSvg} from "./chart_svg.js";
import {button, make} from "./dom.js";

const pixelsPerPixel = 2;  // of a saved picture, so that it stays sharp in print

export function exportMenu(view) {
  const menu = make("details", {class: "export"}, make("summary", {title: "Save what this chart shows"}, "Save"));
  const save = (name, write) => button(name, async () => {
    menu.open = false;
    menu.querySelector("summary").focus();
    download(`${view.figure.id.replace(/[^\w.-]+/g, "_")}.${name.toLowerCase()}`, await write(view));
  });
  menu.append(make("div", {},
                   save("PNG", async chart => rasterised(chartSvg(chart))),
                   save("SVG", chart => new Blob([chartSvg(chart).text], {type: "image/svg+xml"})),
                   save("CSV", chart => new Blob([chartCsv(chart)], {type: "text/csv"}))));
  menu.addEventListener("focusout", event => { if (!menu.contains(event.relatedTarget)) menu.open = false; });
  menu.addEventListener("keydown", event => {
    if (event.key !== "Escape") return;
    menu.open = false;
    menu.querySelector("summary").focus();
  });
  return menu;
}

function download(name, blob) {
  const address = URL.createObjectURL(blob);
  make("a", {href: address, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

async function rasterised({text, width, height}) {
  const image = make("img", {src: "data:image/svg+xml;charset=utf-8," + encodeURIComponent(text)});
  await image.decode();
  const canvas = make("canvas", {width: pixelsPerPixel * width, height: pixelsPerPixel * height});
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise(resolve => canvas.toBlob(resolve, "image/png"));
}
