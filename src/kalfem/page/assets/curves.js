// SPDX-License-Identifier: Apache-2.0
// How curves look: colour and stroke by what they stand for, the same on every chart of the page.

const styles = {
  measured:  {color: "--measured",  width: 1},
  estimate:  {color: "--estimate",  width: 1.75},
  predicted: {color: "--predicted", width: 1.75},
  initial:   {color: "--initial",   width: 1.5, dash: [2, 3]},
  limit:     {color: "--limit",     width: 1.25, dash: [7, 3, 2, 3]},
  truth:     {color: "--truth",     width: 1.1, dash: [5, 4]},
};
const extraColors = ["--other-1", "--other-2", "--other-3", "--other-4"];
const drawingOrder = ["measured", "other", "predicted", "estimate", "initial", "limit", "truth"];

export const bandOpacity = 0.22;

// The series in drawing order, dashed ones on top. The first of a role has its colour, the others take a free one.
export function styledCurves(series) {
  const taken = new Set();
  let extra = 0;
  const curves = series.map(source => {
    const style = styles[source.role] || {width: 1.5};
    const color = style.color && !taken.has(source.role) ? style.color : extraColors[extra++ % extraColors.length];
    taken.add(source.role);
    return {...source, ...style, color, source, show: true};
  });
  return curves.sort((a, b) => drawingOrder.indexOf(a.role) - drawingOrder.indexOf(b.role));
}

// The curves in the order in which the page names them.
export const inLegendOrder = (curves, series) => series.map(source => curves.find(curve => curve.source === source));

export function swatch(curve) {
  const band = curve.lower
      ? `<rect width="26" height="12" rx="2" fill="var(${curve.color})" opacity="${bandOpacity}"/>` : "";
  if (curve.points)
    return `<svg viewBox="0 0 26 12" aria-hidden="true" fill="var(${curve.color})">` +
           [5, 13, 21].map((x, i) => `<circle cx="${x}" cy="${i % 2 ? 4 : 8}" r="2"/>`).join("") + "</svg>";
  return `<svg viewBox="0 0 26 12" aria-hidden="true">${band}<line x1="0" x2="26" y1="6" y2="6" ` +
         `stroke="var(${curve.color})" stroke-width="${curve.width + 0.5}" ` +
         `stroke-dasharray="${(curve.dash || []).join(" ")}"/></svg>`;
}
