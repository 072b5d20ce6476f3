// SPDX-License-Identifier: Apache-2.0
// Charts over the same abscissa ("time [s]") share the cursor and, unless the reader switches it off, the zoom.

import {isPrinting} from "./dom.js";

const near = "25% 0px";  // charts as close as this to the screen are kept up to date

export class ChartGroup {
  constructor() {
    this.views = [];
    this.together = true;
    this.sight = new IntersectionObserver(entries => {
      for (const {target, isIntersecting} of entries) this.viewOf(target).comeIntoSight(isIntersecting);
    }, {rootMargin: near});
    this.room = new ResizeObserver(entries => {
      if (!isPrinting()) entries.forEach(({target}) => this.viewOf(target).fit());
    });
  }

  // A chart that is drawn later, because it was folded away, joins the zoom of the others.
  add(view) {
    const zoomed = this.together && this.alike(view).find(other => other.view.zoomed);
    this.views.push(view);
    this.sight.observe(view.canvas);
    this.room.observe(view.canvas);
    if (zoomed) this.zoomAll([view], zoomed.view.x);
  }

  // A chart that leaves the page.
  remove(view) {
    this.views.splice(this.views.indexOf(view), 1);
    this.sight.unobserve(view.canvas);
    this.room.unobserve(view.canvas);
    view.plot.destroy();
  }

  viewOf(canvas) { return this.views.find(view => view.canvas === canvas); }

  // The charts over the same abscissa, itself included.
  alike(view) {
    return view.data.scatter ? [view]
                             : this.views.filter(other => !other.data.scatter && other.data.x_label === view.data.x_label);
  }

  linked(view) { return this.together ? this.alike(view) : [view]; }

  // Charts without data there keep their view.
  zoom(view, x, y) { this.zoomAll(this.linked(view), x, y); }

  zoomAll(views, x, y) {
    for (const each of views) {
      const [first, last] = each.everything("x");
      if (x[0] < last && first < x[1]) each.setView(each.closerView(x, y));
    }
  }

  showAll(view) { this.linked(view).forEach(each => each.setView(each.fullView())); }
  showFirst(view) { this.linked(view).forEach(each => each.setView(each.firstView())); }

  // Shows a moment in all charts over the same abscissa, within twice the width of a zoomed view.
  showMoment(view, moment) {
    const alike = this.alike(view);
    view.comeIntoSight(true);
    const [first, last] = view.everything("x");
    const window = [view, ...alike].map(each => each.data.x_window).find(Boolean);
    const width = window ? window[1] - window[0] : (last - first) / 20;
    this.zoomAll(alike, [moment - width, moment + width]);
    view.readAt(moment);
  }

  // uPlot's options for a cursor that the charts on the screen share, but for one that is read by keyboard.
  cursorOf(view) {
    const moves = type => type === "mousemove" || type === "mouseleave";
    return {key: view.data.x_label, setSeries: false, scales: ["x", null],
            filters: {pub: moves, sub: type => moves(type) && view.onScreen && !view.byKeyboard}};
  }
}
