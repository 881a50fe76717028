// The frame from above (of a platform in a plane: along that plane), where the platform is, and a click to go there.
import { at, fixed, put, t } from "./words.js";

const SVG = "http://www.w3.org/2000/svg", LINES = 10;

function drawn(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

export class Plan {
  constructor(link, jog) {
    this.jog = jog;
    at("plan").addEventListener("click", (event) => this.click(event));
    at("plan").addEventListener("pointermove", (event) => { const place = this.place(event); put(at("plan-told"), place ? t("plan.place", { place: place.map((v) => fixed(v, 2)).join(", ") }) : ""); });
    at("plan").addEventListener("pointerleave", () => put(at("plan-told"), ""));
    link.on("sitting", (sitting) => this.begin(sitting)).on("state", ({ control }) => this.show(control));
  }

  begin(sitting) {
    const [low, high] = sitting.frame;
    this.sitting = sitting;
    this.axes = [0, 1, 2].filter((axis) => axis !== (this.jog.decided ?? 2));
    const [a, b] = this.axes, wide = high[a] - low[a], tall = high[b] - low[b], edge = 0.04 * Math.max(wide, tall);
    this.size = Math.max(wide, tall);
    at("plan").setAttribute("viewBox", `${low[a] - edge} ${-high[b] - edge} ${wide + 2 * edge} ${tall + 2 * edge}`);
    const step = 10 ** Math.floor(Math.log10(this.size / LINES)) * [1, 2, 5, 10].find((each) => each * 10 ** Math.floor(Math.log10(this.size / LINES)) >= this.size / LINES);
    const grid = [];
    for (let x = Math.ceil(low[a] / step) * step; x <= high[a]; x += step) grid.push(drawn("line", { x1: x, x2: x, y1: -low[b], y2: -high[b], class: "grid" }));
    for (let y = Math.ceil(low[b] / step) * step; y <= high[b]; y += step) grid.push(drawn("line", { x1: low[a], x2: high[a], y1: -y, y2: -y, class: "grid" }));
    this.mark = drawn("circle", { r: 0.018 * this.size, class: "here" });
    const unit = drawn("text", { x: low[a] + 0.4 * edge, y: -low[b] - 0.4 * edge, "font-size": 0.035 * this.size });
    unit.textContent = `${"xyz"[a]} \u2192  ${"xyz"[b]} \u2191  ${fixed(step, step < 1 ? 2 : 0)} m`;
    at("plan").replaceChildren(drawn("rect", { x: low[a], y: -high[b], width: wide, height: tall, class: "frame" }), ...grid, unit, this.mark);
  }

  show(control) {
    if (!this.mark) return;
    const { here } = this.jog;
    this.mark.style.display = here && control?.sitting === this.sitting.sitting ? "" : "none";
    if (here) { this.mark.setAttribute("cx", here[this.axes[0]]); this.mark.setAttribute("cy", -here[this.axes[1]]); }
    at("plan").classList.toggle("grey", !this.jog.may);
  }

  place(event) { // under the pointer, at the present height; null where it is not known
    const { here } = this.jog, matrix = at("plan").getScreenCTM();
    if (!here || !matrix || !this.axes) return null;
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse()), [a, b] = this.axes;
    return this.jog.inPlane(here.with(a, x).with(b, -y));
  }

  click(event) { // to the millimetre, but for what a plane decides
    const place = this.place(event);
    if (place && this.jog.may) this.jog.go(this.jog.inPlane(place.map((v) => Number(v.toFixed(3)))));
  }
}
