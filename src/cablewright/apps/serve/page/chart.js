// The path error of the last minute. Gaps are where the machine did not print, or nothing was heard.
import { at, fixed, put, t } from "./words.js";

const KEPT = 60; // s

export class Chart {
  constructor(link) {
    this.points = [];
    link.on("sitting", () => { this.points = []; }).on("state", ({ control }) => control?.platform && this.add(control));
    setInterval(() => this.draw(), 200);
  }

  add({ time, error }) {
    if (this.points.length && time <= this.points.at(-1)[0]) return;
    this.points.push([time, error]);
    while (this.points[0][0] < time - KEPT) this.points.shift();
  }

  draw() {
    const canvas = at("chart"), { clientWidth: width, clientHeight: height } = canvas, scale = devicePixelRatio || 1, pen = canvas.getContext("2d");
    if (canvas.width !== Math.round(width * scale)) { canvas.width = Math.round(width * scale); canvas.height = Math.round(height * scale); }
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    const style = getComputedStyle(document.body), ink = (name) => style.getPropertyValue(name).trim();
    const known = this.points.filter(([, error]) => error !== null), most = Math.max(1e-3, ...known.map(([, error]) => Math.abs(error)));
    const top = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((each) => 1e3 * most <= each) ?? 1e3 * most, left = 54;
    const y = (mm) => height / 2 - (height / 2 - 12) * mm / top, now = this.points.at(-1)?.[0] ?? 0, x = (time) => left + (width - left - 4) * (1 + (time - now) / KEPT);
    pen.font = "12px system-ui, sans-serif"; pen.textAlign = "right"; pen.textBaseline = "middle"; pen.lineWidth = 1;
    for (const mm of [-top, 0, top]) {
      pen.strokeStyle = ink("--line"); pen.fillStyle = ink("--soft");
      pen.beginPath(); pen.moveTo(left, y(mm)); pen.lineTo(width, y(mm)); pen.stroke();
      pen.fillText(`${fixed(mm, 0)} mm`, left - 6, y(mm));
    }
    pen.strokeStyle = ink("--accent"); pen.lineWidth = 1.6; pen.beginPath();
    let joined = false;
    for (const [time, error] of this.points) {
      if (error === null) joined = false;
      else { pen[joined ? "lineTo" : "moveTo"](x(time), y(1e3 * error)); joined = true; }
    }
    pen.stroke();
    const last = known.at(-1);
    put(at("chart-told"), last ? t("chart.told", { mm: fixed(1e3 * most, 1) }) : t("chart.none"));
  }
}
